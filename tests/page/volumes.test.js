// SPDX-License-Identifier: GPL-3.0-or-later
// Points in space in the panel Sample: the view, requests, downloads, a density of voxels, and the analysis.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";

import { download, looksAsKept, pageWithoutWebgl, settled, useBrowser } from "./harness.js";

const world = useBrowser();
const frame = (page = world.page) => page.locator("#sample .canvas-frame");
const request = () => world.page.textContent("#sample pre");

async function open(page = world.page) {
  await page.goto(`${world.url}/#sample?shape=space&sites=300`);
  await settled(page, "sample");
}

/** Returns an NPY file with an array of bytes, whose first layer is empty. */
function voxels(depth, height, width) {
  const header = `{'descr': '|u1', 'fortran_order': False, 'shape': (${depth}, ${height}, ${width}), }`.padEnd(117) + "\n";
  const bytes = Buffer.alloc(depth * height * width, 1).fill(0, 0, height * width);
  return Buffer.concat([Buffer.from("\x93NUMPY\x01\x00\x76\x00", "latin1"), Buffer.from(header), bytes]);
}

test("shows points in a torus in space, and turns them", async () => {
  await open();
  const { page } = world;
  assert.match(await page.textContent("#sample .status"), /^300 points, [\d.]+ s/);
  assert.match(await request(), /"domain":\{"type":"torus","width":1,"height":1,"depth":1\}/);
  await looksAsKept(world, frame(), "volume");
  const first = await frame().screenshot();
  await page.click('#sample .zoom.of-surfaces button[aria-label="Turn left"]');
  await settled(page, "sample");
  assert.ok(!first.equals(await frame().screenshot()));
});

test("looks the same without WebGL", async () => {
  const page = await pageWithoutWebgl(world);
  await open(page);
  await looksAsKept(world, frame(page), "volume");
  await page.context().close();
});

test("offers the options and formats of points in space", async () => {
  await open();
  const { page } = world;
  const formats = () => page.locator("#sample .download option").evaluateAll((all) => all.map(({ value }) => value));
  assert.deepEqual(await formats(), ["csv", "npy", "ply", "vtu", "json"]);
  for (const selector of ["[data-name=method]", "#iteration"]) assert.ok(await page.isHidden(`#sample ${selector}`), selector);
  await page.check("#mesh");
  await settled(page, "sample");
  assert.ok((await formats()).includes("msh"));
  await page.uncheck("#mesh");
  await page.selectOption("#shape", "box");
  await page.fill("#sample [data-name=volume] input >> nth=2", "0.5");
  await page.locator("#sample [data-name=volume] input").nth(2).blur();
  await settled(page, "sample");
  assert.equal(await page.evaluate(() => location.hash), "#sample?shape=box&volume=1%2C1%2C0.5&sites=300");
  const { points } = JSON.parse(await readFile(await (await download(page, "sample", "JSON")).path()));
  assert.equal(points.length, 300);
  assert.ok(points.every(([, , z]) => z > 0 && z < 0.5));
  await page.fill("#sample [data-name=volume] input >> nth=2", "1e-301");
  await page.locator("#sample [data-name=volume] input").nth(2).blur();
  await settled(page, "sample", "failed");
  assert.notEqual(await page.textContent("#shape-error"), "");
});

test("takes the sides of voxels from every shape before", async () => {
  const { page } = world;
  for (const shape of ["", "?shape=polygon", "?shape=rectangle&rectangle=3,2", "?shape=knot.obj"]) {
    await page.goto("about:blank");
    await page.goto(`${world.url}/#sample${shape}`);
    await settled(page, "sample");
    await page.setInputFiles("#sample .file", { name: "density.npy", mimeType: "", buffer: voxels(8, 16, 16) });
    await settled(page, "sample");
    assert.match(await request(), /domain=box&width=16&height=16&depth=8/);
    assert.deepEqual(await page.locator("#sample [data-name=volume] input").evaluateAll((all) => all.map(({ value }) => value)), ["16", "16", "8"]);
  }
});

test("takes voxels as the density, and analyzes the points", async () => {
  await open();
  const { page } = world;
  await page.setInputFiles("#sample .file", { name: "density.npy", mimeType: "", buffer: voxels(2, 3, 4) });
  await settled(page, "sample");
  assert.match(await request(), /--data-binary '@density\.npy'.*sample\?sites=300&.*domain=torus&width=4&height=3&depth=2/s);
  const { points } = JSON.parse(await readFile(await (await download(page, "sample", "JSON")).path()));
  assert.ok(points.every(([x, y, z]) => x <= 4 && y <= 3 && z >= 1 && z <= 2));
  await page.click("#tab-analyze");
  await settled(page, "analyze");
  assert.match(await page.textContent("#analyze .note"), /measured in space/);
  assert.equal(await page.locator("#analyze tbody tr").count(), 1);
  assert.equal(await page.locator("#analyze .spectra canvas").count(), 1);
});
