// SPDX-License-Identifier: GPL-3.0-or-later
// Panel that shows a picture in the pixels and colours of a device.

import assert from "node:assert/strict";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";

import { data, launchChromium, run, settled, useBrowser } from "./harness.js";

const world = useBrowser();
const field = (name) => world.page.locator(`#devices [data-name=${name}]`);
const preset = (name) => world.page.getByRole("group", { name: "Common devices" }).getByRole("button", { name });

async function open(address = "") {
  await world.page.goto(`${world.url}/#devices${address}`);
  await settled(world.page, "devices");
}

async function type(name, value, state = "done") {
  const input = field(name).locator("input[type=number]");
  await input.fill(value);
  await input.blur();
  await settled(world.page, "devices", state);
}

/** Returns the options of the request that is shown as code. */
async function requestedOptions() {
  const { searchParams } = new URL((await world.page.textContent("#devices pre")).match(/'(http[^']*\/halftone[^']*)'/)[1]);
  return Object.fromEntries(searchParams);
}

/** Returns the colours of the preview. */
const colours = () => world.page.locator("#devices .exact canvas").evaluate((canvas) => {
  const { data: values } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const found = new Set();
  for (let i = 0; i < values.length; i += 4)
    found.add(`#${[...values.slice(i, i + 3)].map((value) => value.toString(16).padStart(2, "0")).join("")}`);
  return [...found].sort();
});

/** Returns the file that the button saves. */
async function download() {
  const [saved] = await Promise.all([world.page.waitForEvent("download"), world.page.click("#devices .download .primary")]);
  await settled(world.page, "devices");
  return { name: saved.suggestedFilename(), bytes: await readFile(await saved.path()) };
}

test("cuts the picture around a point that the user drags", async () => {
  const { page } = world;
  await open("?width=120&height=300&picture=astronaut.jpg");
  const pad = field("gravity").locator(".focus");
  const drag = async (x, y) => {
    await pad.scrollIntoViewIfNeeded();
    const box = await pad.boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + x * box.width, box.y + y * box.height, { steps: 3 });
    await page.mouse.up();
    await settled(page, "devices");
    return requestedOptions();
  };
  const { width, height } = await pad.boundingBox();
  const options = { device: "1bit", width: "120", height: "300", fit: "cover" };
  assert.deepEqual(await requestedOptions(), options);
  assert.deepEqual(await drag(0.2, 0.1), { ...options, gravity: "0.2,0.1" });
  assert.deepEqual(await drag(-0.3, 1.3), { ...options, gravity: "0,1" });
  assert.match(await page.evaluate(() => location.hash), /gravity=0%2C1/);
  await field("rotate").locator("select").selectOption("90");
  await settled(page, "devices");
  const turned = await pad.boundingBox();
  assert.deepEqual([turned.width, turned.height], [height, width]);
  await field("fit").locator("select").selectOption("contain");
  await settled(page, "devices");
  assert.ok(await pad.isHidden());
  assert.ok(!("gravity" in (await requestedOptions())));
});

test("compares the pixels with the picture, and enlarges them", async () => {
  const { page } = world;
  await open("?width=120&height=80&picture=astronaut.jpg&gravity=0.5,0");
  const canvas = page.locator("#devices .exact canvas");
  const tones = () => canvas.evaluate((shown) => {
    const side = (x) => new Set(shown.getContext("2d").getImageData(x, 0, 60, 80).data.filter((_, i) => i % 4 === 0)).size;
    return [side(0), side(60)];
  });
  assert.deepEqual(await tones(), [2, 2]);
  await page.getByLabel("Compare", { exact: true }).check();
  const [left, right] = await tones();
  assert.ok(left > 100 && right === 2, `${left} ${right}`);
  const fitted = await canvas.boundingBox();
  assert.ok(fitted.width % 120 === 0 && fitted.width > 480, `${fitted.width}`);
  await page.selectOption("#devices .view select", "4");
  const { width, height } = await canvas.boundingBox();
  assert.deepEqual([width, height], [480, 320]);
  assert.match(await page.evaluate(() => location.hash), /compare=true&zoom=4/);
  await page.reload();
  await settled(page, "devices");
  assert.equal((await canvas.boundingBox()).width, 480);
  assert.deepEqual(await tones(), [left, 2]);
});

/** Runs in a page: counts the pixels in which a part of a screenshot differs from a picture. */
async function differencesIn([screenshot, picture, left, top]) {
  const pixelsOf = async (base64, x, y, size) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
    const { width, height } = size ?? bitmap;
    const context = new OffscreenCanvas(width, height).getContext("2d");
    context.drawImage(bitmap, -x, -y);
    return { width, height, values: new Uint32Array(context.getImageData(0, 0, width, height).data.buffer) };
  };
  const wanted = await pixelsOf(picture, 0, 0);
  const shown = await pixelsOf(screenshot, left, top, wanted);
  return wanted.values.filter((value, i) => value !== shown.values[i]).length;
}

