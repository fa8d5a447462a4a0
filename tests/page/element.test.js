// SPDX-License-Identifier: GPL-3.0-or-later
// Tests <ccdt-halftone> in a page of another origin than the server. firefox.test.js tests its main functions, too.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { after, before, test } from "node:test";

import { appearances, data, elementPage, isAccessible, serveOrigin, startServer, useBrowser } from "./harness.js";

const world = useBrowser();
const cat = path.join(data, "images/chelsea.png");

let origin;

before(async () => { origin = await serveOrigin((request) => pages[request] ?? elementPage(world.url)); });
after(() => origin.close());

const pages = {};

/** Adds an element to the page, and waits for its last event: load, error or abort. */
const show = (attributes) => world.page.evaluate((given) => new Promise((resolve) => {
  const element = Object.assign(document.createElement("ccdt-halftone"), { id: "dots" });
  for (const [name, value] of Object.entries(given)) element.setAttribute(name, value);
  window.progress = [];
  element.addEventListener("progress", ({ loaded }) => window.progress.push(loaded));
  for (const type of ["load", "error", "abort"]) element.addEventListener(type, ({ message }) => resolve({ type, message }));
  document.body.replaceChildren(element);
}), attributes);

/** Returns the visible state of the element. */
const seen = () => world.page.evaluate(async () => {
  const [picture, drawing, progress] = document.querySelector("#dots").shadowRoot.children;
  const bytes = !picture.hidden && [...new Uint8Array(await (await fetch(picture.src)).arrayBuffer())];
  let dark = 0;
  if (!drawing.hidden) {
    const { data: values } = drawing.getContext("2d").getImageData(0, 0, drawing.width, drawing.height);
    const light = (value) => (value <= 10 ? value / 3294.6 : ((value / 255 + 0.055) / 1.055) ** 2.4);
    for (let i = 0; i < values.length; i += 4) dark += 1 - (light(values[i]) + light(values[i + 1]) + light(values[i + 2])) / 3;
    dark /= values.length / 4;
  }
  const { width, height } = document.querySelector("#dots").getBoundingClientRect();
  return { bytes, dark, drawn: !drawing.hidden, working: !progress.hidden, width, height, alt: picture.alt };
});

test("shows the server's dots in place of the picture", async () => {
  await world.page.goto(origin.url);
  for (const options of [{ sites: "900" }, { sites: "900", color: "cmyk", antialias: "" }]) {
    assert.deepEqual(await show({ src: "/cat.png", alt: "A cat", ...options }), { type: "load", message: undefined });
    const { bytes, ...rest } = await seen();
    assert.deepEqual(rest, { dark: 0, drawn: false, working: false, width: 451, height: 300, alt: "A cat" });
    const query = new URLSearchParams({ ...options, width: 451, ...("antialias" in options && { antialias: true }) });
    const expected = await fetch(`${world.url}/halftone?${query}`, { method: "POST", body: await readFile(cat) });
    assert.deepEqual(Buffer.from(bytes), Buffer.from(await expected.arrayBuffer()));
  }
});

test("reports progress, and sends a new request when an option changes", async () => {
  await world.page.goto(origin.url);
  await show({ src: "/cat.png", sites: "30000" });
  const progress = await world.page.evaluate(() => window.progress);
  assert.ok(progress.some((percent) => percent > 0 && percent < 100), String(progress));
  assert.deepEqual(progress, [...progress].sort((a, b) => a - b));
  const before = (await seen()).bytes;
  await world.page.evaluate(() => new Promise((resolve) => {
    const element = document.querySelector("#dots");
    element.addEventListener("load", resolve);
    element.setAttribute("sites", "500");
    element.setAttribute("seed", "7");
  }));
  assert.notDeepEqual((await seen()).bytes, before);
});

