// SPDX-License-Identifier: GPL-3.0-or-later
// The panels in Debian's Firefox.

import assert from "node:assert/strict";
import { once } from "node:events";
import { createRequire } from "node:module";
import path from "node:path";
import { after, afterEach, before, beforeEach, test } from "node:test";

import { closeAtLimit, elementPage, patience, serveOrigin, startServer } from "./harness.js";

const require = createRequire(path.join(process.env.CCDT_NODE_MODULES, "of-the-tests"));
const puppeteer = require("puppeteer-core");

let running, browser, page, faults, gone;

before(async () => {
  running = await startServer([]);
  browser = await puppeteer.launch({ browser: "firefox", executablePath: process.env.CCDT_FIREFOX, timeout: patience });
  closeAtLimit(() => browser.process().kill("SIGKILL"));
});
after(async () => {
  await browser.close();
  running.server.kill();
  await once(running.server, "exit");
});
beforeEach(async () => {
  page = await browser.newPage();
  await page.setViewport({ width: 1280, height: 860 });
  page.setDefaultTimeout(patience);
  faults = [];
  gone = null;
  const blame = (fault) => { if (!gone || !fault.includes(gone)) faults.push(fault); };  // the ended server causes errors
  page.on("pageerror", (error) => blame(String(error)));
  page.on("console", (message) => { if (message.type() === "error") blame(message.text()); });
});
afterEach(async () => {
  await page.close();
  assert.deepEqual(faults, []);
});

const textOf = (selector) => page.$eval(selector, (element) => element.textContent);

async function show(panel, settings = "") {
  await page.goto(`${running.url}/#${panel}${settings}`);
  await page.waitForSelector(`#${panel}[data-state=done]`);
}

/** Returns the share of a canvas that is dark. */
const darkness = (selector) => page.$eval(selector, (canvas) => {
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let dark = 0;
  for (let i = 0; i < data.length; i += 4) dark += data[i + 3] > 128 && data[i] < 64;
  return dark / (data.length / 4);
});

test("makes a halftone, and shows the progress of a large one", async () => {
  await show("halftone");
  assert.match(await textOf("#halftone .status"), /^20,000 dots/);
  assert.ok(await darkness("#halftone canvas") > 0.2);
  await page.focus("#halftone canvas");
  for (let i = 0; i < 12; ++i) await page.keyboard.press("+");
  await page.waitForFunction(() => {  // enlarged pixels are grey, but dots have thin grey edges
    const canvas = document.querySelector("#halftone canvas");
    const { data } = canvas.getContext("2d").getImageData(canvas.width / 2, 0, canvas.width / 2, canvas.height);
    let grey = 0;
    for (let i = 0; i < data.length; i += 4) if (data[i] > 30 && data[i] < 225) ++grey;
    return grey < data.length / 4 * 0.03;
  });
  await page.evaluate(() => {
    const bar = document.querySelector("#halftone progress");
    window.shown = [];
    new MutationObserver(() => window.shown.push(bar.value)).observe(bar, { attributes: true });
  });
  const [sites] = await page.$$("#halftone [data-name=sites] input[type=number]");
  await sites.click({ count: 3 });
  await sites.type("45000");
  await page.keyboard.press("Tab");
  await page.waitForFunction(() => /^45,000 dots/.test(document.querySelector("#halftone .status").textContent));
  assert.ok((await page.evaluate(() => window.shown)).some((percent) => percent > 0 && percent < 100));
});

test("drafts a large photograph from a reduced one", async () => {
  await show("halftone");
  const sent = await page.evaluate(async () => {
    const panel = document.getElementById("halftone");
    const done = () => new Promise((resolve) => {
      const look = () => (panel.dataset.state === "done" ? resolve() : requestAnimationFrame(look));
      look();
    });
    const canvas = Object.assign(document.createElement("canvas"), { width: 1500, height: 1000 });
    canvas.getContext("2d").fillRect(300, 200, 600, 500);
    const transfer = new DataTransfer();
    transfer.items.add(new File([await new Promise((take) => canvas.toBlob(take))], "large.png", { type: "image/png" }));
    panel.querySelector(".drop").dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true }));
    await done();
    const send = window.fetch;
    const bodies = [];
    window.fetch = (url, options) => {
      bodies.push(options.body);
      return send(url, options);
    };
    const slider = panel.querySelector("[data-name=detail] input[type=range]");
    slider.value = 0.2;
    for (const name of ["input", "change"]) {
      slider.dispatchEvent(new Event(name, { bubbles: true }));
      if (name === "input") await done();
    }
    await done();
    window.fetch = send;
    return Promise.all(bodies.map(async (body) => (await createImageBitmap(body)).width));
  });
  assert.deepEqual(sent, [670, 1500]);
});

