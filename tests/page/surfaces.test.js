// SPDX-License-Identifier: GPL-3.0-or-later
// Points on the surfaces of meshes in the panel Sample: the view that turns them, requests, downloads and errors.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { mkdtempSync } from "node:fs";
import { readFile, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";

import { data, download, looksAsKept, pageWithoutWebgl, run, runInBrowser, settled, slide, useBrowser } from "./harness.js";

const world = useBrowser();
const canvas = "#sample canvas.of-surfaces";
const frame = (page = world.page) => page.locator("#sample .canvas-frame");
const query = async () => new URLSearchParams((await world.page.textContent("#sample pre")).match(/sample\?([^']*)'/)[1]);
const turn = (direction) => world.page.click(`#sample .zoom.of-surfaces button[aria-label="Turn ${direction}"]`);

async function open(page = world.page, settings = "") {
  await page.goto(`${world.url}/#sample?shape=knot.obj${settings}`);
  await settled(page, "sample");
}

/** Returns a digest of the picture of the canvas, after it has been drawn. */
async function picture(page = world.page) {
  await page.evaluate(() => document.activeElement.blur());  // the outline of the focus is not part of the picture
  await settled(page, "sample");
  return createHash("sha256").update(await frame(page).screenshot()).digest("hex");
}

const side = 5;
const corners = [0, 1].flatMap((z) => [[0, 0], [side, 0], [side, side], [0, side]].map(([x, y]) => [x, y, side * z]));
const squares = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

const text = (...lines) => Buffer.from(`${lines.join("\n")}\n`);
const cube = {
  obj: text(...corners.map((corner) => `v ${corner.join(" ")}`), ...squares.map((square) => `f ${square.map((i) => i + 1).join(" ")}`)),
  off: text("OFF", "8 6 0", ...corners.map((corner) => corner.join(" ")), ...squares.map((square) => `4 ${square.join(" ")}`)),
  ply: text("ply", "format ascii 1.0", "element vertex 8", ...["x", "y", "z"].map((name) => `property float ${name}`), "element face 6",
    "property list uchar int vertex_indices", "end_header", ...corners.map((corner) => corner.join(" ")), ...squares.map((square) => `4 ${square.join(" ")}`)),
  get stl() {
    const triangles = squares.flatMap(([a, b, c, d]) => [[a, b, c], [a, c, d]]);
    const bytes = Buffer.alloc(84 + 50 * triangles.length);
    bytes.writeUInt32LE(triangles.length, 80);
    triangles.forEach((triangle, i) => triangle.flatMap((corner) => corners[corner]).forEach((value, j) => bytes.writeFloatLE(value, 84 + 50 * i + 12 + 4 * j)));
    return bytes;
  },
};

async function choose(name, buffer, state) {
  await world.page.setInputFiles("#sample .file", { name, mimeType: "", buffer });
  await settled(world.page, "sample", state);
}

test("loads the view only for a surface", async () => {
  const { page } = world;
  const loaded = [];
  page.on("request", (one) => { if (one.url().includes("/surface_")) loaded.push(new URL(one.url()).pathname); });
  await page.goto(`${world.url}/#sample?shape=polygon`);
  await settled(page, "sample");
  assert.deepEqual(loaded, []);
  await page.click("#sample .knot");
  await settled(page, "sample");
  assert.ok(loaded.includes("/assets/surface_view.js"));
  assert.equal(await page.evaluate(() => location.hash), "#sample?shape=knot.obj");
  assert.ok(await page.isHidden("#sample canvas.of-planes"));
  await page.selectOption("#shape", "torus");
  await settled(page, "sample");
  assert.ok(await page.isHidden(canvas));
  assert.match(await page.textContent("#sample .status"), /^1,000 points/);
  await page.selectOption("#shape", "surface");
  await settled(page, "sample");
  assert.ok(await page.isVisible(canvas));
});

test("shows points on a surface, and their triangulation", async () => {
  await open();
  const { page } = world;
  assert.match(await page.textContent("#sample .status"), /^1,000 points, variation 0\.\d+/);
  assert.equal((await query()).get("mesh"), null);
  await looksAsKept(world, frame(), "surface");
  await page.check("#mesh");
  await settled(page, "sample");
  assert.equal((await query()).get("mesh"), "true");
  await looksAsKept(world, frame(), "surface-triangulation");
});

test("looks the same without WebGL", async () => {
  const page = await pageWithoutWebgl(world);
  await open(page);
  await looksAsKept(world, frame(page), "surface");
  await page.check("#mesh");
  await settled(page, "sample");
  await looksAsKept(world, frame(page), "surface-triangulation");
  await page.context().close();
});

test("draws again after the browser has lost its graphics", async () => {
  await open();
  const first = await picture();
  const lose = (name) => world.page.$eval(canvas, (element, call) => {
    window.graphics ??= element.getContext("webgl2").getExtension("WEBGL_lose_context");
    const done = new Promise((resolve) => element.addEventListener(call === "loseContext" ? "webglcontextlost" : "webglcontextrestored", resolve, { once: true }));
    window.graphics[call]();
    return done.then(() => {});
  }, name);
  await lose("loseContext");
  await lose("restoreContext");
  assert.equal(await picture(), first);
});

test("cuts discs off at edges of the surface", async () => {
  const { page } = world;
  await page.goto(`${world.url}/#sample?shape=knot.obj&sites=300&order=progressive`);
  await settled(page, "sample");
  await page.setInputFiles("#sample .file", path.join(data, "meshes/house.obj"));
  await settled(page, "sample");
  const covered = (first) => page.evaluate((value) => new Promise((resolve) => {
    const slider = document.getElementById("first");
    slider.value = value;
    slider.dispatchEvent(new Event("input"));
    requestAnimationFrame(() => {  // runs after the view has drawn
      const { width, height } = document.querySelector("#sample canvas.of-surfaces");
      const context = new OffscreenCanvas(width, height).getContext("2d");
      context.drawImage(document.querySelector("#sample canvas.of-surfaces"), 0, 0);
      resolve(context.getImageData(0, 0, width, height).data.filter((alpha, i) => i % 4 === 3 && alpha > 64).length);
    });
  }), first);
  const [alone, all] = [await covered("0"), await covered("200")];
  assert.ok(alone > 20_000, alone);
  assert.ok(all - alone < 0.001 * alone, `${all} ${alone}`);
});

test("turns, moves and zooms by keys and buttons", async () => {
  await open();
  const { page } = world;
  const first = await picture();
  const changes = async (act) => {
    await act();
    assert.notEqual(await picture(), first);
    await page.click('#sample .zoom.of-surfaces button[aria-label="Fit"]');
    assert.equal(await picture(), first);
  };
  for (const direction of ["left", "right", "up", "down"]) await changes(() => turn(direction));
  await page.focus(canvas);
  for (const key of ["ArrowLeft", "ArrowUp", "Shift+ArrowRight", "Shift+ArrowDown", "+", "-"]) await changes(() => page.press(canvas, key));
  await page.press(canvas, "ArrowRight");
  await page.press(canvas, "0");
  assert.equal(await picture(), first);
  const byKey = async () => { await page.press(canvas, "ArrowRight"); return picture(); };
  const turned = await byKey();
  await page.press(canvas, "0");
  await turn("right");
  assert.equal(await picture(), turned);
});

test("turns by dragging, and zooms at the pointer", async () => {
  await open();
  const { page } = world;
  const { x, y, width, height } = await frame().boundingBox();
  const first = await picture();
  await page.mouse.move(x + width / 2, y + height / 2);
  await page.mouse.down();
  await page.mouse.move(x + width / 2 + 60, y + height / 2 - 20, { steps: 3 });
  await page.mouse.up();
  const turned = await picture();
  assert.notEqual(turned, first);
  await page.mouse.wheel(0, -300);
  assert.notEqual(await picture(), turned);
  assert.notEqual(await page.textContent("#sample .zoom.of-surfaces output"), "100 %");
});

test("turns by one finger, and zooms by two", async () => {
  const context = await world.newContext({ viewport: { width: 375, height: 812 }, hasTouch: true, isMobile: true });
  const page = await context.newPage();
  await open(page);
  const session = await context.newCDPSession(page);
  const { x, y, width, height } = await frame(page).boundingBox();
  const [middleX, middleY] = [x + width / 2, y + height / 2];
  const touch = (type, ...points) => session.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([dx, dy], id) => ({ x: middleX + dx, y: middleY + dy, id })) });
  const zoom = () => page.textContent("#sample .zoom.of-surfaces output");
  const first = await picture(page);
  await touch("touchStart", [0, 0]);
  await touch("touchMove", [50, 10]);
  await touch("touchEnd");
  assert.notEqual(await picture(page), first);
  assert.equal(await zoom(), "100 %");
  await touch("touchStart", [-30, 0], [30, 0]);
  await touch("touchMove", [-60, 0], [60, 0]);
  await touch("touchEnd");
  await picture(page);
  assert.equal(await zoom(), "200 %");
  await context.close();
});

