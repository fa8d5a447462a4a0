// SPDX-License-Identifier: GPL-3.0-or-later
// Starts the server and headless Chromium, and compares screenshots. Environment variables: CCDT_SERVER and
// CCDT_CHROMIUM are the programs; CCDT_NODE_MODULES is the folder of npm packages; CCDT_SHOTS is the folder for
// screenshots that differ from the expected ones. With CCDT_UPDATE=1, new screenshots replace the expected ones.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { mkdir, readFile, writeFile } from "node:fs/promises";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import path from "node:path";
import { createInterface } from "node:readline";
import { after, before, beforeEach, afterEach } from "node:test";

const require = createRequire(path.join(process.env.CCDT_NODE_MODULES, "of-the-tests"));
const { chromium } = require("playwright-core");
const axe = require.resolve("axe-core");

export const data = path.resolve(import.meta.dirname, "../data");
const kept = path.resolve(data, "../page/screenshots");

/** Flags that disable functions of Chromium that the tests do not need. */
export const quiet = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync"];

/** Limit of each wait in milliseconds. Only a fault makes a test wait this long. */
export const patience = 120_000;

// At the time limit, tests/support/supervise.py sends SIGABRT. The handler closes servers and browsers, so that the
// running test fails and reports the line that waits.
const closers = new Set();
let current = "nothing yet";
beforeEach((context) => { current = context.fullName; });
process.on("SIGABRT", () => {
  console.error(`running: ${current}`);
  for (const close of closers) close();
});

/** Registers a function that closes a server or a browser at the time limit. */
export function closeAtLimit(close) {
  closers.add(close);
}

/** Starts a server, and waits until it listens. Returns {server, url}. */
export async function startServer(flags) {
  const server = spawn(process.env.CCDT_SERVER, ["--port=0", ...flags], { stdio: ["ignore", "ignore", "pipe"] });
  closeAtLimit(() => server.kill("SIGKILL"));
  for await (const line of createInterface({ input: server.stderr })) {
    const found = line.match(/listening on (http:\S+)/);
    if (found) {
      server.stderr.resume();
      return { server, url: found[1] };
    }
  }
  throw new Error("the server does not listen");
}

/**
 * Serves pages from another origin than the server under test.
 * @param page  returns the page or the script at a path. Paths of pictures return the test data or, for unknown names,
 *              a default picture. `/nothing.png` does not exist
 */