test("cancels its job when it is aborted or removed from the page", async () => {
  await world.page.goto(origin.url);
  for (const end of ["abort", "remove"]) {
    const removed = world.page.waitForResponse((response) => response.request().method() === "DELETE");
    await world.page.evaluate((method) => {
      const element = document.createElement("ccdt-halftone");
      element.setAttribute("src", "/cat.png");
      element.setAttribute("sites", "500000");
      element.setAttribute("quality", "best");
      element.addEventListener("progress", () => element[method](), { once: true });
      window.ended = new Promise((resolve) => { element.addEventListener("abort", () => resolve("abort")); });
      document.body.replaceChildren(element);
    }, end);
    assert.equal(await world.page.evaluate(() => window.ended), "abort");
    const response = await removed;
    assert.equal(response.status(), 204);
    const { status } = await (await fetch(response.url())).json();
    assert.equal(status, "cancelled");
  }
});

test("keeps no picture in memory that is not shown", async () => {
  await world.page.goto(origin.url);
  const left = await world.page.evaluate(async () => {
    const [create, revoke, decode] = [URL.createObjectURL, URL.revokeObjectURL, Image.prototype.decode];
    const urls = new Set();
    URL.createObjectURL = (blob) => {
      const url = create(blob);
      urls.add(url);
      return url;
    };
    URL.revokeObjectURL = (url) => {
      urls.delete(url);
      revoke(url);
    };
    const element = document.createElement("ccdt-halftone");
    const event = (name) => new Promise((resolve) => element.addEventListener(name, resolve, { once: true }));
    const counts = [];
    element.setAttribute("src", "/cat.png");
    element.setAttribute("sites", "300");
    let ended = event("load");
    document.body.replaceChildren(element);
    await ended;
    counts.push(urls.size);
    let decoded;
    Image.prototype.decode = function () {  // aborts the request when its answer has arrived
      element.abort();
      decoded = decode.call(this);
      return decoded;
    };
    ended = event("abort");
    element.setAttribute("sites", "400");
    await ended;
    await decoded;
    Image.prototype.decode = decode;
    await new Promise((resume) => setTimeout(resume));
    counts.push(urls.size);
    ended = event("error");
    element.setAttribute("src", "/nothing.png");
    await ended;
    counts.push(urls.size);
    return counts;
  });
  assert.deepEqual(left, [1, 1, 0]);
});

test("draws dots itself if the server refuses or is unreachable", async () => {
  await world.page.goto(origin.url);
  const outcome = await show({ src: "/cat.png", sites: "0", alt: "A cat" });
  assert.equal(outcome.type, "error");
  assert.match(outcome.message, /^sites must be/);
  const { server, url } = await startServer([]);
  pages["/alone"] = elementPage(url);
  await world.page.goto(`${origin.url}/alone`);
  server.kill();
  const ofCat = 0.795;  // the mean of 1 - light, over pixels and channels
  const ofRed = (0.6038 + 0.0331) / 3;  // the light of #c30
  for (const [options, expected] of [[{}, ofCat], [{ color: "cmyk" }, ofCat], [{ color: "rgb" }, ofCat],
    [{ invert: "" }, ofCat], [{ foreground: "#c30" }, ofCat * (1 - ofRed)]]) {
    const { type } = await show({ src: "/cat.png", sites: "9000", ...options });
    assert.equal(type, "error");
    const { drawn, bytes, dark, working } = await seen();
    assert.deepEqual({ drawn, bytes, working }, { drawn: true, bytes: false, working: false });
    assert.ok(Math.abs(dark - expected) < 0.03, `${JSON.stringify(options)}: ${dark}`);
  }
});

