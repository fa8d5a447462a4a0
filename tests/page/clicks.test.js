// SPDX-License-Identifier: GPL-3.0-or-later
// Checks that random clicks, keys and files in any order cause no unexpected errors. CCDT_CLICK_STEPS and
// CCDT_CLICK_SEED set the number of actions and the first seed, in each browser.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import path from "node:path";
import { test } from "node:test";

import { closeAtLimit, data, patience, settled, startServer, useBrowser } from "./harness.js";

const steps = Number(process.env.CCDT_CLICK_STEPS ?? 80);
const seed = Number(process.env.CCDT_CLICK_SEED ?? 1);
const narrow = { width: 390, height: 844 };

/** Returns a generator of pseudo-random numbers in [0, 1) (mulberry32). */
function randomFrom(state) {
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

const shapes = [
  { type: "Polygon", coordinates: [[[0, 0], [4, 0], [4, 3], [0, 0]]] },
  { type: "Polygon", coordinates: [[[0, 0], [1, 1], [2, 2], [0, 0]]] },
  { type: "FeatureCollection", features: [] },
  { type: "Feature", properties: null, geometry: null },
  { type: "Polygon", coordinates: [[[170, 60], [-170, 60], [-170, 70], [170, 70]]] },
  { type: "MultiPolygon", coordinates: [[[[0, 0], [1e6, 0], [1e6, 1e6]]], [[[3e6, 0], [4e6, 0], [4e6, 1e6]]]] },
  [[0, 0], [4, 0], [4, 3]], { polygon: [[0, 0], [4, 0], [4, 3]] }, { polygon: 7 }, null, 3,
];

/**
 * Runs in the page. Uses one of the existing controls, chosen by `dice`.
 *
 * @param dice  numbers in [0, 1)
 * @returns     {done, press}: a description, and the position that the caller must click, if any
 */
function actIn({ dice, text, picture }) {
  const pick = (list, die) => list[Math.floor(die * list.length)];
  const drop = (place, name, content, type) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([content], name, { type }));
    place.dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true }));
    return { done: `drop ${name}` };
  };
  const controls = [...document.querySelectorAll("button, select, input, textarea, summary, canvas, .drop")]
    .filter((one) => one.checkVisibility() && !one.disabled && !one.closest(".download, #access"));
  const control = pick(controls, dice[0]);
  const dispatch = (...names) => names.forEach((name) => control.dispatchEvent(new Event(name, { bubbles: true })));
  const name = `${control.tagName} ${control.id} ${control.className} ${control.getAttribute("aria-label") ?? control.textContent.slice(0, 20)}`;
  if (control.matches(".drop")) {
    if (dice[1] < 0.5) return drop(control, "shape.json", text, "application/json");
    return drop(control, "picture.png", dice[2] < 0.3 ? text : Uint8Array.from(atob(picture), (c) => c.charCodeAt(0)), "image/png");
  }
  if (control.matches("canvas, button, summary, [type=checkbox]")) {
    control.scrollIntoView({ block: "nearest" });
    const { x, y, width, height } = control.getBoundingClientRect();
    return { done: name, press: [x + (0.05 + 0.9 * dice[1]) * width, y + (0.05 + 0.9 * dice[2]) * height] };
  }
  if (control.matches("[type=file]")) return { done: "nothing" };
  if (control.matches("select")) control.selectedIndex = Math.floor(dice[1] * control.options.length);
  else if (control.matches("textarea")) control.value = text;
  else if (control.matches("[type=range]")) control.value = Number(control.min) + dice[1] * (Number(control.max) - Number(control.min));
  else if (control.matches("[type=number]")) control.value = pick(["", "0", "-3", "1", "7", "250", "1e9", "0.001"], dice[1]);
  else if (control.matches("[type=color]")) control.value = pick(["#000000", "#ffffff", "#ff48b0"], dice[1]);
  dispatch(...(control.matches("[type=range], [type=color]") && dice[3] < 0.4 ? ["input"] : ["input", "change"]));
  return { done: `${name} = ${control.value}` };
}

const keys = ["Enter", "Escape", "Backspace", "Control+z", "+", "-", "0", "ArrowLeft"];

/**
 * Uses random controls.
 * @param press  presses one or more keys on the keyboard of the browser
 */
async function clickAround(page, press, faults) {
  const picture = (await readFile(path.join(data, "images/chelsea.png"))).toString("base64");
  const random = randomFrom(seed);
  const last = [];
  for (let step = 0; step < steps; ++step) {
    const dice = [random(), random(), random(), random()];
    const text = JSON.stringify(shapes[Math.floor(random() * shapes.length)]);
    const { done, press: place } = await page.evaluate(actIn, { dice, text, picture });
    if (place) await page.mouse.click(...place);
    const key = random() < 0.15 ? keys[Math.floor(random() * keys.length)] : null;
    if (key) await press(key);
    last.push(done, ...(key ? [key] : []));
    if (last.length > 20) last.shift();
    assert.deepEqual(faults, [], last.join("\n"));
  }
  assert.ok(await page.evaluate(() => document.querySelector(".panel:not([hidden])") !== null), "a panel is shown");
}

const world = useBrowser({ flags: ["--max-sites=50000"] });

for (const viewport of [{ width: 1280, height: 860 }, narrow]) {
  test(`in Chromium, ${viewport.width} wide`, async () => {
    const { page } = world;
    await page.setViewportSize(viewport);
    await page.goto(world.url);
    await settled(page, "halftone");
    await clickAround(page, (key) => page.keyboard.press(key), world.faults);
  });
}

test("in Firefox", { skip: !process.env.CCDT_FIREFOX }, async () => {
  const require = createRequire(path.join(process.env.CCDT_NODE_MODULES, "of-the-tests"));
  const puppeteer = require("puppeteer-core");
  const running = await startServer(["--max-sites=50000"]);
  const browser = await puppeteer.launch({ browser: "firefox", executablePath: process.env.CCDT_FIREFOX, timeout: patience });
  closeAtLimit(() => browser.process().kill("SIGKILL"));
  try {
    const page = await browser.newPage();
    page.setDefaultTimeout(patience);
    const faults = [];
    page.on("pageerror", (error) => faults.push(String(error)));
    await page.setViewport({ width: 1280, height: 860 });
    await page.goto(running.url);
    await page.waitForSelector("#halftone[data-state=done]");
    const press = async (key) => {
      const names = key.split(/(?<=.)\+/);
      for (const name of names) await page.keyboard.down(name);
      for (const name of names.reverse()) await page.keyboard.up(name);
    };
    await clickAround(page, press, faults);
  } finally {
    await browser.close();
    running.server.kill();
  }
});
