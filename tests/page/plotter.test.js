// SPDX-License-Identifier: GPL-3.0-or-later
// Drawings for plotters: strokes as wide as the pen, the size of the paper, and the duration.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";

import { download, looksAsKept, settled, useBrowser } from "./harness.js";

const world = useBrowser();

async function open(address, panel = "halftone") {
  await world.page.goto(`${world.url}/${address}`);
  await settled(world.page, panel);
}

async function put(name, value, state = "done") {
  const input = world.page.locator(`#halftone .plot [data-name=${name}] input[type=number]`);
  await input.fill(value);
  await input.blur();
  await settled(world.page, "halftone", state);
}

const saved = async (panel = "halftone", title = "SVG") => readFile(await (await download(world.page, panel, title)).path(), "latin1");

const figures = (panel = "halftone") => world.page.textContent(`#${panel} .figures p`);

test("adapts the number and width of dots to a pen", async () => {
  await open("#halftone?sites=500&pen_mm=1.5");
  await world.page.locator("#halftone").getByLabel("Draw with a pen").check();
  await settled(world.page, "halftone");
  await put("pen_mm", "2");
  assert.ok(await world.page.isHidden("#halftone .fields [data-name=dot]"));
  assert.ok(await world.page.isChecked("#halftone .fields [data-name=sites] input[type=checkbox]"));
  assert.equal(await world.page.textContent("#halftone .warnings"), "");
  const svg = await saved();
  assert.match(svg, /^<svg [^>]*width="210mm" height="297mm" viewBox="0 0 210 297"/);
  const [, dots, path] = svg.match(/<desc>(\d+) dots along a path of ([\d.]+) mm/).map(Number);
  assert.match(svg, /stroke-width="2"/);
  assert.equal((svg.match(/^(<path d=")?M/gm) ?? []).length, dots);
  const shown = await figures();
  assert.ok(shown.startsWith(`190 \u00d7 190 mm. ${dots.toLocaleString("en")} dots in 1 layer, a path of ${Math.round(path / 1000)} m`), shown);
  await looksAsKept(world, world.page.locator("#halftone .plotter"), "halftone-plotter");
});

test("shows how long the pen takes", async () => {
  await open("#halftone?sites=100&plotter=on&pen_mm=4&lift=1&speed=500");
  assert.match(await figures(), /100 dots .*: about 2 min/);
  assert.match(await world.page.textContent("#halftone .warnings"), /dots cover \d+ % of the area that the tone/);
  let requests = 0;
  world.page.on("request", (request) => { requests += request.method() === "POST" ? 1 : 0; });
  await put("lift", "60");
  assert.match(await figures(), /about 1 h 40 min/);
  assert.equal(requests, 0);  // the drawing is the same
  assert.match(await world.page.evaluate(() => location.hash), /lift=60/);
});

test("estimates the time at once, and fits into a given time", async () => {
  await open("#halftone?picture=cat.jpg&plotter=on&pen_mm=2&paper=a5");
  const { page } = world;
  const minutes = (text) => Number(text.match(/about (\d+) min/)[1]);
  const dots = (text) => Number(text.match(/([\d,]+) dots/)[1].replace(",", ""));
  const whole = await figures();
  await page.evaluate(() => {
    window.shownTexts = [];
    const place = document.querySelector("#halftone .figures");
    new MutationObserver(() => window.shownTexts.push(place.querySelector("p")?.textContent)).observe(place, { childList: true });
  });
  await put("margin_mm", "12");
  const [first] = await page.evaluate(() => window.shownTexts);
  assert.match(first, /^Estimate: [\d,]+ dots, about \d+ min\.$/);
  assert.ok(Math.abs(dots(first) / dots(whole) - 1) < 0.2, `${first}, ${whole}`);
  assert.ok(Math.abs(minutes(first) / minutes(whole) - 1) < 0.25, `${first}, ${whole}`);

  await page.uncheck("#halftone .plot [data-name=minutes] input[type=checkbox]");
  await put("minutes", "12");
  const fitted = await figures();
  assert.equal(minutes(fitted), 12);
  assert.ok(dots(fitted) < dots(whole), fitted);
  assert.ok(await page.isHidden("#halftone .fields [data-name=sites]"));
  assert.match(await page.textContent("#halftone .figures .note"), /^The drawing is lighter than the picture\. The right tone needs about [\d,]+ dots, or a pen [\d.]+ mm wide/);
  assert.equal(await page.textContent("#halftone .warnings"), "");
  assert.match(await page.evaluate(() => location.hash), /minutes=12/);
});

test("fills dots, or joins them by one line", async () => {
  await open("#halftone?picture=cat.jpg&sites=auto&plotter=on&pen_mm=0.5&paper=a5&style=spiral&dot_mm=3");
  const { page } = world;
  const spirals = await saved();
  assert.match(spirals, /stroke-width="0.5"/);
  const [, dots] = spirals.match(/<desc>(\d+) dots/).map(Number);
  assert.equal(spirals.match(/M/g).length, dots);
  assert.match(await page.textContent("#halftone .status"), /^spirals of radius \d/);
  assert.ok((await figures()).includes(`${dots.toLocaleString("en")} dots in 1 layer`));
  await looksAsKept(world, page.locator("#halftone .stage"), "halftone-spirals");
  await page.selectOption("#halftone .plot [data-name=style] select", "path");
  await settled(page, "halftone");
  assert.ok(await page.isHidden("#halftone .plot [data-name=dot_mm]"));
  assert.equal((await saved()).match(/M/g).length, 1);
  assert.match(await page.textContent("#halftone .status"), /^one line through the dots, \d/);
});

test("downloads formats for machines, with the given pen commands", async () => {
  await open("#halftone?sites=200");
  const { page } = world;
  const titles = () => page.locator("#halftone .download option").allTextContents();
  const formats = ["PDF", "EPS", "HPGL", "G-code", "DXF"];
  assert.deepEqual((await titles()).filter((title) => formats.includes(title)), []);
  await open("#halftone?sites=200&plotter=on&style=fill&speed=50&lift=0.5&pen_down=G1 Z-1 F300&pen_up=G0 Z2");
  assert.deepEqual((await titles()).filter((title) => formats.includes(title)), formats);
  const save = (title) => saved("halftone", title);
  assert.match(await save("PDF"), /^%PDF-/);
  assert.match(await save("EPS"), /^%!PS-Adobe[^]*\n%%BoundingBox: 0 0 596 842\n/);
  assert.equal((await save("HPGL")).match(/PD;/g).length, 200);
  assert.match(await save("G-code"), /G1 Z-1 F300\nG4 P0.25\nG0 Z2\nG4 P0.25\n/);
  assert.equal((await save("DXF")).match(/\nCIRCLE\n/g).length, 200);
});

test("draws a closed tour with marks, in files of limited time", async () => {
  await open("#halftone?picture=cat.jpg&plotter=on&style=path&closed=true&paper=a5&marks=true&sites=2000&split=time&part_minutes=2&speed=20");
  assert.match(await figures(), /a path of 6\.9 m: about 6 min/);
  const sent = world.page.waitForRequest((one) => one.url().includes("format=svg") && one.url().includes("paper"));
  const saving = download(world.page, "halftone", "SVG");
  const { searchParams } = new URL((await sent).url());
  const options = Object.fromEntries(searchParams);
  assert.deepEqual(["paper", "margin", "marks", "split", "closed", "speed"].map((name) => options[name]), ["a5", "10", "true", "2", "true", "20"]);
  const saved = await saving;
  assert.equal(saved.suggestedFilename(), "dots.zip");
  assert.match(await readFile(await saved.path(), "latin1"), /^PK[^]*dots-2\.svg/);
  await world.page.locator("#halftone .plot [data-name=margin_mm] input[type=number]").fill("2");
  await world.page.locator("#halftone .plot [data-name=margin_mm] input[type=number]").blur();
  await settled(world.page, "halftone");
  await world.page.click("#halftone .download .primary");
  await settled(world.page, "halftone", "failed");
  assert.match(await world.page.textContent("#halftone .plot"), /margin of at least 4/);
});

test("writes G-code for the chosen machine", async () => {
  await open("#halftone?sites=100&plotter=on&machine=marlin");
  assert.match(await saved("halftone", "G-code"), /G1 Z0 F1000\nG4 P75\n/);
  const { page } = world;
  await page.selectOption("#halftone .plot [data-name=machine] select", "laser");
  assert.ok(await page.isHidden("#halftone .plot [data-name=lift]"));
  await put("dwell", "0.2");
  assert.match(await saved("halftone", "G-code"), /M3 S1000\nG4 P0.2\n/);
  await page.selectOption("#halftone .plot [data-name=style] select", "path");
  await settled(page, "halftone");
  assert.ok(await page.isHidden("#halftone .plot [data-name=dwell]"));
  assert.match(await saved("halftone", "G-code"), /M4 S1000\n/);
});

test("gives no figures for a picture without dots", async () => {
  await open("#halftone?sites=200&plotter=on");
  const white = await world.page.evaluate(async () => {
    const canvas = new OffscreenCanvas(40, 30);
    const context = canvas.getContext("2d");
    context.fillStyle = "#fff";
    context.fillRect(0, 0, 40, 30);
    return [...new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer())];
  });
  await world.page.setInputFiles("#halftone .file", { name: "white.png", mimeType: "image/png", buffer: Buffer.from(white) });
  await settled(world.page, "halftone", "failed");
  assert.match(await world.page.textContent("#halftone .general"), /nothing to draw/);
  assert.equal(await world.page.textContent("#halftone .figures"), "");
});

test("has a layer for each ink, and paper of any size", async () => {
  await open("#halftone?color=cmyk&sites=2000&plotter=on&pen_mm=3&paper=a5&style=fill");
  const layers = await world.page.locator("#halftone .figures li").allTextContents();
  assert.deepEqual(layers.map((text) => text.split(":")[0]), ["cyan", "magenta", "yellow", "black"]);
  const numbers = layers.map((text) => Number(text.match(/: ([\d,]+),/)[1].replace(",", "")));
  assert.equal(numbers.reduce((a, b) => a + b), 2000);
  assert.match(await figures(), /2,000 dots in 4 layers/);
  assert.match(await saved(), /^<svg [^>]*width="148mm" height="210mm"/);
  await world.page.selectOption("#halftone .plot [data-name=paper] select", "none");
  await put("width_mm", "333");
  assert.match(await figures(), /^333 \u00d7 333 mm/);
  assert.match(await saved(), /^<svg [^>]*width="333mm" height="333mm" viewBox="0 0 333 333"/);
});

test("draws points, and the classes of a dot map", async () => {
  await open("#sample?sites=200&shape=rectangle&plotter=on&pen_mm=1.5&paper=none&width_mm=150", "sample");
  const svg = await saved("sample");
  assert.match(svg, /^<svg [^>]*width="150mm" height="100mm"/);
  assert.match(svg, /stroke-width="1.5"/);
  const path = Number(svg.match(/along a path of ([\d.]+) mm/)[1]);
  assert.match(await figures("sample"), new RegExp(`^150 \u00d7 100 mm. 200 dots in 1 layer, a path of ${(path / 1000).toPrecision(2)} m`));
  await world.page.goto("about:blank");
  await open("#sample?shape=texas.geojson&per=50000&plotter=on", "sample");
  assert.match(await figures("sample"), /dots in 2 layers/);
  const layers = await world.page.locator("#sample .figures li").allTextContents();
  assert.deepEqual(layers.map((text) => text.split(":")[0]), ["employed", "unemployed"]);
});

test("turns the paper to fit, and refuses invalid pens", async () => {
  await open("#halftone?picture=cat.jpg&plotter=on&pen_mm=3&paper=a4");
  assert.match(await saved(), /^<svg [^>]*width="297mm" height="210mm"/);
  await put("pen_mm", "0", "failed");
  assert.notEqual(await world.page.textContent("#halftone .plot [data-name=pen_mm] .error"), "");
});