test("draws up to all borders", async () => {
  const { server, url } = await startServer([]);
  pages["/bordered"] = elementPage(url);
  await world.page.goto(`${origin.url}/bordered`);
  server.kill();
  const light = await world.page.evaluate(async () => {
    const canvas = Object.assign(document.createElement("canvas"), { width: 203, height: 107 });
    const context = canvas.getContext("2d");
    context.fillStyle = "#bcbcbc";  // half the light of white
    context.fillRect(0, 0, 203, 107);
    const element = document.createElement("ccdt-halftone");
    element.setAttribute("src", URL.createObjectURL(await new Promise((take) => canvas.toBlob(take))));
    element.setAttribute("sites", "600");
    await new Promise((resolve) => {
      element.addEventListener("error", resolve);
      document.body.replaceChildren(element);
    });
    const drawing = element.shadowRoot.querySelector("canvas");
    const { width, height } = drawing;
    const { data } = drawing.getContext("2d").getImageData(0, 0, width, height);
    const light = (value) => (value <= 10 ? value / 3294.6 : ((value / 255 + 0.055) / 1.055) ** 2.4);
    const mean = (x, y, columns, rows) => {
      let sum = 0;
      for (let row = y; row < y + rows; ++row) for (let column = x; column < x + columns; ++column) sum += light(data[4 * (row * width + column)]);
      return sum / columns / rows;
    };
    return [mean(0, height - 6, width, 6), mean(width - 6, 0, 6, height), mean(0, 0, width, 6), mean(0, 0, 6, height)];
  });
  for (const one of light) assert.ok(Math.abs(one - 0.5) < 0.12, String(light));
});

test("maps image pixels to device pixels, also after a change of size", async () => {
  const context = await world.newContext({ deviceScaleFactor: 2 });
  const page = await context.newPage();
  await page.goto(origin.url);
  const queries = [];
  page.on("request", (one) => { if (one.url().includes("/halftone?")) queries.push(new URL(one.url()).searchParams); });
  /** Changes an element, and waits until its dots have loaded. */
  const loaded = (act) => page.evaluate(([script]) => new Promise((resolve) => {
    const element = document.querySelector("ccdt-halftone") ?? document.createElement("ccdt-halftone");
    element.addEventListener("load", () => {
      const picture = element.shadowRoot.querySelector("img");
      resolve([picture.naturalWidth, picture.clientWidth, element.clientWidth]);
    }, { once: true });
    new Function("element", script)(element);
  }), [act]);
  const begin = `for (const [name, value] of [["src", "/cat.png"], ["dots", "ink"], ["sites", "900"], ["dot", "1.5"]]) element.setAttribute(name, value);
    document.body.replaceChildren(element);`;
  assert.deepEqual(await loaded(begin), [902, 451, 451]);
  assert.deepEqual([queries[0].get("width"), queries[0].get("dot")], ["902", "3"]);
  const narrower = `for (const width of [300, 250, 200]) element.style.width = width + "px";`;
  assert.deepEqual(await loaded(narrower), [400, 200, 200]);
  assert.equal(queries.length, 2);
  const shown = await page.evaluate(() => {
    const element = document.querySelector("ccdt-halftone");
    element.style.width = "120px";
    const [picture, drawing] = element.shadowRoot.children;
    return [picture.hidden, drawing.hidden, picture.naturalWidth, picture.clientWidth <= 200];
  });
  assert.deepEqual(shown, [false, true, 400, true]);  // shown until other dots have loaded
  await context.close();
});

test("has the size of its attributes, fits the picture into it, and shows the pixels of a device", async () => {
  await world.page.goto(origin.url);
  const queries = [];
  world.page.on("request", (one) => { if (one.url().includes("/halftone?")) queries.push(Object.fromEntries(new URL(one.url()).searchParams)); });
  const sizes = [];
  for (const options of [{ width: "200", height: "160", fit: "cover", sites: "900" }, { width: "200", height: "160", sites: "900" },
    { width: "200", sites: "900" }, { height: "150", sites: "900" }, { width: "200", height: "160", device: "spectra6", fit: "cover" }]) {
    assert.equal((await show({ src: "/cat.png", ...options })).type, "load");
    const { width, height, drawn } = await seen();
    sizes.push([width, Math.round(height), drawn]);
  }
  assert.deepEqual(sizes, [[200, 160, false], [200, 160, false], [200, 133, false], [225, 150, false], [200, 160, false]]);
  assert.deepEqual(queries.map(({ width, height, fit, device }) => [width, height, fit, device]), [["200", "160", "cover", undefined],
    ["200", "160", undefined, undefined], ["200", undefined, undefined, undefined], [queries[3].width, undefined, undefined, undefined], ["200", "160", "cover", "spectra6"]]);
});