test("keeps the rotation while options change, but not with another file", async () => {
  await open();
  const { page } = world;
  await turn("right");
  const turned = await picture();
  const quality = "#sample [data-name=quality] select";
  await page.selectOption(quality, "draft");
  await settled(page, "sample");
  await page.selectOption(quality, "standard");
  assert.equal(await picture(), turned);
  await choose("cube.obj", cube.obj);
  await page.click("#sample .knot");
  assert.notEqual(await picture(), turned);
});

test("accepts each format, by its name or its content", async () => {
  await open();
  const { page } = world;
  for (const [kind, bytes] of Object.entries(cube)) {
    for (const name of kind === "ply" || kind === "off" ? [`cube.${kind.toUpperCase()}`, "cube"] : [`cube.${kind}`]) {
      await choose(name, bytes);
      assert.match(await page.textContent("#sample .status"), /^1,000 points/, name);
      assert.match(await page.textContent("#sample pre"), new RegExp(`--data-binary '@${name}'`));
      assert.equal(await page.inputValue("#shape"), "surface");
    }
  }
  assert.equal(await page.evaluate(() => location.hash), "#sample?shape=own");
});

test("shows the z axis of STL files upwards, and hides the back of the surface", async () => {
  await open();
  const { page } = world;
  await page.fill("#sample .fields [data-name=sites] input[type=number]", "400");
  await choose("cube.stl", cube.stl);
  await looksAsKept(world, frame(), "surface-cube");
});