export async function serveOrigin(page) {
  const types = { ".png": "image/png", ".jpg": "image/png", ".js": "text/javascript", ".mjs": "text/javascript", ".wasm": "application/wasm",
    ".css": "text/css", ".svg": "image/svg+xml", ".json": "application/json" };
  const server = createServer(async (request, response) => {
    const type = types[path.extname(request.url)] ?? "text/html";
    const isThere = request.url !== "/nothing.png";
    response.writeHead(isThere ? 200 : 404, { "Content-Type": type });
    const image = (name) => readFile(path.join(data, "images", name));
    const picture = () => image(path.basename(request.url)).catch(() => image("chelsea.png"));
    response.end(type === "image/png" ? isThere && await picture() : await page(request.url));
  });
  server.listen(0, "127.0.0.1");
  await once(server, "listening");
  return { url: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

/** Returns a page of another origin that loads the element from our server. */
export const elementPage = (url) => `<!DOCTYPE html><html lang="en"><title>Dots</title>
<script type="module" src="${url}/assets/element.js"></script>
<body></body></html>`;

let shared = null;
let users = 0;

/** Launches a browser of its own for a test, with additional flags. */
export async function launchChromium(...flags) {
  const browser = await chromium.launch({ executablePath: process.env.CCDT_CHROMIUM, args: [...quiet, ...flags] });
  closeAtLimit(() => browser.close());
  return browser;
}

/** Returns a browser that all tests of a file share. */
async function sharedChromium() {
  shared ??= launchChromium();
  return shared;
}

/**
 * Provides a server and a browser for the tests of a file, and a new page for each test. The pages share a context, so
 * that the browser compiles the scripts of the page once.
 * @returns  {url, page, blank, faults, newContext}. `blank` is an empty page that stays open. `page` and `faults` are
 *           filled before each test; `faults` collects unexpected errors of the page. `newContext` creates a browser
 *           context with the time limit of the tests
 */
export function useBrowser({ flags = [], viewport = { width: 1280, height: 860 } } = {}) {
  const world = { viewport };
  let running, context;
  ++users;
  world.newContext = async (options) => {
    const made = await (await sharedChromium()).newContext(options);
    made.setDefaultTimeout(patience);
    return made;
  };
  before(async () => {
    running = await startServer(flags);
    world.url = running.url;
    context = await world.newContext({ viewport: world.viewport, acceptDownloads: true });
    world.blank = await context.newPage();
  });
  after(async () => {
    await context.close();
    if (--users === 0) await (await shared).close();
    running.server.kill();
    await once(running.server, "exit");
  });
  beforeEach(async () => {
    world.page = await context.newPage();
    world.faults = [];
    world.page.on("pageerror", (error) => world.faults.push(String(error)));
    world.page.on("console", (message) => {
      if (/Content Security Policy|Refused/.test(message.text())) world.faults.push(message.text());
    });
  });
  afterEach(async () => {
    await world.page.close();
    assert.deepEqual(world.faults, []);
  });
  return world;
}

/** Opens a page in a browser without WebGL. */
export async function pageWithoutWebgl(world) {
  const context = await world.newContext({ viewport: world.viewport });
  await context.addInitScript(() => {
    const { getContext } = HTMLCanvasElement.prototype;
    HTMLCanvasElement.prototype.getContext = function (kind, ...others) {
      return kind === "webgl2" ? null : getContext.call(this, kind, ...others);
    };
  });
  return context.newPage();
}

/** Waits until a panel has the given state, `done` or `failed`, and is drawn. */
export async function settled(page, panel, state = "done") {
  await page.waitForSelector(`#${panel}[data-state=${state}]`);
  await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
}

/** Returns the file that a panel's button saves, in a format with this title. */
export async function download(page, panel, title) {
  await page.selectOption(`#${panel} .download select`, { label: title });
  const [saved] = await Promise.all([page.waitForEvent("download"), page.click(`#${panel} .download .primary`)]);
  await settled(page, panel);
  return saved;
}

/**
 * Fails if axe-core finds a violation. The context must bypass the Content Security Policy.
 * @param where  selector of the part to examine; without it, the whole document is examined
 * @param tags   tags of the rules to apply; without them, all rules are applied
 */
export async function isAccessible(page, { where, tags, about } = {}) {
  if (await page.evaluate(() => !window.axe)) await page.addScriptTag({ path: axe });
  const violations = await page.evaluate(async ([selector, rules]) => {
    const found = await window.axe.run(selector ?? document, { resultTypes: ["violations"], ...(rules && { runOnly: rules }) });
    return found.violations.map(({ id, nodes }) => [id, nodes.map(({ html }) => html)]);
  }, [where, tags]);
  assert.deepEqual(violations, [], about);
}

/** Sizes and themes in which pages must be accessible. Themes differ only in colours. */
export const appearances = ["light", "dark"].flatMap((colorScheme) => [["wide", { width: 1280, height: 860 }], ["narrow", { width: 390, height: 844 }]]
  .map(([size, viewport]) => ({ colorScheme, size, viewport, ...(colorScheme === "dark" && { tags: ["cat.color"] }) })));

/** Moves a slider through values and then releases it, as a user does. */
export async function slide(locator, values) {
  await locator.evaluate((slider, steps) => {
    for (const value of steps) {
      slider.value = value;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    }
    slider.dispatchEvent(new Event("change", { bubbles: true }));
  }, values);
}

/** Returns a program's standard output; fails unless it exits with 0. */
export async function run(command, args, options = {}) {
  const child = spawn(command, args, { stdio: ["ignore", "pipe", "pipe"], ...options });
  const output = { stdout: "", stderr: "" };
  for (const name of ["stdout", "stderr"]) child[name].on("data", (text) => { output[name] += text; });
  const [code] = await once(child, "close");
  assert.equal(code, 0, output.stderr);
  return output.stdout;
}

/** Environment in which the command `ccdt` and the Python package of the same build are found. */
const built = path.dirname(process.env.CCDT_SERVER);
export const local = { ...process.env, PATH: `${built}:${process.env.PATH}`, PYTHONPATH: path.join(built, "python") };

/** Whether the Python package was built. */
export const hasPackage = () => run("/usr/bin/python3", ["-c", "import ccdt"], { env: local }).then(() => true, () => false);

/**
 * Runs a script in a new page, and returns its output to the console. If the script asks for a file, chooses `file`.
 */
export async function runInBrowser(world, script, file) {
  const page = await world.page.context().newPage();
  await page.goto(`${world.url}/assets/reference.html`);
  const said = page.waitForEvent("console");
  const done = page.evaluate(`(async () => {${script}})()`);
  if (file) await page.setInputFiles("input[type=file]", file);
  await done;
  const text = (await said).text();
  await page.close();
  return `${text}\n`;
}

/** Runs in a page. Compares two pictures at a quarter of the width. The second picture is already reduced. */
async function compareIn([now, then]) {
  const pixelsOf = async (base64, factor) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
    const canvas = document.createElement("canvas");
    canvas.width = Math.round(bitmap.width / factor);
    canvas.height = Math.round(bitmap.height / factor);
    const context = canvas.getContext("2d");
    context.imageSmoothingQuality = "high";
    context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
    return { canvas, ...{ width: canvas.width, height: canvas.height },
      values: context.getImageData(0, 0, canvas.width, canvas.height).data };
  };
  const reduced = await pixelsOf(now, 4);
  const result = { reduced: reduced.canvas.toDataURL().split(",")[1], sizes: [[reduced.width, reduced.height]] };
  if (!then) return result;
  const old = await pixelsOf(then, 1);
  result.sizes.push([old.width, old.height]);
  let different = 0;
  for (let i = 0; i < Math.min(old.values.length, reduced.values.length); ++i)
    if (Math.abs(old.values[i] - reduced.values[i]) > 40) ++different;
  result.share = different / old.values.length;
  return result;
}

/**
 * Compares a screenshot with the expected one, at a quarter of the size and with a tolerance for text. Hides the menus
 * of formats, whose entries come from the server.
 */
export async function looksAsKept(world, target, name) {
  const showFormats = (display) => (target.page?.() ?? target).evaluate((how) => {
    for (const place of document.querySelectorAll(".download select")) place.style.display = how;
  }, display);
  await showFormats("none");
  const shot = await target.screenshot({ animations: "disabled" });
  await showFormats("");
  const file = path.join(kept, `${name}.png`);
  const then = process.env.CCDT_UPDATE ? null : await readFile(file);
  const result = await world.blank.evaluate(compareIn, [shot.toString("base64"), then?.toString("base64") ?? null]);
  if (!then) {
    await mkdir(kept, { recursive: true });
    return writeFile(file, Buffer.from(result.reduced, "base64"));
  }
  const isAsKept = String(result.sizes[0]) === String(result.sizes[1]) && result.share < 0.02;
  if (isAsKept) return;
  await mkdir(process.env.CCDT_SHOTS, { recursive: true });
  await writeFile(path.join(process.env.CCDT_SHOTS, `${name}.png`), shot);
  assert.fail(`${name}: sizes ${result.sizes.join(" and ")}, ${(100 * result.share).toFixed(2)} % differ`);
}