test("reserves its size, and requests dots near the visible part only if it is lazy", async () => {
  const { page } = world;
  await page.goto(origin.url);
  const asked = [];
  page.on("request", (one) => { if (/cat\.png/.test(one.url())) asked.push(one.url()); });
  const before = await page.evaluate(async () => {
    document.body.innerHTML = `<div style="height: 5000px"></div><ccdt-halftone id="dots" src="/cat.png" sites="900" width="300" height="200" loading="lazy"></ccdt-halftone>`;
    const dots = document.querySelector("#dots");
    window.loaded = new Promise((resolve) => dots.addEventListener("load", () => resolve(dots.getBoundingClientRect().height)));
    await new Promise((resume) => setTimeout(resume, 300));
    return dots.getBoundingClientRect().height;
  });
  assert.deepEqual([before, asked], [200, []]);
  await page.evaluate(() => document.querySelector("#dots").scrollIntoView());
  assert.equal(await page.evaluate(() => window.loaded), 200);
  assert.equal(asked.length, 1);
});

test("shows errors of options, and the whole text of a missing picture", async () => {
  const { page } = world;
  await page.goto(origin.url);
  const message = page.locator("#dots p");
  await show({ src: "/cat.png", sites: "nonsense" });
  assert.equal(await message.textContent(), "sites must be an integer from 1 to 2000000");
  assert.ok(await message.isVisible());
  await page.evaluate(() => new Promise((resolve) => {
    document.querySelector("#dots").addEventListener("load", resolve);
    document.querySelector("#dots").setAttribute("sites", "900");
  }));
  assert.ok(await message.isHidden());
  await show({ src: "/nothing.png", sites: "500", alt: "A cat with long whiskers" });
  assert.ok(await message.isHidden());
  const { width, height } = await page.locator("#dots img").boundingBox();
  assert.ok(width > 120 && height >= 14, `${width} ${height}`);
});

test("removes outdated dots, and shows an unreadable picture unchanged", async () => {
  await world.page.goto(origin.url);
  await show({ src: "/cat.png", sites: "500" });
  const end = await world.page.evaluate(() => new Promise((resolve) => {
    const element = document.querySelector("#dots");
    element.addEventListener("error", ({ message }) => resolve(message));
    element.setAttribute("src", "/nothing.png");
  }));
  assert.match(end, /nothing\.png was answered with status 404/);
  const shown = await world.page.evaluate(() => document.querySelector("#dots").shadowRoot.children[0].src);
  assert.equal(shown, `${origin.url}/nothing.png`);
});

test("loads a missing picture only once, whatever the width", async () => {
  await world.page.goto(origin.url);
  const fetched = [];
  world.page.on("request", (request) => { if (request.url().endsWith("/nothing.png") && request.resourceType() === "fetch") fetched.push(request); });
  const { type } = await show({ src: "/nothing.png", sites: "500", alt: "A cat" });
  assert.equal(type, "error");
  await world.page.evaluate(async () => {
    document.querySelector("#dots").style.width = "222px";
    await new Promise((resume) => setTimeout(resume, 600));  // more than the delay of the element after a change of size
  });
  assert.equal(fetched.length, 1);
});

test("is accessible: dots, its own drawing, and a picture that it cannot decode", async () => {
  for (const { colorScheme, size, viewport, tags } of appearances) {
    await world.page.emulateMedia({ colorScheme });
    await world.page.setViewportSize(viewport);
    await world.page.goto(origin.url);
    await world.page.addStyleTag({ content: ":root { color-scheme: light dark; }" });
    for (const [source, sites, end] of [["/cat.png", "500", "load"], ["/cat.png", "0", "error"], ["/nothing.png", "500", "error"]]) {
      const { type } = await show({ src: source, sites, alt: "A cat" });
      assert.equal(type, end);
      await isAccessible(world.page, { where: "#dots", tags, about: `${source}, ${sites} dots: ${colorScheme}, ${size}` });
    }
    assert.ok(await world.page.evaluate(() => document.documentElement.scrollWidth) <= viewport.width);
  }
});