test("accepts a dropped mesh", async () => {
  await open();
  const { page } = world;
  await page.evaluate((content) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([content], "cube.obj"));
    document.querySelector("#sample .drop").dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true }));
  }, cube.obj.toString());
  await settled(page, "sample");
  assert.match(await page.textContent("#sample pre"), /--data-binary '@cube.obj'/);
});

test("sends the options of surfaces, and no others", async () => {
  await open();
  const { page } = world;
  await page.selectOption("#sample form.of-surfaces [data-name=density] select", "curvature");
  await settled(page, "sample");
  const crease = page.locator("#sample [data-name=crease]");
  await crease.locator("input[type=checkbox]").uncheck();
  await settled(page, "sample");
  await page.click("#sample .more summary");
  const fixed = page.locator("#sample .more [data-name=fixed] textarea");
  await fixed.fill("[[1.2, 0, 0.3]]");
  await fixed.blur();
  await settled(page, "sample");
  assert.deepEqual(Object.fromEntries(await query()), { sites: "1000", density: "curvature", crease: "40", fixed: "[[1.2,0,0.3]]", iterations: "10" });
  for (const name of ["avoid", "exclude", "buffer", "tolerance", "invalid", "method"]) assert.ok(await page.locator(`#sample [data-name=${name}]`).isHidden(), name);
  assert.equal(await page.locator("#sample [data-name=order] option:not([hidden])").count(), 3);
  await page.selectOption("#shape", "rectangle");
  await settled(page, "sample");
  assert.ok(await page.locator("#sample .more [data-name=density]").isVisible());
  assert.ok(await page.locator("#sample [data-name=crease]").isHidden());
});

test("places points inside a mesh", async () => {
  await open(world.page, "&domain=solid&crease=30&sites=300");
  const { page } = world;
  assert.match(await page.textContent("#sample .status"), /^300 points, [\d.]+ s/);
  assert.deepEqual(Object.fromEntries(await query()), { sites: "300", domain: "solid" });
  for (const name of ["density", "crease"]) assert.ok(await page.isHidden(`#sample form.of-surfaces [data-name=${name}]`), name);
  assert.ok(await page.isHidden("#iteration"));
  await looksAsKept(world, frame(), "solid");
  await open(page, "&domain=solid&sites=4000");
  await page.click("#tab-analyze");
  await settled(page, "analyze");
  assert.match(await page.textContent("#analyze .note"), /largest cube inside the mesh/);
  const [number, , mean] = await page.locator("#analyze tbody tr:first-child td").allTextContents();
  assert.ok(Number(number) > 20 && Number(mean) > 0.75, `${number} points, ${mean}`);
});

test("measures no cube across a thin wall", async () => {
  const { page } = world;
  await open(page, "&domain=solid&sites=20000");
  const plate = corners.map(([x, y, z]) => `v ${20 * x} ${20 * y} ${z / 10}`);
  await choose("plate.obj", text(...plate, ...squares.map((square) => `f ${square.map((i) => i + 1).join(" ")}`)));
  await page.click("#tab-analyze");
  await settled(page, "analyze", "failed");
  assert.match(await page.textContent("#analyze .general"), /only \d+ of the points, too few/);
});

test("restores its settings from the address", async () => {
  await open(world.page, "&density=color&crease=30&sites=500&mesh=on");
  assert.deepEqual(Object.fromEntries(await query()), { sites: "500", density: "color", crease: "30", iterations: "10", mesh: "true" });
  assert.equal(await world.page.evaluate(() => location.hash), "#sample?shape=knot.obj&sites=500&density=color&crease=30&mesh=on");
});

