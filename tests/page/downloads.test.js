// SPDX-License-Identifier: GPL-3.0-or-later
// Saves files with the browser, and reads them with the usual programs for each format.

import assert from "node:assert/strict";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";

import { data, download, run, settled, useBrowser } from "./harness.js";

const world = useBrowser();

/** A Python program that describes a raster picture. */
const picture = `
with PIL.Image.open(name) as picture:
    grey = numpy.asarray(picture.convert("L")) / 255
    light = numpy.where(grey <= 0.04045, grey / 12.92, ((grey + 0.055) / 1.055) ** 2.4)
    print(json.dumps({"format": picture.format, "width": picture.width, "height": picture.height,
                      "light": light.mean(), "grey": grey.mean()}))`;

/**
 * Python programs, by file extension, that print the content of a file as JSON. For others, the test prints its length.
 */
const readers = {
  json: "print(json.dumps(json.load(open(name))))",
  csv: `
with open(name, newline="") as file:
    head, *rows = csv.reader(file)
print(json.dumps({"head": head, "points": [[float(x), float(y)] for x, y, *_ in rows]}))`,
  npy: "print(json.dumps({'points': numpy.load(name).tolist()}))",
  geojson: `
feature = json.load(open(name))
shape = shapely.geometry.shape(feature["geometry"])
print(json.dumps({"valid": shape.is_valid, "points": [[p.x, p.y] for p in shape.geoms], **feature["properties"]}))`,
  png: picture,
  webp: picture,
  jpg: picture,
  tiff: picture,
  svg: `
circles = xml.etree.ElementTree.parse(name).findall(".//{http://www.w3.org/2000/svg}circle")
print(json.dumps({"circles": len({(circle.get("cx"), circle.get("cy")) for circle in circles})}))`,
};
const anything = "print(json.dumps({'bytes': os.path.getsize(name)}))";
const imports = "import csv, json, os, xml.etree.ElementTree, numpy, PIL.Image, shapely.geometry\n";

/** Returns what a Python program prints about each file, by file name. */
async function read(files) {
  const parts = files.map((file) => `name = ${JSON.stringify(file)}\n${readers[path.extname(file).slice(1)] ?? anything}\n`);
  const lines = (await run("/usr/bin/python3", ["-c", imports + parts.join("")])).trim().split("\n");
  const found = Object.fromEntries(files.map((file, i) => [path.basename(file), JSON.parse(lines[i])]));
  for (const [name, { bytes }] of Object.entries(found)) assert.notEqual(bytes, 0, name);
  return found;
}

/** Saves the result of a panel in a format, under the suggested name, and returns the path of the file. */
async function save(panel, title, folder) {
  const saved = await download(world.page, panel, title);
  const file = path.join(folder, saved.suggestedFilename());
  await saved.saveAs(file);
  return file;
}

/**
 * Saves a panel's result in each format that the server has, and reads the files. For the SVG, also describes its
 * rendering at the size of the picture.
 */
async function saveAll(panel, name) {
  const folder = await mkdtemp(path.join(tmpdir(), "ccdt-page-"));
  const { formats: all } = (await (await fetch(`${world.url}/capabilities`)).json())[panel];
  const isLast = ({ name: format }) => format === "json";
  const formats = all.filter(({ needs = [] }) => needs.length === 0).sort((a, b) => isLast(a) - isLast(b));
  const titles = formats.map(({ title }) => title);
  assert.deepEqual(await world.page.locator(`#${panel} .download option`).allTextContents(), titles);
  const saved = [];
  for (const title of titles) saved.push(await save(panel, title, folder));
  const files = await read(saved);
  assert.deepEqual(Object.keys(files), formats.map(({ extension }) => `${name}.${extension}`));
  const [svg, png] = [".svg", ".png"].map((ending) => Object.keys(files).find((name) => name.endsWith(ending)));
  const drawn = path.join(folder, "drawn.png");
  const { width, height } = files[png];
  await run("rsvg-convert", [`--width=${width}`, `--height=${height}`, "--background-color=white", `--output=${drawn}`, path.join(folder, svg)]);
  files[svg].drawn = (await read([drawn]))["drawn.png"];
  await rm(folder, { recursive: true });
  return files;
}

/**
 * Compares the mean light of a picture with the mean grey level of a drawing, because the server antialiases edges in
 * linear light, librsvg in grey levels.
 */
function isSame(picture, drawn) {
  assert.ok(Math.abs(picture.light - drawn.grey) < 0.01, `${picture.light}, ${drawn.grey}`);
}