test("shows a picture in the colours that are seen on a device", async () => {
  await show("devices", "?device=bwr&width=201&height=121");
  const { types } = (await (await fetch(`${running.url}/capabilities`)).json()).halftone.devices;
  const { sizes, colours } = await page.$eval("#devices .exact canvas", (canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const found = new Set();
    for (let i = 0; i < data.length; i += 4) found.add(`#${[...data.slice(i, i + 3)].map((value) => value.toString(16).padStart(2, "0")).join("")}`);
    return { sizes: [canvas.width, canvas.height, canvas.clientWidth, canvas.clientHeight], colours: [...found] };
  });
  assert.deepEqual(sizes, [201, 121, 804, 484]);  // whole pixels of the screen
  assert.deepEqual(colours.sort(), types.find(({ name }) => name === "bwr").seen.toSorted());
});

test("opens at an address, and goes back to it", async () => {
  await page.goto(`${running.url}/#halftone?picture=cat.jpg&sites=900&plotter=on&pen_mm=3`);
  await page.waitForSelector("#halftone[data-state=done]");
  assert.match(await textOf("#halftone .figures p"), /^277 .*900 dots in 1 layer/);
  await page.click("#tab-sample");
  await page.waitForSelector("#sample[data-state=done]");
  await page.goBack();
  await page.waitForSelector("#halftone:not([hidden])");
  assert.equal(await page.evaluate(() => location.hash), "#halftone?picture=cat.jpg&sites=900&plotter=on&pen_mm=3");
});

test("fills a polygon drawn with the mouse", async () => {
  await show("sample", "?shape=polygon");
  assert.match(await textOf("#sample .status"), /^1,000 points/);
  await page.click("#sample .draw");
  const { x, y, width, height } = await (await page.$("#sample canvas")).boundingBox();
  for (const [across, down] of [[0.3, 0.2], [0.7, 0.2], [0.5, 0.8]]) await page.mouse.click(x + across * width, y + down * height);
  await page.keyboard.press("Enter");
  await page.waitForSelector("#sample[data-state=done]");
  assert.equal(JSON.parse(await page.$eval("#corners", (field) => field.value)).polygon.length, 3);
  assert.ok(await darkness("#sample canvas") > 0.03);
});

test("shows points on a surface without WebGL", async () => {
  await page.evaluateOnNewDocument(() => {
    const { getContext } = HTMLCanvasElement.prototype;
    HTMLCanvasElement.prototype.getContext = function (kind, ...others) {
      return kind === "webgl2" ? null : getContext.call(this, kind, ...others);
    };
  });
  await show("sample", "?shape=knot.obj");
  assert.match(await textOf("#sample .status"), /^1,000 points/);
  const canvas = "#sample canvas.of-surfaces";
  const picture = () => page.$eval(canvas, (element) => new Promise((take) => { requestAnimationFrame(() => requestAnimationFrame(() => take(element.toDataURL()))); }));
  const before = await picture();
  assert.ok(await darkness(canvas) > 0.03);
  await page.focus(canvas);
  await page.keyboard.press("ArrowRight");
  assert.notEqual(await picture(), before);
});

test("puts dots into a page of another origin, and draws them itself once the server is gone", async () => {
  const alone = await startServer([]);
  const origin = await serveOrigin(() => elementPage(alone.url));
  const show = (sites) => page.evaluate((wanted) => new Promise((resolve) => {
    const element = document.createElement("ccdt-halftone");
    element.setAttribute("src", "/cat.png");
    element.setAttribute("sites", wanted);
    const progress = [];
    element.addEventListener("progress", ({ loaded }) => progress.push(loaded));
    for (const type of ["load", "error"]) {
      element.addEventListener(type, () => resolve({ type, progress, shown: [...element.shadowRoot.children].map(({ hidden }) => !hidden) }));
    }
    document.body.replaceChildren(element);
  }), sites);
  await page.goto(origin.url);
  const { type, progress, shown } = await show("45000");
  assert.deepEqual([type, shown[0], shown[1]], ["load", true, false]);
  assert.ok(progress.some((percent) => percent > 0 && percent < 100), String(progress));
  gone = alone.url;
  alone.server.kill();
  await once(alone.server, "exit");
  const { type: end, shown: left } = await show("900");
  assert.deepEqual([end, left[0], left[1]], ["error", false, true]);
  origin.close();
});

test("analyzes points", async () => {
  await show("sample", "?shape=polygon");
  await page.click("#tab-analyze");
  await page.waitForSelector("#analyze[data-state=done]");
  const names = await page.$$eval("#analyze tbody th", (cells) => cells.map((cell) => cell.textContent));
  assert.ok(names.length > 2, String(names));
  assert.equal((await page.$$("#analyze .power polyline")).length, names.length);
});