for (const ratio of [1, 1.5, 2]) {
  test(`shows a pixel of the device as a pixel of the screen, at ${ratio} pixels per CSS pixel`, async () => {
    const browser = await launchChromium(`--force-device-scale-factor=${ratio}`, "--window-size=1281,861");
    const page = await browser.newPage({ viewport: null });
    await page.goto(`${world.url}/#devices?device=spectra6&width=501&height=333&seen=false&zoom=1`);
    await settled(page, "devices");
    const [width, height, left, top] = await page.locator("#devices .exact canvas").evaluate((canvas) => {
      const place = canvas.getBoundingClientRect();
      return [place.width, place.height, place.left, place.top].map((length) => Math.round(length * devicePixelRatio));
    });
    assert.deepEqual([width, height], [501, 333]);
    const picture = await readFile(path.join(data, "../../server/page/site/samples/cat.jpg"));
    const answer = await fetch(`${world.url}/halftone?device=spectra6&width=501&height=333&fit=cover`, { method: "POST", body: picture });
    const base64 = (bytes) => Buffer.from(bytes).toString("base64");
    assert.equal(await world.blank.evaluate(differencesIn, [base64(await page.screenshot()), base64(await answer.arrayBuffer()), left, top]), 0);
    await browser.close();
  });
}

test("scrolls a picture that is wider than the preview", async () => {
  await world.page.setViewportSize({ width: 390, height: 844 });
  await open();
  const { scrollWidth, clientWidth, page } = await world.page.locator("#devices .exact").evaluate((frame) =>
    ({ scrollWidth: frame.scrollWidth, clientWidth: frame.clientWidth, page: document.documentElement.scrollWidth }));
  assert.deepEqual([scrollWidth, clientWidth, page], [832, 390, 390]);
  await world.page.focus("#devices .exact");
  await world.page.keyboard.press("ArrowRight");
  await world.page.waitForFunction(() => document.querySelector("#devices .exact").scrollLeft > 0);
});

test("sets all options of common devices", async () => {
  await open();
  const pressed = () => world.page.locator("#devices .presets [aria-pressed=true]").allTextContents();
  assert.deepEqual(await requestedOptions(), { device: "1bit", width: "800", height: "480", fit: "cover" });
  assert.deepEqual(await colours(), ["#000000", "#ffffff"]);
  await preset("Spectra 6").click();
  await settled(world.page, "devices");
  assert.deepEqual(await requestedOptions(), { device: "spectra6", width: "800", height: "480", fit: "cover" });
  assert.equal((await pressed()).length, 1);
  await preset("LED panel").click();
  await settled(world.page, "devices");
  const { device, palette, width, height } = await requestedOptions();
  assert.deepEqual([device, palette.split(",").length, width, height], ["custom", 8, "64", "32"]);
  await preset("58 mm").click();
  await settled(world.page, "devices");
  assert.deepEqual(await requestedOptions(), { device: "1bit", width: "384", format: "escpos" });
  assert.match(await world.page.textContent("#devices .status"), /^384 \u00d7 255 pixels, 2 colours, /);
  assert.equal(await world.page.evaluate(() => location.hash), "#devices?width=384&height=auto&format=escpos");
  await world.page.goBack();
  await settled(world.page, "devices");
  assert.match((await pressed())[0], /^LED/);
});

test("shows the colours as sent to a device or as seen on it", async () => {
  await open("?device=bwr");
  const { types } = (await (await fetch(`${world.url}/capabilities`)).json()).halftone.devices;
  const { sent, seen } = types.find(({ name }) => name === "bwr");
  const names = () => world.page.getByRole("list", { name: "Colours of the device" }).getByRole("img")
    .evaluateAll((swatches) => swatches.map(({ ariaLabel }) => ariaLabel));
  assert.deepEqual(await names(), sent.map((colour, i) => `${colour}, seen as ${seen[i]}`));
  assert.deepEqual(await colours(), seen.toSorted());
  let requests = 0;
  world.page.on("request", () => { ++requests; });
  await world.page.uncheck("#devices .view [data-name=seen] input");
  assert.deepEqual(await colours(), sent.toSorted());
  assert.equal(requests, 0);
  assert.equal(await world.page.evaluate(() => location.hash), "#devices?device=bwr&seen=false");
  await world.page.reload();
  await settled(world.page, "devices");
  assert.deepEqual(await colours(), sent.toSorted());
  await field("device").locator("select").selectOption("gray4");
  await settled(world.page, "devices");
  assert.deepEqual(await names(), ["#000000", "#555555", "#aaaaaa", "#ffffff"]);
  assert.ok(await field("seen").isHidden());
});