for (const viewport of [{ width: 1280, height: 900 }, { width: 390, height: 844 }]) {
  test(`has the download button beside the picture, ${viewport.width} pixels wide`, async () => {
    const { page } = world;
    await page.setViewportSize(viewport);
    for (const panel of ["halftone", "devices", "sample"]) {
      await page.goto(`${world.url}/#${panel}`);
      await settled(page, panel);
      const { y, height } = await page.locator(`#${panel} .download .primary`).boundingBox();
      assert.ok(y > 0 && y + height < viewport.height, `${panel}: ${y}`);
    }
  });
}

test("saves a halftone in each format", async () => {
  await world.page.goto(`${world.url}/#halftone?sites=3000`);
  await settled(world.page, "halftone");
  const [, width, height] = (await world.page.textContent("#halftone .status")).match(/(\d+) \u00d7 (\d+) pixels/).map(Number);
  const files = await saveAll("halftone", "dots");
  const { "dots.png": png, "dots.svg": svg, "dots.csv": csv, "dots.json": json, "dots.npy": npy } = files;
  for (const [name, format] of [["png", "PNG"], ["webp", "WEBP"], ["tiff", "TIFF"]]) {
    const read = files[`dots.${name}`];
    assert.deepEqual([read.format, read.width, read.height], [format, width, height]);
    // Edges in TIFF are not softened for screens, because no browser scales TIFF.
    if (name === "tiff") assert.ok(Math.abs(read.light - png.light) < 0.01, `${read.light}, ${png.light}`);
    else assert.equal(read.grey, png.grey);
  }
  for (const { points } of [npy, csv]) assert.deepEqual(points, json.points);
  assert.equal(json.points.length, 3000);
  assert.deepEqual(csv.head, ["x", "y"]);
  assert.ok(json.rings.length > 1000);
  assert.equal(svg.circles, 0);
  isSame(png, svg.drawn);
});

test("saves the results for all pictures that were chosen together", async () => {
  const { page } = world;
  const image = (name) => path.join(data, "images", name);
  await page.goto(`${world.url}/#halftone?sites=500`);
  await settled(page, "halftone");
  const broken = { name: "broken.png", mimeType: "image/png", buffer: Buffer.from("nothing") };
  const [cat, camera] = await Promise.all(["chelsea.png", "camera.png"].map(async (name) => ({ name: "a.png", mimeType: "image/png", buffer: await readFile(image(name)) })));
  await page.setInputFiles("#halftone .file", [cat, broken, camera]);
  await settled(page, "halftone");
  await page.waitForFunction(() => document.querySelectorAll("#halftone .thumb :is(canvas, span)").length === 3);
  await page.getByRole("button", { name: "a.png" }).last().click();
  await settled(page, "halftone");
  assert.match(await page.textContent("#halftone .status"), /, 1000 \u00d7 1000 pixels/);  // the cat is wider
  for (const [panel, extension] of [["halftone", "csv"], ["devices", "png"]]) {
    await page.click(`#tab-${panel}`);
    await settled(page, panel);
    if (panel === "halftone") await page.selectOption("#halftone .download select", { label: "CSV" });
    const [saved] = await Promise.all([page.waitForEvent("download"), page.click(`#${panel} .all button`)]);
    await settled(page, panel);
    assert.equal(await page.textContent(`#${panel} .status`), "2 of 3 pictures saved");
    assert.match(await page.textContent(`#${panel} .warnings`), /^broken\.png: /);
    const listed = JSON.parse(await run("/usr/bin/python3", ["-c", `
import json, sys, zipfile
archive = zipfile.ZipFile(sys.argv[1])
assert archive.testzip() is None
print(json.dumps({name: archive.read(name).hex() for name in archive.namelist()}))`, await saved.path()]));
    assert.deepEqual(Object.keys(listed), [`a.${extension}`, `a-2.${extension}`]);
    assert.notEqual(...Object.values(listed));
    if (panel === "devices") continue;
    const alone = await readFile(await (await download(page, panel, "CSV")).path());
    assert.equal(listed["a-2.csv"], alone.toString("hex"));
  }
});

test("saves points in each format", async () => {
  await world.page.goto(`${world.url}/#sample?shape=polygon`);
  await settled(world.page, "sample");
  const files = await saveAll("sample", "points");
  const { points, seed, method } = files["points.json"];
  assert.equal(points.length, 1000);
  for (const name of ["points.csv", "points.geojson", "points.npy"]) assert.deepEqual(files[name].points, points, name);
  assert.deepEqual(files["points.csv"].head, ["x", "y"]);
  assert.ok(files["points.geojson"].valid);
  assert.deepEqual([files["points.geojson"].seed, files["points.geojson"].method], [seed, method]);
  assert.equal(files["points.svg"].circles, 1000);
  assert.equal(files["points.png"].format, "PNG");
  isSame(files["points.png"], files["points.svg"].drawn);
});
