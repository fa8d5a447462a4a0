// SPDX-License-Identifier: GPL-3.0-or-later
// The page offers all options of the server's routes, and explains those that need it.

import assert from "node:assert/strict";
import { mkdtempSync } from "node:fs";
import { readFile, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";

import { data, download, run, settled, useBrowser } from "./harness.js";

const world = useBrowser();
const folder = mkdtempSync(path.join(tmpdir(), "ccdt-page-"));
const snippet = () => world.page.textContent("#sample pre");
const request = async () => JSON.parse((await snippet()).match(/-d '(.*)' \\|<<'END'\n(.*)\nEND/s).slice(1).find(Boolean));

async function open(address) {
  await world.page.goto(`${world.url}/${address}`);
  await settled(world.page, address.match(/\w+/)[0]);
}

/**
 * Options without a field of the same name. They are older names, shapes, downloads, controls beside the picture, the
 * properties that a map counts, what is drawn around a map, and the pen, which has two fields.
 */
const elsewhere = {
  halftone: ["format", "invert", "pen"],
  devices: [],
  sample: ["polygon", "holes", "geometry", "classes", "object", "iterations", "legend", "mesh", "outlines", "pen"],
  surfaces: ["iterations", "mesh"],
};

test("has a field for each option", async () => {
  const offered = await (await fetch(`${world.url}/capabilities`)).json();
  for (const [panel, others] of Object.entries(elsewhere)) {
    const place = panel === "surfaces" ? "sample" : panel;
    await open(`#${place}`);
    const names = await world.page.locator(`#${place} .field`).evaluateAll((fields) => fields.map(({ dataset }) => dataset.name));
    const { options } = panel === "devices" ? offered.halftone.devices : panel === "surfaces" ? offered.sample.surfaces : offered[panel];
    assert.deepEqual(options.filter((name) => !names.includes(name)).sort(), others.sort());
  }
});

test("sets scale, passes, and what happens at the deadline", async () => {
  await open("#halftone?sites=500");
  const { page } = world;
  await page.click("#halftone .more summary");
  const more = (name) => page.locator(`#halftone .more [data-name=${name}]`);
  await more("on_deadline").locator("select").selectOption("partial");
  await more("passes").locator("input[type=number]").fill("2");
  await more("scale").locator("input[type=checkbox]").uncheck();
  await more("scale").locator("input[type=number]").fill("0.5");
  await more("scale").locator("input[type=number]").blur();
  await settled(page, "halftone");
  assert.match(await page.textContent("#halftone .status"), /256 \u00d7 256 pixels/);
  const { searchParams } = new URL((await page.textContent("#halftone pre")).match(/'(http[^']*halftone[^']*)'/)[1]);
  assert.deepEqual(Object.fromEntries(searchParams), { sites: "500", antialias: "true", scale: "0.5", passes: "2", on_deadline: "partial" });
  await more("scale").locator("input[type=number]").fill("99");
  await more("scale").locator("input[type=number]").blur();
  await settled(page, "halftone", "failed");
  assert.match(await more("scale").locator(".error").textContent(), /0\.1 to 16/);
});

test("fits a picture into a width and a height", async () => {
  const size = async () => (await world.page.textContent("#halftone .status")).match(/(\d+) \u00d7 (\d+) pixels/).slice(1).map(Number);
  await open("#halftone?picture=cat.jpg&sites=500&height=300");
  const [width, height] = await size();
  assert.ok(height === 300 && width > 300);
  assert.ok(await world.page.locator("#halftone .more [data-name=fit]").isHidden());
  await open("#halftone?picture=cat.jpg&sites=500&height=300&width=300");
  assert.deepEqual(await size(), [300, Math.round(300 * (height / width))]);
  await open("#halftone?picture=cat.jpg&sites=500&height=300&width=300&fit=cover");
  assert.deepEqual(await size(), [300, 300]);
});

test("prints on paper, at a resolution, in a file for each ink", async () => {
  await open("#halftone?sites=500&color=cmyk&width_mm=50&dpi=200&paper=a6&margin=12&marks=true&split=ink&jpeg_quality=40");
  const { page } = world;
  assert.match(await page.textContent("#halftone .status"), /394 \u00d7 394 pixels/);
  const ask = async (panel, title) => {
    const sent = page.waitForRequest((one) => one.method() === "POST" && /paper|jpeg_quality/.test(one.url() + one.postData()));
    const file = await download(page, panel, title);
    const { searchParams } = new URL((await sent).url());
    const options = panel === "sample" ? JSON.parse((await sent).postData()) : Object.fromEntries(searchParams);
    return { file, options: ["width_mm", "dpi", "paper", "margin", "marks", "split", "jpeg_quality"].map((name) => String(options[name])).join(" ") };
  };
  const svg = await ask("halftone", "SVG");
  assert.equal(svg.options, "50 undefined a6 12 true ink undefined");
  assert.equal(svg.file.suggestedFilename(), "dots.zip");
  assert.match(await readFile(await svg.file.path(), "latin1"), /^PK[^]*cyan\.svg[^]*yellow\.svg/);
  assert.equal((await ask("halftone", "JPEG")).options, "50 200 undefined undefined undefined undefined 40");
  await open("#sample?shape=polygon&sites=50&width_mm=50&dpi=200&paper=a6&jpeg_quality=40");
  assert.equal((await ask("sample", "PDF")).options, "50 undefined a6 undefined undefined undefined undefined");
  assert.equal((await ask("sample", "JPEG")).options, "50 200 undefined undefined undefined undefined 40");
});

test("offers files in millimetres for a paper", async () => {
  await open("#halftone?sites=500&paper=a6");
  assert.match(await readFile(await (await download(world.page, "halftone", "EPS")).path(), "latin1"), /\n%%BoundingBox: 0 0 298 420\n/);
});

test("cuts a map into tiles of the chosen zooms", async () => {
  await open("#sample?shape=texas.geojson&counted=&sites=100&minzoom=2&maxzoom=5");
  const sent = world.page.waitForRequest((one) => one.url().includes("pmtiles"));
  await download(world.page, "sample", "PMTiles, vector tiles");
  const { searchParams } = new URL((await sent).url());
  assert.deepEqual(["minzoom", "maxzoom", "dots_per_tile"].map((name) => searchParams.get(name)), ["2", "5", null]);
});

test("gives points the properties of their features", async () => {
  await open("#sample?shape=texas.geojson&counted=&sites=100&properties=name&multipoint=false");
  const { page } = world;
  const ask = async (title) => {
    const sent = page.waitForRequest((one) => one.method() === "POST" && one.url().includes("properties=name"));
    await download(page, "sample", title);
    return new URL((await sent).url()).searchParams;
  };
  assert.equal((await ask("GeoJSON")).get("multipoint"), "false");
  assert.equal((await ask("CSV")).get("multipoint"), null);
  await open("#sample?shape=polygon");
  assert.ok(await page.locator("#sample [data-name=properties]").isHidden());
});

test("accepts pictures for density and exclusion, and areas and points as text", async () => {
  await open("#sample?shape=polygon");
  const { page } = world;
  await page.click("#sample .more summary");
  const more = (name) => page.locator(`#sample .more [data-name=${name}]`);
  const picture = path.join(data, "images/camera.png");
  await more("density").locator("input").setInputFiles(picture);
  await settled(page, "sample");
  await more("exclude").locator("input").setInputFiles(picture);
  await settled(page, "sample");
  await more("fixed").locator("textarea").fill("[[0.3, 0.3]]");
  await more("fixed").locator("textarea").blur();
  await settled(page, "sample");
  const image = (await readFile(picture)).toString("base64");
  const { density, exclude, fixed } = await request();
  assert.deepEqual({ density, exclude, fixed }, { density: { image }, exclude: { image }, fixed: [[0.3, 0.3]] });
  const script = path.join(folder, "request.sh");
  await writeFile(script, await snippet());
  await run("bash", [script], { cwd: folder });
  assert.equal(JSON.parse(await readFile(path.join(folder, "points.json"), "utf8")).points.length, 1000);
  await page.getByRole("button", { name: "Remove: Areas to leave out, from a picture" }).click();
  await settled(page, "sample");
  assert.equal((await request()).exclude, undefined);
  await more("avoid").locator("textarea").fill("[[[0, 0], [1,");
  await more("avoid").locator("textarea").blur();
  await settled(page, "sample", "failed");
  assert.notEqual(await more("avoid").locator(".error").textContent(), "");
});

test("sends a document as JSON if options need it", async () => {
  await open("#sample?shape=polygon");
  const { page } = world;
  await page.setInputFiles("#sample .file", path.join(data, "polygons/Italy-110m.geojson"));
  await settled(page, "sample");
  assert.match(await page.textContent("#sample pre"), /--data-binary/);
  await page.click("#sample .more summary");
  const fixed = page.locator("#sample .more [data-name=fixed] textarea");
  await fixed.fill("[[12.5, 42]]");
  await fixed.blur();
  await settled(page, "sample");
  const { geometry, fixed: points, coordinates } = await request();
  assert.deepEqual([geometry.type, points, coordinates], ["MultiPolygon", [[12.5, 42]], "lonlat"]);
  await fixed.fill("[[12.5, 91]]");
  await fixed.blur();
  await settled(page, "sample", "failed");
  assert.match(await page.textContent("#sample .more [data-name=fixed] .error"), /latitude/);
});

test("sends options of drawings only with drawings", async () => {
  await open("#sample?shape=polygon");
  const { page } = world;
  await page.click("#sample .more summary");
  const width = page.locator("#sample .more [data-name=width]");
  await width.locator("input[type=checkbox]").uncheck();
  await width.locator("input[type=number]").fill("300");
  await width.locator("input[type=number]").blur();
  assert.equal((await request()).width, undefined);
  const sent = page.waitForRequest((one) => one.method() === "POST" && JSON.parse(one.postData()).format === "png");
  await Promise.all([page.waitForEvent("download"), download(page, "sample", "PNG")]);
  assert.equal(JSON.parse((await sent).postData()).width, 300);
});

test("explains options, by keyboard too", async () => {
  await open("#halftone");
  const { page } = world;
  const about = page.getByRole("button", { name: "About: Soft edges" });
  const line = page.locator("#halftone [data-name=antialias] .help");
  assert.equal(await about.getAttribute("aria-expanded"), "false");
  assert.ok(await line.isHidden());
  await about.focus();
  await page.keyboard.press("Enter");
  assert.equal(await about.getAttribute("aria-expanded"), "true");
  assert.equal(await about.getAttribute("aria-controls"), await line.getAttribute("id"));
  assert.match(await line.textContent(), /edge of a dot/);
  await page.keyboard.press("Enter");
  assert.ok(await line.isHidden());
});

test("gives every slider's value as text", async () => {
  await open("#sample?shape=polygon");
  await open("#halftone");
  const silent = await world.page.locator("input[type=range]:not([aria-valuetext])").evaluateAll((sliders) => sliders.map(({ outerHTML }) => outerHTML));
  assert.deepEqual(silent, []);
  const dots = world.page.locator("#halftone .fields [data-name=sites] input[type=range]");
  assert.equal(await dots.getAttribute("aria-valuetext"), "20,000");
});
