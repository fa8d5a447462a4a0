// SPDX-License-Identifier: GPL-3.0-or-later
// Analyses of points and dots, compared with the points of each method.

import assert from "node:assert/strict";
import { test } from "node:test";

import { looksAsKept, settled, useBrowser } from "./harness.js";

const world = useBrowser();

const rows = () => world.page.locator("#analyze tbody tr").evaluateAll((all) =>
  all.map((row) => [...row.cells].map((cell) => cell.textContent)));

test("analyzes points of the plane and compares them", async () => {
  await world.page.goto(`${world.url}/#sample?shape=polygon`);
  await settled(world.page, "sample");
  await world.page.selectOption("#shape", "torus");
  await settled(world.page, "sample");
  await world.page.click("#tab-analyze");
  await settled(world.page, "analyze");
  const found = await rows();
  const { methods } = (await (await fetch(`${world.url}/capabilities`)).json()).sample;
  assert.deepEqual(found.map(([name]) => name), ["These points", ...methods.map(({ title }) => title).reverse()]);
  const [made, noise] = found.map((cells) => cells.slice(1).map((cell) => Number(cell.replace(",", ""))));
  assert.equal(made[0], 1000);
  assert.ok(made[3] < 0.01 && noise[3] > 0.5 && noise[3] < 1.5, String([made, noise]));
  assert.ok(made[1] > 0.7 && noise[1] < 0.2);
  await looksAsKept(world, world.page.locator("#analyze .spectra"), "analyze-spectra");
  await looksAsKept(world, world.page.locator("#analyze .power"), "analyze-power");
});

test("analyzes the largest square inside a polygon", async () => {
  await world.page.goto(`${world.url}/#sample?shape=polygon`);
  await settled(world.page, "sample");
  await world.page.click("#tab-analyze");
  await settled(world.page, "analyze");
  const [[, number]] = await rows();
  assert.ok(Number(number) > 100 && Number(number) < 400, number);
  assert.match(await world.page.textContent("#analyze .note"), /largest square/);
});

test("analyzes too many points for a spectrum", async () => {
  await world.page.goto(`${world.url}/#sample?shape=torus&sites=140000&quality=draft&iteration=1`);
  await settled(world.page, "sample");
  assert.match(await world.page.textContent("#sample .status"), /^140,000 points/);
  await world.page.click("#tab-analyze");
  await settled(world.page, "analyze");
  const [made] = await rows();
  assert.equal(made[1], "140,000");
  assert.ok(Number(made[4]) < 0.1, made[4]);
  const { methods } = (await (await fetch(`${world.url}/capabilities`)).json()).sample;
  assert.equal(await world.page.locator("#analyze .spectra canvas").count(), methods.length);
  assert.equal(await world.page.textContent("#analyze .spectra figure.curve-0"), "These points");
  assert.match(await world.page.textContent("#analyze .note"), /too many points/);
});

test("analyzes the dots of a picture", async () => {
  await world.page.goto(`${world.url}/#halftone?sites=2000`);
  await settled(world.page, "halftone");
  await world.page.click("#tab-analyze");
  await settled(world.page, "analyze");
  await world.page.selectOption("#source", "halftone");
  await settled(world.page, "analyze");
  assert.equal((await rows())[0][1], "2,000");
});
