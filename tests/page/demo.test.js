// SPDX-License-Identifier: GPL-3.0-or-later
// The page of static files that server/page/demo/make makes, without any other host.

import assert from "node:assert/strict";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { after, before, test } from "node:test";

import { data, isAccessible, launchChromium, patience, run, serveOrigin, slide } from "./harness.js";

let folder, origin, browser;

before(async () => {
  folder = await mkdtemp(path.join(tmpdir(), "ccdt-demo-"));
  await run(path.resolve(import.meta.dirname, "../../server/page/demo/make"), [folder]);
  origin = await serveOrigin((address) => readFile(path.join(folder, address === "/" ? "index.html" : address)));
  browser = await launchChromium("--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream");
});

after(async () => {
  await browser.close();
  origin.close();
  await rm(folder, { recursive: true });
});

test("a page of static files computes halftones and points, also offline", async () => {
  const context = await browser.newContext({ bypassCSP: false });
  const page = await context.newPage();
  page.setDefaultTimeout(patience);
  const faults = [], foreign = [];
  page.on("pageerror", (error) => faults.push(String(error)));
  page.on("console", (message) => { if (message.type() === "error") faults.push(message.text()); });
  await context.route("**", (route) => {
    const isOwn = route.request().url().startsWith(origin.url);
    if (!isOwn) foreign.push(route.request().url());
    return isOwn ? route.continue() : route.abort();
  });
  await page.goto(origin.url);
  const told = (section, text) => page.locator(`section:nth-of-type(${section}) [role=status]`, { hasText: text }).waitFor();
  await told(1, /^6,000 dots, computed in this browser in \d+ ms$/);
  await told(2, /^1,000 points, computed in this browser in \d+ ms$/);
  await page.evaluate(() => navigator.serviceWorker.ready);
  await page.reload();  // the service worker answers from now on
  await told(1, /^6,000 dots/);
  await context.setOffline(true);
  await page.reload();
  await told(1, /^6,000 dots/);
  await slide(page.locator("section:nth-of-type(1) [name=sites]"), [900, 1200, 1500]);
  await told(1, /^1,500 dots/);
  await slide(page.locator("section:nth-of-type(2) [name=sites]"), [2000, 2500]);
  await told(2, /^2,500 points/);
  await page.setInputFiles("[name=file]", path.join(data, "images/camera.png"));
  await page.waitForFunction(() => {
    const [picture] = document.querySelector("ccdt-halftone").shadowRoot.children;
    return picture.naturalWidth > 0 && picture.naturalWidth === picture.naturalHeight;  // the camera man, not the cat
  });
  const svg = await page.evaluate(async () => (await fetch(document.querySelector("a[download]").href)).text());
  assert.match(svg, /^<\?xml|^<svg/);
  await page.click("[name=camera]");
  await page.waitForFunction(() => document.querySelector("ccdt-halftone").getAttribute("src") === "#camera");
  for (let frame = 0; frame < 2; ++frame)
    await page.evaluate(() => new Promise((resolve) => document.querySelector("ccdt-halftone").addEventListener("load", resolve, { once: true })));
  assert.deepEqual([faults, foreign], [[], []]);
  await context.close();
});

test("the page of static files is accessible", async () => {
  const page = await (await browser.newContext({ bypassCSP: true })).newPage();
  await page.goto(origin.url);
  await page.locator("section:nth-of-type(1) [role=status]", { hasText: "dots" }).waitFor();
  await isAccessible(page);
});