test("shows the first points of a progressive order", async () => {
  await open(world.page, "&order=progressive");
  const { page } = world;
  assert.equal(await page.textContent("#sample output[for=first]"), "1,000");
  await slide(page.locator("#first"), [120]);
  assert.equal(await page.textContent("#sample output[for=first]"), "63");
  await looksAsKept(world, frame(), "surface-first");
});

test("steps through the iterations", async () => {
  await open();
  const { page } = world;
  await slide(page.locator("#iteration"), [0]);
  await settled(page, "sample");
  const [, variation] = (await page.textContent("#sample .status")).match(/variation ([\d.]+)/);
  assert.ok(Number(variation) > 0.3, variation);
  assert.ok(await page.isVisible("#sample .trace svg"));
});

test("reports repairs and warnings, with a triangle", async () => {
  await open();
  const { page } = world;
  const broken = Buffer.concat([cube.obj.subarray(0, cube.obj.lastIndexOf("f ")), text("f 1 2 2", "f 1 1 2")]);
  await choose("broken.obj", broken);
  assert.equal(await page.textContent("#sample .repairs summary"), "Repaired");
  assert.match(await page.textContent("#sample .repairs li"), /\(triangle \d+\)$/);
});

test("shows errors of the mesh and of options", async () => {
  await open();
  const { page } = world;
  await choose("flat.obj", text("v 0 0 0", "v 1 0 0", "v 2 0 0", "f 1 2 3"), "failed");
  assert.match(await page.textContent("#sample .general"), /no triangle has an area/);
  await choose("cube.obj", cube.obj);
  assert.equal(await page.textContent("#sample .general"), "");
  await page.selectOption("#sample form.of-surfaces [data-name=density] select", "color");
  await settled(page, "sample", "failed");
  assert.match(await page.textContent("#sample form.of-surfaces [data-name=density] .error"), /no colours/);
  await page.selectOption("#sample form.of-surfaces [data-name=density] select", "uniform");
  await settled(page, "sample");
  const sites = page.locator("#sample .fields [data-name=sites]");
  await sites.locator("input[type=number]").fill("0");
  await sites.locator("input[type=number]").blur();
  await settled(page, "sample", "failed");
  assert.notEqual(await sites.locator(".error").textContent(), "");
  assert.equal(await page.textContent("#shape-error"), "");
});

test("analyzes points on a surface", async () => {
  await open();
  await world.page.click("#tab-analyze");
  await settled(world.page, "analyze");
  assert.match(await world.page.textContent("#analyze .note"), /measured on the surface/);
  const cells = await world.page.locator("#analyze tbody tr").first().locator("td").allTextContents();
  const [number, least, mean] = cells.map((text) => Number(text.replace(",", "")));
  assert.equal(number, 1000);
  assert.ok(least > 0.6 && mean > 0.8 && mean < 1, String(cells));
});

test("saves points and meshes, and shows commands that make the same points", async () => {
  await open();
  const { page } = world;
  const folder = mkdtempSync(path.join(tmpdir(), "ccdt-page-"));
  const [kept] = await Promise.all([page.waitForEvent("download"), page.click("#sample .keep")]);
  assert.equal(kept.suggestedFilename(), "knot.obj");
  const file = path.join(folder, "knot.obj");
  await writeFile(file, await readFile(await kept.path()));
  const titles = () => page.locator("#sample .download option").evaluateAll((options) => options.map(({ value }) => value));
  assert.deepEqual(await titles(), ["csv", "npy", "ply", "glb", "json"]);
  const points = JSON.parse(await readFile(await (await download(page, "sample", "JSON")).path()));
  const snippet = async (kind) => {
    await page.click(`#sample .kinds button:text-is("${kind}")`);
    return page.textContent("#sample pre");
  };
  const options = { cwd: folder };
  const byCurl = JSON.parse(await run("bash", ["-c", (await snippet("curl")).replace(" -o points.json", " -s")], options));
  assert.deepEqual(byCurl.points, points.points);
  const printed = `1000 ${points.variation}\n`;
  assert.equal(await run("/usr/bin/python3", ["-c", await snippet("Python")], options), printed);
  assert.equal(await run(process.execPath, ["--input-type=module", "--eval", await snippet("Node")], options), printed);
  assert.equal(await runInBrowser(world, await snippet("Browser"), file), printed);

  await page.check("#mesh");
  await settled(page, "sample");
  assert.deepEqual(await titles(), ["csv", "npy", "ply", "glb", "obj", "stl", "json"]);
  const obj = await readFile(await (await download(page, "sample", "Wavefront OBJ")).path(), "utf8");
  assert.ok(obj.match(/^f /gm).length > 1900, obj.slice(0, 200));
});
