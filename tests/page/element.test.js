// <ccdt-halftone> in a page of another origin than the server's; firefox.test.js has the gist of it, too.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { after, before, test } from "node:test";

import { axe, data, elementPage, serveOrigin, startServer, useBrowser } from "./harness.js";

const world = useBrowser();
const cat = path.join(data, "images/chelsea.png");

let origin;

before(async () => { origin = await serveOrigin((request) => pages[request] ?? elementPage(world.url)); });
after(() => origin.close());

const pages = {};

/** Puts an element into the page, and waits for what it says in the end: load, error or abort. */
const show = (attributes) => world.page.evaluate((given) => new Promise((resolve) => {
  const element = Object.assign(document.createElement("ccdt-halftone"), { id: "dots" });
  for (const [name, value] of Object.entries(given)) element.setAttribute(name, value);
  window.told = [];
  element.addEventListener("progress", ({ loaded }) => window.told.push(loaded));
  for (const type of ["load", "error", "abort"]) element.addEventListener(type, ({ message }) => resolve({ type, message }));
  document.body.replaceChildren(element);
}), attributes);

/** What is seen of it. */
const seen = () => world.page.evaluate(async () => {
  const [picture, drawing, progress] = document.querySelector("#dots").shadowRoot.children;
  const bytes = !picture.hidden && [...new Uint8Array(await (await fetch(picture.src)).arrayBuffer())];
  let dark = 0;
  if (!drawing.hidden) {
    const { data: values } = drawing.getContext("2d").getImageData(0, 0, drawing.width, drawing.height);
    for (let i = 0; i < values.length; i += 4) dark += 1 - (values[i] + values[i + 1] + values[i + 2]) / 765;
    dark /= values.length / 4;
  }
  const { width, height } = document.querySelector("#dots").getBoundingClientRect();
  return { bytes, dark, drawn: !drawing.hidden, working: !progress.hidden, width, height, alt: picture.alt };
});

test("shows the server's dots in the place of the picture", async () => {
  await world.page.goto(origin.url);
  for (const options of [{ sites: "900" }, { sites: "900", color: "cmyk", antialias: "" }]) {
    assert.deepEqual(await show({ src: "/cat.png", alt: "A cat", ...options }), { type: "load", message: undefined });
    const { bytes, ...rest } = await seen();
    assert.deepEqual(rest, { dark: 0, drawn: false, working: false, width: 451, height: 300, alt: "A cat" });
    const query = new URLSearchParams({ ...options, ...("antialias" in options && { antialias: true }) });
    const expected = await fetch(`${world.url}/halftone?${query}`, { method: "POST", body: await readFile(cat) });
    assert.deepEqual(Buffer.from(bytes), Buffer.from(await expected.arrayBuffer()));
  }
});

test("tells how far it is, and asks again once an option is another", async () => {
  await world.page.goto(origin.url);
  await show({ src: "/cat.png", sites: "80000" });
  const told = await world.page.evaluate(() => window.told);
  assert.ok(told.some((percent) => percent > 0 && percent < 100), String(told));
  assert.deepEqual(told, [...told].sort((a, b) => a - b));
  const before = (await seen()).bytes;
  await world.page.evaluate(() => new Promise((resolve) => {
    const element = document.querySelector("#dots");
    element.addEventListener("load", resolve);
    element.setAttribute("sites", "500");
    element.setAttribute("seed", "7");
  }));
  assert.notDeepEqual((await seen()).bytes, before);
});

test("ends its job once it is aborted or taken out of the page", async () => {
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

test("draws dots itself where the server refuses, or is not there", async () => {
  await world.page.goto(origin.url);
  const told = await show({ src: "/cat.png", sites: "0", alt: "A cat" });
  assert.equal(told.type, "error");
  assert.match(told.message, /^sites must be/);
  const { server, url } = await startServer([]);
  pages["/alone"] = elementPage(url);
  await world.page.goto(`${origin.url}/alone`);
  server.kill();
  const ofCat = 0.795;  // the mean of 1 - light, over pixels and channels
  for (const [options, expected] of [[{}, ofCat], [{ color: "cmyk" }, ofCat], [{ color: "rgb" }, ofCat],
    [{ invert: "" }, ofCat], [{ foreground: "#c30" }, (ofCat * 2) / 3]]) {
    const { type } = await show({ src: "/cat.png", sites: "9000", ...options });
    assert.equal(type, "error");
    const { drawn, bytes, dark, working } = await seen();
    assert.deepEqual({ drawn, bytes, working }, { drawn: true, bytes: false, working: false });
    assert.ok(Math.abs(dark - expected) < 0.03, `${JSON.stringify(options)}: ${dark}`);
  }
});

test("shows nothing stale, and what it cannot read as it is", async () => {
  await world.page.goto(origin.url);
  await show({ src: "/cat.png", sites: "500" });
  const end = await world.page.evaluate(() => new Promise((resolve) => {
    const element = document.querySelector("#dots");
    element.addEventListener("error", ({ message }) => resolve(message));
    element.setAttribute("src", "/nothing.png");
  }));
  assert.match(end, /nothing\.png was answered 404/);
  const shown = await world.page.evaluate(() => document.querySelector("#dots").shadowRoot.children[0].src);
  assert.equal(shown, `${origin.url}/nothing.png`);
});

test("is accessible", async () => {
  await world.page.goto(origin.url);
  await show({ src: "/cat.png", sites: "500", alt: "A cat" });
  await world.page.addScriptTag({ path: axe });
  const found = await world.page.evaluate(() => window.axe.run("#dots"));
  assert.deepEqual(found.violations.map(({ id, nodes }) => [id, nodes.map(({ html }) => html)]), []);
});
