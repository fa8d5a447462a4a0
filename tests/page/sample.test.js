// SPDX-License-Identifier: GPL-3.0-or-later
// Panel that places points in a shape.

import assert from "node:assert/strict";
import { mkdtemp, readdir, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";

import { data, download, hasPackage, local, looksAsKept, run, runInBrowser, settled, slide, useBrowser } from "./harness.js";

const world = useBrowser();
const frame = () => world.page.locator("#sample .canvas-frame");
const request = async () => JSON.parse((await world.page.textContent("#sample pre")).match(/-d '(.*)' \\/s)[1]);

async function open() {
  await world.page.goto(`${world.url}/#sample?shape=polygon`);
  await settled(world.page, "sample");
}

/** Clicks at positions given as shares of the canvas. */
async function press(...places) {
  const box = await frame().boundingBox();
  for (const [x, y] of places) await world.page.mouse.click(box.x + x * box.width, box.y + y * box.height);
}

/** Returns the position of a corner on the screen while the polygon fits the canvas, with the margin. */
async function placeOf([x, y], polygon) {
  const margin = 28;
  const box = await frame().boundingBox();
  const range = (values) => [Math.min(...values), Math.max(...values)];
  const [minX, maxX] = range(polygon.map((corner) => corner[0]));
  const [minY, maxY] = range(polygon.map((corner) => corner[1]));
  const scale = Math.min((box.width - 2 * margin) / (maxX - minX), (box.height - 2 * margin) / (maxY - minY));
  return [box.x + box.width / 2 + scale * (x - (minX + maxX) / 2), box.y + box.height / 2 - scale * (y - (minY + maxY) / 2)];
}

test("fills a polygon with a hole", async () => {
  await open();
  assert.match(await world.page.textContent("#sample .status"), /^1,000 points, variation 0\.\d+/);
  await looksAsKept(world, frame(), "sample");
  await world.page.check("#mesh");
  await settled(world.page, "sample");
  await looksAsKept(world, frame(), "sample-triangulation");
});

test("draws a polygon and a hole by mouse, and moves corners", async () => {
  await open();
  await world.page.click("#sample .draw");
  await press([0.3, 0.2], [0.7, 0.2], [0.7, 0.8], [0.3, 0.8], [0.3, 0.2]);
  await settled(world.page, "sample");
  assert.equal((await request()).polygon.length, 4);
  await world.page.click("#sample .hole");
  await press([0.45, 0.4], [0.55, 0.4], [0.5, 0.6]);
  await world.page.keyboard.press("Enter");
  await settled(world.page, "sample");
  const drawn = await request();
  assert.equal(drawn.holes[0].length, 3);
  await looksAsKept(world, frame(), "sample-drawn");

  const from = await placeOf(drawn.polygon[0], drawn.polygon);
  await world.page.mouse.move(...from);
  await world.page.mouse.down();
  await world.page.mouse.move(from[0] + 60, from[1] + 40, { steps: 4 });
  await world.page.mouse.up();
  await settled(world.page, "sample");
  const moved = await request();
  assert.deepEqual(moved.polygon.slice(1), drawn.polygon.slice(1));
  assert.notDeepEqual(moved.polygon[0], drawn.polygon[0]);
});

test("opens with a dot map", async () => {
  const { page } = world;
  await page.goto(world.url);
  await settled(page, "halftone");
  await page.click("#tab-sample");
  await settled(page, "sample");
  assert.match(await page.textContent("#sample .status"), /^6,035 points/);
  assert.ok(await page.isHidden("#sample .trace"));
  assert.equal(await page.evaluate(() => location.hash), "#sample");
  const [field, select] = await Promise.all(["", " select"].map((part) =>
    page.locator(`#sample [data-name=coordinates]${part}`).evaluate((one) => one.getBoundingClientRect().right)));
  assert.ok(select <= field, `${select}, ${field}`);
});

test("draws by touch", async () => {
  const context = await world.newContext({ viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  const page = await context.newPage();
  await page.goto(`${world.url}/#sample?shape=polygon`);
  await settled(page, "sample");
  await page.tap("#sample .draw");
  const box = await page.locator("#sample .canvas-frame").boundingBox();
  for (const [x, y] of [[0.2, 0.2], [0.8, 0.3], [0.5, 0.8], [0.2, 0.2]])
    await page.touchscreen.tap(box.x + x * box.width, box.y + y * box.height);
  await settled(page, "sample");
  assert.equal(JSON.parse(await page.inputValue("#corners")).polygon.length, 3);
  await context.close();
});

const choose = async (file, state = "done") => {
  await world.page.setInputFiles("#sample .file", file);
  await settled(world.page, "sample", state);
};
const document = (json) => ({ name: "shape.geojson", mimeType: "application/geo+json", buffer: Buffer.from(JSON.stringify(json)) });
const query = async () => new URLSearchParams((await world.page.textContent("#sample pre")).match(/sample\?([^']*)'/)[1]);

test("spreads points in GeoJSON evenly on the ground or in degrees", async () => {
  await open();
  await choose(path.join(data, "polygons/South-Africa-50m.geojson"));
  assert.equal((await query()).get("coordinates"), "lonlat");
  assert.match(await world.page.textContent("#sample .status"), /^1,000 points, 35 km apart, variation 0\.\d+/);
  assert.equal(await world.page.textContent("#sample .warnings"), "");
  await looksAsKept(world, frame(), "sample-geojson");
  await world.page.selectOption("#sample [data-name=coordinates] select", "plane");
  await settled(world.page, "sample");
  assert.equal((await query()).get("coordinates"), null);
  assert.match(await world.page.textContent("#sample .warnings"), /points are even in degrees, not on the ground/);
  await looksAsKept(world, frame(), "sample-geojson-plane");
});

const corners = () => world.page.inputValue("#corners").then(JSON.parse);

test("undoes drawing, by buttons and by keys", async () => {
  await open();
  const first = await corners();
  assert.ok(await world.page.isDisabled("#sample .undo"));
  await world.page.click("#sample .draw");
  await press([0.3, 0.2], [0.7, 0.2], [0.7, 0.8], [0.4, 0.5]);
  await world.page.click("#sample .undo");
  await world.page.click("#sample .close");
  await settled(world.page, "sample");
  assert.equal((await corners()).polygon.length, 3);
  await world.page.click("#sample .hole");
  await press([0.62, 0.3], [0.66, 0.3]);
  await world.page.click("#sample .clear");
  await press([0.6, 0.3], [0.66, 0.3], [0.66, 0.4]);
  await world.page.click("#sample .close");
  await settled(world.page, "sample");
  assert.equal((await corners()).holes[0].length, 3);
  await world.page.focus("#sample canvas");
  await world.page.keyboard.press("Control+z");
  await settled(world.page, "sample");
  assert.equal((await corners()).holes, undefined);
  await world.page.click("#sample .undo");
  await settled(world.page, "sample");
  assert.deepEqual(await corners(), first);
  assert.ok(await world.page.isDisabled("#sample .undo"));
});

test("accepts corners in common forms", async () => {
  await open();
  await world.page.click("#sample .corners summary");
  const type = async (text, state) => {
    await world.page.fill("#corners", text);
    await world.page.locator("#corners").blur();
    await settled(world.page, "sample", state);
  };
  await type("[[0,0],[4,0],[4,3]]");
  assert.deepEqual(await request(), { sites: 1000, iterations: 10, polygon: [[0, 0], [4, 0], [4, 3]] });
  await type('{"type":"Polygon","coordinates":[[[0,0],[4,0],[4,3],[0,0]]]}');
  assert.equal(await world.page.inputValue("#shape"), "file");
  await world.page.selectOption("#shape", "polygon");
  await settled(world.page, "sample");
  assert.deepEqual(await corners(), { polygon: [[0, 0], [4, 0], [4, 3]] });
  for (const wrong of ["[]", "[[0,0],[1]]", '{"polygon":3}', "null", '{"polygon":[[0,0],[4,0],[4,3]],"holes":7}']) {
    await world.page.fill("#corners", wrong);
    await world.page.locator("#corners").blur();
    assert.match(await world.page.textContent("#shape-error"), /must be JSON/, wrong);
  }
});

test("draws a dot map, with a colour for each class", async () => {
  await open();
  await world.page.click("#sample .map");
  await settled(world.page, "sample");
  const sent = await query();
  assert.deepEqual(Object.fromEntries(sent), { classes: "employed,unemployed", per: "2000", coordinates: "lonlat", iterations: "10" });
  assert.deepEqual(await world.page.locator("#sample .legend li").allTextContents(), ["employed: 5,537", "unemployed: 498"]);
  assert.match(await world.page.textContent("#sample .status"), /^6,035 points, variation/);
  assert.ok(await world.page.isHidden("#sample [data-name=sites]"));
  await looksAsKept(world, frame(), "sample-map");

  const stands = world.page.getByRole("group", { name: "Points stand for" });
  await stands.getByLabel("employed: 11,073,677", { exact: true }).uncheck();
  await settled(world.page, "sample");
  assert.equal((await query()).get("sites"), "unemployed");
  assert.match(await world.page.textContent("#sample .status"), /^498 points/);
  await stands.getByLabel("unemployed").uncheck();
  await settled(world.page, "sample");
  assert.equal((await query()).get("sites"), "1000");
  assert.ok(await world.page.isVisible("#sample [data-name=sites]"));
  assert.deepEqual(await world.page.locator("#sample .legend li").count(), 0);
});

test("offers the numeric properties of a file's features", async () => {
  await open();
  const feature = (x, properties) => ({ type: "Feature", properties, geometry: { type: "Polygon", coordinates: [[[x, 0], [x + 2, 0], [x + 2, 2], [x, 2], [x, 0]]] } });
  const features = [feature(0, { name: "a", people: 300, votes: "20", share: -1 }), feature(2, { name: "b", people: null, votes: "5", share: 2 })];
  await choose(document({ type: "FeatureCollection", features }));
  const stands = world.page.getByRole("group", { name: "Points stand for" });
  assert.deepEqual(await stands.locator("label").allTextContents(), ["people: 300", "votes: 25"]);
  assert.equal((await query()).get("sites"), "1000");
  await stands.getByLabel("votes").check();
  await world.page.fill("#sample [data-name=per] input[type=number]", "1");
  await world.page.locator("#sample [data-name=per] input[type=number]").blur();
  await settled(world.page, "sample");
  assert.match(await world.page.textContent("#sample .status"), /^25 points/);
});

test("offers identifiers after counts", async () => {
  await open();
  const feature = (x, properties) => ({ type: "Feature", properties, geometry: { type: "Polygon", coordinates: [[[x, 0], [x + 2, 0], [x + 2, 2], [x, 2], [x, 0]]] } });
  const features = [[48001, "0107", 3], [48113, "0220", 8], [48005, "0319", 4], [48007, "0400", 7]].map(([fips, district, people], row) =>
    feature(2 * row, { row: row + 1, fips, district, people, GEOID: String(fips), houses: 10 * people }));
  await choose(document({ type: "FeatureCollection", features }));
  const labels = await world.page.getByRole("group", { name: "Points stand for" }).locator("label").allTextContents();
  assert.deepEqual(labels.map((text) => text.split(":")[0]), ["people", "houses", "row", "fips", "district", "GEOID"]);
});

test("zooms to a part", async () => {
  await open();
  await choose(path.join(data, "polygons/Italy-110m.geojson"));
  const shown = world.page.getByLabel("Visible part");
  assert.deepEqual(await shown.locator("option").allTextContents(), ["all parts", "part 1: 84 %", "part 2: 8.7 %", "part 3: 7.6 %"]);
  await shown.selectOption("1");
  await settled(world.page, "sample");
  assert.ok(parseInt(await world.page.textContent("#sample .zoom output"), 10) > 200);
  await shown.selectOption("");
  await settled(world.page, "sample");
  assert.equal(await world.page.textContent("#sample .zoom output"), "100 %");
});

test("accepts a whole collection, and reports repairs", async () => {
  await open();
  const square = (x) => [[x, 0], [x + 2, 0], [x + 2, 2], [x, 2], [x, 0]];
  const feature = (ring) => ({ type: "Feature", properties: {}, geometry: { type: "Polygon", coordinates: [ring] } });
  const bowTie = [[6, 0], [8, 2], [8, 0], [6, 2], [6, 0]];
  await choose(document({ type: "FeatureCollection", features: [square(0), square(3), bowTie].map(feature) }));
  assert.match(await world.page.textContent("#sample .repairs summary"), /^Repaired in \d+ places?$/);
  assert.ok((await world.page.locator("#sample .repairs li").count()) > 0);
  await looksAsKept(world, frame(), "sample-collection");
});

test("offers only a plane for coordinates that cannot be degrees", async () => {
  await open();
  await choose(document({ type: "Polygon", coordinates: [[[0, 0], [3000, 0], [3000, 2000], [0, 2000], [0, 0]]] }));
  assert.ok(await world.page.isHidden("#sample [data-name=coordinates]"));
  assert.equal((await query()).get("coordinates"), null);
});

test("draws the outline of a zipped shapefile", async () => {
  await open();
  await choose(path.join(data, "polygons/two-countries.zip"));
  assert.match(await world.page.textContent("#sample .status"), /^1,000 points, \d+ km apart/);
  assert.match(await world.page.textContent("#sample pre"), /--data-binary '@two-countries\.zip'/);
  assert.equal((await query()).get("coordinates"), "lonlat");
  await looksAsKept(world, frame(), "sample-shapefile");
  await world.page.setInputFiles("#sample .file", { name: "photos.zip", mimeType: "application/zip", buffer: Buffer.from("PK\u0003\u0004 no files") });
  await settled(world.page, "sample", "failed");
  assert.match(await world.page.textContent("#sample .general"), /^photos\.zip cannot be read as a shapefile: /);
});

test("takes the files of a shapefile together", async () => {
  await open();
  const { page } = world;
  const folder = await mkdtemp(path.join(tmpdir(), "ccdt-"));
  await run("/usr/bin/python3", ["-m", "zipfile", "-e", path.join(data, "polygons/two-countries.zip"), folder]);
  const files = (await readdir(folder, { recursive: true, withFileTypes: true })).filter((one) => one.isFile())
    .map(({ parentPath, name }) => path.join(parentPath, name));
  await choose(files.find((name) => name.endsWith(".shp")), "failed");
  assert.match(await page.textContent("#sample .general"), /\.shp is a part of a shapefile\. Choose its \.shp, /);
  await choose(files);
  assert.match(await page.textContent("#sample .status"), /^1,000 points, \d+ km apart/);
  await rm(folder, { recursive: true });
});

test("keeps the shape that was chosen last, even if an earlier one arrives later", async () => {
  await open();
  const { page } = world;
  let release;
  const held = new Promise((resolve) => { release = resolve; });
  await page.route(/texas\.geojson|iterations=0&mesh=true/, async (route) => {
    await held;
    await route.continue();
  });
  const arrived = [/texas\.geojson/, /iterations=0&mesh=true/].map((name) => page.waitForResponse(name));
  await page.click("#sample .map");
  await page.setInputFiles("#sample .file", path.join(data, "polygons/two-countries.zip"));
  await page.selectOption("#shape", "rectangle");
  await settled(page, "sample");
  release();
  for (const response of await Promise.all(arrived)) await response.finished();
  await settled(page, "sample");
  assert.equal(await page.inputValue("#shape"), "rectangle");
  assert.equal((await request()).domain.type, "rectangle");
});

test("shows where a document is wrong", async () => {
  await open();
  const ring = [[0, 0], [4, 0], [4, "north"], [0, 3], [0, 0]];
  await world.page.setInputFiles("#sample .file", document({ type: "Polygon", coordinates: [ring] }));
  await settled(world.page, "sample", "failed");
  assert.equal(await world.page.textContent("#shape-error"), "");
  assert.match(await world.page.textContent("#sample .general"), /coordinates\/0\/2/);
});

test("steps through the iterations, requesting each once", async () => {
  await open();
  const got = [];
  world.page.on("requestfinished", (one) => { if (one.url().endsWith("/sample")) got.push(one.postDataJSON()); });
  const iteration = world.page.locator("#iteration");
  await slide(iteration, [0]);
  await settled(world.page, "sample");
  await looksAsKept(world, frame(), "sample-start");
  const start = await world.page.textContent("#sample .status");
  assert.ok(Number(start.match(/variation ([\d.]+)/)[1]) > 0.5);
  await looksAsKept(world, world.page.locator("#sample .trace"), "sample-trace");
  await slide(iteration, [10]);
  await settled(world.page, "sample");
  await slide(iteration, [0]);
  await settled(world.page, "sample");
  assert.deepEqual(got.map(({ iterations, quality }) => [iterations, quality]), [[0, "draft"]]);
});

test("tiles the plane with a torus", async () => {
  await open();
  assert.ok(await world.page.isDisabled("#tiles"));
  await world.page.selectOption("#shape", "torus");
  await settled(world.page, "sample");
  await world.page.check("#mesh");
  await world.page.check("#tiles");
  await settled(world.page, "sample");
  await looksAsKept(world, frame(), "sample-tiles");
  await world.page.selectOption("#shape", "rectangle");
  assert.ok(!(await world.page.isChecked("#tiles")));
});

test("offers the stealthy quality only for a torus", async () => {
  await open();
  const { page } = world;
  const quality = "#sample [data-name=quality] select";
  assert.ok(await page.isDisabled(`${quality} option[value=stealthy]`));
  await page.selectOption("#shape", "torus");
  await page.selectOption(quality, "stealthy");
  await settled(page, "sample");
  assert.equal((await request()).quality, "stealthy");
  await page.selectOption("#shape", "rectangle");
  await settled(page, "sample");
  assert.equal((await request()).quality, undefined);
  assert.equal(await page.inputValue(quality), "standard");
});

/** Returns the server's answer to the JSON in a curl command. */
const answerTo = async (request) => fetch(`${world.url}/sample`, { method: "POST", body: JSON.stringify(request) });

test("makes a mask, shows its effect, and saves it", async () => {
  await open();
  const { page } = world;
  await page.selectOption("#shape", "mask");
  await settled(page, "sample");
  assert.match(await page.textContent("#sample .status"), /^64 \u00d7 64 thresholds/);
  assert.deepEqual(await request(), { format: "mask", domain: { type: "torus", width: 64, height: 64 } });
  assert.deepEqual(await page.locator("#sample .download option").allTextContents(), ["Mask, 8 bits", "Mask, 16 bits", "Mask, 16 bits, NPY"]);
  for (const without of ["#iteration", "#mesh", "#sample .more", "#sample .plotter", "#sample .trace", "#sample [data-name=sites]"])
    assert.ok(await page.isHidden(without), without);
  await looksAsKept(world, frame(), "sample-mask");

  const sides = page.locator("#sample [data-name=tile] input");
  await sides.nth(1).fill("16");
  await sides.nth(1).blur();
  await page.selectOption("#sample [data-name=format] select", "mask16");
  await settled(page, "sample");
  const sent = await request();
  assert.deepEqual(sent, { format: "mask16", domain: { type: "torus", width: 64, height: 16 } });
  const saved = await download(page, "sample", "Mask, 16 bits");
  assert.equal(saved.suggestedFilename(), "mask.png");
  const bytes = await readFile(await saved.path());
  assert.deepEqual(bytes, Buffer.from(await (await answerTo(sent)).arrayBuffer()));
  await page.click('#sample .kinds button:text-is("Node")');
  const script = await page.textContent("#sample pre");
  assert.equal(await run(process.execPath, ["--input-type=module", "--eval", script]), `image/png ${bytes.length}\n`);

  await sides.nth(1).fill("7");
  await sides.nth(1).blur();
  await settled(page, "sample", "failed");
  assert.match(await page.textContent("#shape-error"), /8 to 1024/);
  await page.selectOption("#shape", "torus");
  await settled(page, "sample");
  assert.match(await page.textContent("#sample .status"), /^1,000 points/);
});

test("shows the first points of a progressive order", async () => {
  await open();
  const { page } = world;
  assert.ok(await page.isHidden("#first"));
  await page.click("#sample .more summary");
  await page.selectOption("#sample [data-name=order] select", "progressive");
  await settled(page, "sample");
  assert.equal(await page.textContent("#sample output[for=first]"), "1,000");
  await slide(page.locator("#first"), [100]);
  assert.equal(await page.textContent("#sample output[for=first]"), "32");
  await looksAsKept(world, frame(), "sample-first");
  await page.selectOption("#sample [data-name=order] select", "none");
  await settled(page, "sample");
  assert.ok(await page.isHidden("#first"));
});

test("shows the share of each class of a map among the first points", async () => {
  await open();
  const { page } = world;
  await page.click("#sample .map");
  await settled(page, "sample");
  await page.click("#sample .more summary");
  await page.selectOption("#sample [data-name=order] select", "progressive");
  await settled(page, "sample");
  await page.evaluate(async () => {
    const { prototype } = (await import("/assets/dots.js")).DotLayer;
    const { add, draw } = prototype;
    let added = 0;
    window.drawn = {};
    prototype.add = function (places, view, radius, isShown) {
      added = Array.from({ length: places.length / 2 }, (_, i) => isShown(i)).filter(Boolean).length;
      add.call(this, places, view, radius, isShown);
    };
    prototype.draw = function (context, colour, ground) {
      window.drawn[colour] = added;
      draw.call(this, context, colour, ground);
    };
  });
  await slide(page.locator("#first"), [170]);
  const first = Number((await page.textContent("#sample output[for=first]")).replace(",", ""));
  assert.ok(first > 500 && first < 3000, first);
  await looksAsKept(world, frame(), "sample-map-first");
  const [employed, unemployed] = Object.values(await page.evaluate(() => window.drawn));
  assert.deepEqual([employed, unemployed], [5537, 498].map((sites) => Math.round((first / 6035) * sites)));
});

/** Returns the mean of the red, green and blue values, and the share of pixels like paper, in the middle of the canvas. */
const toneInMiddle = () => world.page.locator("#sample canvas").first().evaluate((canvas) => {
  const side = 100;
  const { data } = canvas.getContext("2d").getImageData((canvas.width - side) / 2, (canvas.height - side) / 2, side, side);
  let [sum, light] = [0, 0];
  for (let i = 0; i < data.length; i += 4) {
    sum += (data[i] + data[i + 1] + data[i + 2]) / 3;
    if (data[i] > 250) ++light;
  }
  return { mean: sum / side ** 2, light: light / side ** 2 };
});

test("draws 200,000 points with their tone, and as dots at higher zooms", async () => {
  const { page } = world;
  await page.goto(`${world.url}/#sample?shape=torus&sites=200000&quality=draft`);
  await settled(page, "sample");
  const { mean } = await toneInMiddle();
  assert.ok(Math.abs(mean - 188) < 6, mean);  // half of the area is covered, which halves the light
  for (let step = 0; step < 12; ++step) await page.click("#sample .zoom button[aria-label='Zoom in']");
  await settled(page, "sample");
  const zoomed = await toneInMiddle();
  assert.ok(Math.abs(zoomed.mean - 190) < 8, zoomed.mean);  // dots cover 28 % of the area
  assert.ok(zoomed.light > 0.6, zoomed.light);
  await page.check("#mesh");
  await settled(page, "sample");
  const meshed = await toneInMiddle();
  assert.ok(meshed.light < 0.9 * zoomed.light, meshed.light);
});

test("draws lines in all directions with the area that they cover", async () => {
  const { page } = world;
  await page.goto(world.url);
  const shares = await page.evaluate(async () => {
    const { DotLayer } = await import("/assets/dots.js");
    const drawn = (width, from, to) => {
      const canvas = new OffscreenCanvas(100, 80), layer = new DotLayer();
      layer.begin(100, 80);
      layer.addLines([...from, ...to], { x: 0, y: 0, scale: 1 }, width);
      layer.draw(canvas.getContext("2d"), "#808080", "#808080");
      const { data } = canvas.getContext("2d").getImageData(0, 0, 100, 80);
      return data.reduce((sum, value, i) => (i % 4 === 3 ? sum + value / 255 : sum), 0) / width;
    };
    const inside = Array.from({ length: 24 }, (_, i) => drawn(0.7, [50.3, -40.6], [50.3 + 33 * Math.cos(i), -40.6 + 33 * Math.sin(i)]) / 33);
    return [...inside, drawn(1.4, [-500.5, -40.5], [1e9, -40.5]) / 100, drawn(1.4, [30, 7e8], [30, -7e8]) / 80, 1 + drawn(0.7, [-9, -9], [-9, -90])];
  });
  for (const share of shares) assert.ok(Math.abs(share - 1) < 0.03, String(shares));
});

test("offers the methods that CCDT is compared with", async () => {
  await open();
  for (const method of ["cvt", "odt", "ccvt", "random"]) {
    await world.page.selectOption("#sample [data-name=method] select", method);
    await settled(world.page, "sample");
    assert.equal((await request()).method, method);
  }
  assert.ok(await world.page.isHidden("#iteration"));
});

/** Saves the points as JSON, and checks that the commands of the page, run in a folder, make the same points. */
async function repeats(folder, file) {
  const points = await download(world.page, "sample", "JSON");
  const saved = JSON.parse(await readFile(await points.path()));
  assert.equal(saved.points.length, 1000);
  const snippet = async (kind) => {
    await world.page.click(`#sample .kinds button:text-is("${kind}")`);
    return world.page.textContent("#sample pre");
  };
  const options = { cwd: folder };
  const byCurl = JSON.parse(await run("bash", ["-c", (await snippet("curl")).replace(" -o points.json", " -s")], options));
  assert.deepEqual(byCurl.points, saved.points);
  const target = path.join(await mkdtemp(path.join(tmpdir(), "ccdt-page-")), "points.csv");
  for (const [kind, program] of [["ccdt", "bash"], ...(await hasPackage() ? [["import ccdt", "/usr/bin/python3"]] : [])]) {
    await run(program, ["-c", (await snippet(kind)).replace("points.csv", target)], { ...options, env: local });
    const rows = (await readFile(target, "utf8")).trim().split("\n").slice(1);
    assert.deepEqual(rows.map((row) => row.split(",").slice(0, 2).map(Number)), saved.points, kind);
  }
  await rm(path.dirname(target), { recursive: true });
  const printed = `1000 ${saved.variation}\n`;
  assert.equal(await run("/usr/bin/python3", ["-c", await snippet("Python")], options), printed);
  assert.equal(await run(process.execPath, ["--input-type=module", "--eval", await snippet("Node")], options), printed);
  assert.equal(await runInBrowser(world, await snippet("Browser"), file && path.join(folder, file)), printed);
}

test("saves and shows commands that make the same points", async () => {
  await open();
  await repeats(data);
  await choose(path.join(data, "polygons/Italy-110m.geojson"));
  await repeats(path.join(data, "polygons"), "Italy-110m.geojson");
});
