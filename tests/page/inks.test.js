// SPDX-License-Identifier: GPL-3.0-or-later
// Halftones in several inks.

import assert from "node:assert/strict";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";

import { download, isAccessible, run, settled, useBrowser } from "./harness.js";

const world = useBrowser();
const primary = ["#000000", "#00ffff", "#ff00ff", "#ffff00", "#ffffff"];
const field = (name) => world.page.locator(`#halftone [data-name=${name}]`);
const palette = () => world.page.getByRole("group", { name: "Palette" });

async function choose(inks, state = "done") {
  await field("color").locator("select").selectOption(inks);
  await settled(world.page, "halftone", state);
}

/** Returns the options of the request in the shown curl command. */
async function requestedOptions() {
  const curl = await world.page.textContent("#halftone pre");
  const { searchParams } = new URL(curl.match(/'(http[^']*\/halftone[^']*)'/)[1]);
  const { sites, antialias, ...others } = Object.fromEntries(searchParams);
  return others;
}

/** Returns the given colours that occur in the halftone. */
const seen = (colours) => world.page.locator("#halftone .stage canvas").evaluate((canvas, wanted) => {
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const values = new Set();
  for (let i = 0; i < data.length; i += 4) values.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
  return wanted.filter((colour) => values.has(parseInt(colour.slice(1), 16)));
}, colours);

/** Opens the page, and moves the divider so that only the halftone is visible. */
async function open() {
  await world.page.goto(`${world.url}/#halftone?sites=1500`);
  await settled(world.page, "halftone");
  await world.page.focus(".divider");
  await world.page.keyboard.press("Home");
}

test("mixes CMYK like print and RGB like light", async () => {
  await open();
  assert.deepEqual(await requestedOptions(), {});
  assert.deepEqual(await seen(primary), ["#000000", "#ffffff"]);
  await world.page.selectOption("#halftone [data-name=dots] select", "paper");
  await choose("cmyk");
  assert.deepEqual(await requestedOptions(), { color: "cmyk", dots: "ink" });  // dots of paper need grey
  for (const name of ["foreground", "palette"]) assert.ok(await field(name).isHidden(), name);
  assert.deepEqual(await seen(primary), primary);
  await field("background").locator("input[type=color]").fill("#fff4d6");
  await settled(world.page, "halftone");
  assert.deepEqual(await requestedOptions(), { color: "cmyk", dots: "ink", background: "#fff4d6" });
  await choose("rgb");
  assert.deepEqual(await requestedOptions(), { color: "rgb", dots: "ink" });
  assert.ok(await field("background").isHidden());
  assert.deepEqual(await seen(["#ff0000", "#00ff00", "#0000ff"]), ["#ff0000", "#00ff00", "#0000ff"]);
  await choose("palette");
  assert.equal((await requestedOptions()).dots, "ink");
  await choose("gray");
  assert.deepEqual(await requestedOptions(), { dots: "paper", background: "#fff4d6" });
});

test("accepts a palette of one to six inks", async () => {
  await open();
  await choose("palette");
  const wells = palette().locator("input");
  const more = palette().getByRole("button", { name: "Add another ink" });
  const less = (ink) => palette().getByRole("button", { name: `Remove ink ${ink}` });
  const inks = ["#0078bf", "#ff48b0", "#ffe800", "#000000"];
  assert.deepEqual(await requestedOptions(), { palette: inks.join(",") });
  assert.deepEqual(await seen(inks), inks);
  await less(2).click();
  await settled(world.page, "halftone");
  assert.deepEqual(await requestedOptions(), { palette: "#0078bf,#ffe800,#000000" });
  for (const number of [4, 5, 6]) {
    await more.click();
    assert.equal(await wells.count(), number);
  }
  assert.ok(await more.isDisabled());
  await settled(world.page, "halftone");
  assert.deepEqual(await requestedOptions(), { palette: "#0078bf,#ffe800,#000000,#ff48b0,#00a95c,#ff6c2f" });
  for (let left = 6; left > 1; --left) await less(left).click();
  assert.ok(await less(1).isHidden());
  await wells.first().fill("#b3123c");
  await settled(world.page, "halftone");
  assert.deepEqual(await requestedOptions(), { palette: "#b3123c" });
});

test("adds inks by name, and names the inks of the palette", async () => {
  await open();
  await choose("palette");
  const names = () => field("palette").locator(".hint").textContent();
  assert.equal(await names(), "Blue, Fluorescent pink, Yellow, Black");
  for (const name of ["Teal", "Sunflower", "Federal blue"]) {  // the seventh replaces the sixth
    await field("palette").locator("select").selectOption(name);
    await settled(world.page, "halftone");
  }
  assert.equal(await names(), "Blue, Fluorescent pink, Yellow, Black, Teal, Federal blue");
  assert.deepEqual(await requestedOptions(), { palette: "#0078bf,#ff48b0,#ffe800,#000000,#00838a,#3d5588" });
  await palette().getByLabel("Ink 1", { exact: true }).fill("#123456");
  await settled(world.page, "halftone");
  assert.match(await names(), /^#123456, Fluorescent pink, /);
});

test("reports an ink that occurs twice", async () => {
  await open();
  await choose("palette");
  await palette().getByLabel("Ink 2", { exact: true }).fill("#0078bf");
  await settled(world.page, "halftone", "failed");
  assert.match(await field("palette").locator(".error").textContent(), /colour 2 .*#0078bf/);
  assert.match(await world.page.textContent("#halftone .general"), /colour 2/);
});

test("shows a command that returns the same picture, and is accessible", async () => {
  const context = await world.newContext({ viewport: { width: 390, height: 844 }, bypassCSP: true });
  const page = await context.newPage();
  await page.goto(`${world.url}/#halftone?sites=1500`);
  await settled(page, "halftone");
  await page.selectOption("#halftone [data-name=color] select", "palette");
  await settled(page, "halftone");
  await isAccessible(page);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= 390);
  const folder = await mkdtemp(path.join(tmpdir(), "ccdt-page-"));
  await run("bash", ["-c", await page.textContent("#halftone pre")], { cwd: folder });
  const [, size] = (await page.textContent("#halftone .status")).match(/(\d+ \u00d7 \d+) pixels/);
  assert.match(await run("file", ["dots.png"], { cwd: folder }), new RegExp(`PNG image data, ${size.replace("\u00d7", "x")}, 8-bit`));
  await rm(folder, { recursive: true });
  await context.close();
});

test("saves an SVG with a layer for each ink", async () => {
  await open();
  await choose("cmyk");
  const labels = async () => {
    const svg = await readFile(await (await download(world.page, "halftone", "SVG")).path(), "utf8");
    return [...svg.matchAll(/inkscape:label="([^"]*)"/g)].map(([, label]) => label);
  };
  assert.deepEqual(await labels(), ["cyan", "magenta", "yellow"]);
  await field("dots").locator("select").selectOption("ink");
  await settled(world.page, "halftone");
  assert.deepEqual(await labels(), ["cyan", "magenta", "yellow", "black"]);
});

test("counts the dots of all inks in an analysis", async () => {
  await open();
  const sites = world.page.locator("#halftone [data-name=sites] input[type=number]");
  await sites.fill("2000");
  await sites.blur();
  await choose("cmyk");
  await world.page.click("#tab-analyze");
  await settled(world.page, "analyze");
  await world.page.selectOption("#source", "halftone");
  await settled(world.page, "analyze");
  assert.equal(await world.page.locator("#analyze tbody tr:first-child td:nth-child(2)").textContent(), "2,000");
});