test("offers options only where they have a meaning", async () => {
  await open();
  const isShown = (name) => field(name).isVisible();
  const isOffered = (format) => field("format").locator(`option[value=${format}]`).evaluate(({ disabled }) => !disabled);
  assert.deepEqual([await isShown("palette"), await isShown("bit_order"), await isShown("invert_bits"), await isOffered("escpos")],
    [false, false, false, true]);
  await field("format").locator("select").selectOption("raw");
  assert.deepEqual([await isShown("bit_order"), await isShown("invert_bits")], [true, true]);
  await field("bit_order").locator("select").selectOption("lsb");
  await field("invert_bits").locator("input").check();
  await settled(world.page, "devices");
  assert.deepEqual(await requestedOptions(),
    { device: "1bit", width: "800", height: "480", fit: "cover", format: "raw", bit_order: "lsb", invert_bits: "true" });
  await field("height").getByLabel("auto").check();
  assert.ok(!(await isShown("fit")));
  await field("format").locator("select").selectOption("escpos");
  await field("device").locator("select").selectOption("gray16");
  await settled(world.page, "devices");
  assert.ok(!(await isOffered("escpos")));
  assert.deepEqual(await requestedOptions(), { device: "gray16", width: "800" });
});

test("turns, frames and colours a picture for a device with a palette", async () => {
  await open("?width=300&height=300");
  await field("device").locator("select").selectOption("custom");
  await world.page.getByRole("group", { name: "Palette" }).getByRole("button", { name: "Remove colour 2" }).click();
  await field("fit").locator("select").selectOption("contain");
  await field("rotate").locator("select").selectOption("90");
  await field("background").locator("input").fill("#ffff00");
  await settled(world.page, "devices");
  const palette = "#000000,#ff0000,#ffff00";
  assert.deepEqual(await requestedOptions(),
    { device: "custom", palette, width: "300", height: "300", rotate: "90", background: "#ffff00" });
  assert.deepEqual(await colours(), palette.split(","));
  const corner = await world.page.locator("#devices .exact canvas").evaluate((canvas) => [...canvas.getContext("2d").getImageData(2, 150, 1, 1).data]);
  assert.deepEqual(corner, [255, 255, 0, 255]);  // the upright picture has bars at its sides
});

test("shows errors beside their fields", async () => {
  await open("?device=custom&width=100&height=100");
  await world.page.getByRole("group", { name: "Palette" }).getByLabel("Colour 2", { exact: true }).fill("#000000");
  await settled(world.page, "devices", "failed");
  assert.match(await field("palette").locator(".error").textContent(), /repeats/);
  assert.ok(await world.page.isHidden("#devices .exact canvas"));
  await preset("TRMNL").click();
  await settled(world.page, "devices");
  await type("width", "70000", "failed");
  assert.match(await field("width").locator(".error").textContent(), /65535/);
  assert.match(await world.page.textContent("#devices .general"), /65535/);
});

test("saves the file that the shown command saves, in each format", async () => {
  await open("?width=200&height=120");
  const folder = await mkdtemp(path.join(tmpdir(), "ccdt-page-"));
  for (const [format, name, start] of [["png", "pixels.png", "\x89PNG"], ["bmp", "pixels.bmp", "BM"], ["raw", "pixels.bin", ""], ["escpos", "pixels.bin", "\x1b@\x1dv0"]]) {
    await field("format").locator("select").selectOption(format);
    await settled(world.page, "devices");
    const saved = await download();
    assert.equal(saved.name, name);
    assert.equal(saved.bytes.toString("latin1", 0, start.length), start);
    if (format === "raw") assert.equal(saved.bytes.length, (200 * 120) / 8);
    await run("bash", ["-c", await world.page.textContent("#devices pre")], { cwd: folder });
    assert.deepEqual(await readFile(path.join(folder, name)), saved.bytes);
  }
  await rm(folder, { recursive: true });
});

test("shares the user's picture with the panel for halftones, and keeps the result if a file is not a picture", async () => {
  const { page } = world;
  await open("?width=100&height=100");
  await page.setInputFiles("#devices .file", path.join(data, "images/camera.png"));
  await settled(page, "devices");
  assert.match(await page.textContent("#devices pre"), /@camera\.png/);
  await page.setInputFiles("#devices .file", { name: "letter.txt", mimeType: "text/plain", buffer: Buffer.from("Dear reader") });
  await settled(page, "devices", "failed");
  assert.match(await page.textContent("#devices .general"), /^This file is not a supported image: /);
  assert.match(await page.textContent("#devices .status"), /^100 \u00d7 100 pixels/);
  assert.match(await page.textContent("#devices pre"), /@camera\.png/);
  await page.click("#tab-halftone");
  await settled(page, "halftone");
  assert.match(await page.textContent("#halftone pre"), /@camera\.png/);
  assert.equal(await page.locator("#halftone").getByRole("button", { name: "camera.png" }).getAttribute("aria-pressed"), "true");
});
