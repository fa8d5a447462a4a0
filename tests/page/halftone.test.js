// SPDX-License-Identifier: GPL-3.0-or-later
// Panel that turns a picture into dots.

import assert from "node:assert/strict";
import { mkdtemp, readFile, rm, stat, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";

import { data, hasPackage, local, looksAsKept, run, runInBrowser, settled, slide, useBrowser } from "./harness.js";

const world = useBrowser();
const picture = path.join(data, "images/camera.png");
const slider = (name) => world.page.locator(`#halftone .fields [data-name=${name}] input[type=range]`);
const number = (name) => world.page.locator(`#halftone .fields [data-name=${name}] input[type=number]`);

const few = "#halftone?sites=500";  // for tests in which the number of dots does not matter

async function open(address = "") {
  await world.page.goto(`${world.url}/${address}`);
  await settled(world.page, "halftone");
}

/** Returns a list that collects all requests for dots from now on, with their outcomes. */
function watchRequests() {
  const seen = [];
  const isDots = (request) => request.url().includes("/halftone?");
  world.page.on("request", (request) => { if (isDots(request)) seen.push({ request, url: request.url() }); });
  world.page.on("requestfailed", (request) => {
    const entry = seen.find((one) => one.request === request);
    if (entry) entry.failed = request.failure().errorText;
  });
  return seen;
}

test("shows one of its own pictures as dots", async () => {
  await open();
  assert.match(await world.page.textContent("#halftone .status"), /^20,000 dots, \d/);
  await looksAsKept(world, world.page.locator("#halftone .canvas-frame"), "halftone");
});

test("accepts a picture that is chosen, dropped or pasted", async () => {
  await open();
  await world.page.setInputFiles("#halftone .file", picture);
  await settled(world.page, "halftone");
  await looksAsKept(world, world.page.locator("#halftone .canvas-frame"), "halftone-chosen");
  const bytes = (await readFile(picture)).toString("base64");
  for (const [kind, name] of [["drop", "dropped.png"], ["paste", "pasted.png"]]) {
    await world.page.click("#halftone [data-sample='cat.jpg']");
    await settled(world.page, "halftone");
    await world.page.evaluate(([event, file, base64]) => {
      const content = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
      const transfer = new DataTransfer();
      transfer.items.add(new File([content], file, { type: "image/png" }));
      if (event === "drop") document.querySelector("h1, header").dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true }));
      else document.dispatchEvent(new ClipboardEvent("paste", { clipboardData: transfer }));
    }, [kind, name, bytes]);
    await settled(world.page, "halftone");
    assert.match(await world.page.textContent("#halftone pre"), new RegExp(name));
    assert.match(await world.page.textContent("#halftone .status"), /, 1000 \u00d7 1000 pixels/);  // the cat is wider
  }
});

test("sends a picture that has changed on disk since it was chosen", async () => {
  await open(few);
  const folder = await mkdtemp(path.join(tmpdir(), "ccdt-"));
  const file = path.join(folder, "edited.png");
  await writeFile(file, await readFile(picture));
  await world.page.setInputFiles("#halftone .file", file);
  await settled(world.page, "halftone");
  await writeFile(file, "changed");
  await slide(slider("detail"), [0.3]);
  await settled(world.page, "halftone");
  await rm(folder, { recursive: true });
});

test("shows a draft while a slider is held", async () => {
  await open();
  const seen = watchRequests();
  await slider("sites").evaluate((input) => {
    input.value = 7;
    input.dispatchEvent(new Event("input", { bubbles: true }));
  });
  await settled(world.page, "halftone");
  assert.equal(seen.length, 1);
  assert.match(seen[0].url, /sites=1090&.*quality=draft/);
  await looksAsKept(world, world.page.locator("#halftone .canvas-frame"), "halftone-draft");
});

test("draws the preset of one line with a pen", async () => {
  await open();
  const { page } = world;
  const asked = page.waitForRequest((request) => request.url().includes("format=svg"));
  await page.getByRole("button", { name: "One line" }).click();
  const { style, width_mm, dots, sites } = Object.fromEntries(new URL((await asked).url()).searchParams);
  assert.deepEqual({ style, width_mm, dots, sites }, { style: "path", width_mm: "190", dots: "ink", sites: undefined });
  await settled(page, "halftone");
  assert.match(await page.textContent("#halftone .status"), /^one line through the dots/);
});

test("applies presets to all their fields", async () => {
  await open();
  const { page } = world;
  const seen = watchRequests();
  const preset = (name) => page.getByRole("group", { name: "Style" }).getByRole("button", { name });
  const pressed = () => page.locator("#halftone .presets [aria-pressed=true]").allTextContents();
  assert.deepEqual(await pressed(), ["Ink and paper"]);
  await preset("Newspaper").click();
  await settled(page, "halftone");
  const { antialias, ...options } = Object.fromEntries(new URL(seen.at(-1).url).searchParams);
  assert.deepEqual(options, { sites: "9000", dots: "ink", foreground: "#1d1b18", background: "#efe9dc" });
  assert.deepEqual(await pressed(), ["Newspaper"]);
  const risograph = page.waitForRequest((request) => request.url().includes("palette="));
  await preset("Risograph").click();
  assert.equal(new URL((await risograph).url()).searchParams.get("palette"), "#0078bf,#ff48b0,#ffe800");
  await number("sites").fill("5000");
  await number("sites").blur();
  await settled(page, "halftone");
  assert.deepEqual(await pressed(), []);
  await page.goBack();  // the number has no separate entry in the history
  await settled(page, "halftone");
  assert.deepEqual(await pressed(), ["Newspaper"]);
});

test("keeps a photograph of the user among the pictures", async () => {
  await open(few);
  const { page } = world;
  await page.setInputFiles("#halftone .file", path.join(data, "images/chelsea.png"));
  await settled(page, "halftone");
  await page.click("#halftone [data-sample='cat.jpg']");
  await settled(page, "halftone");
  const own = page.getByRole("button", { name: "chelsea.png" });
  assert.equal(await own.getAttribute("aria-pressed"), "false");
  await own.click();
  await settled(page, "halftone");
  assert.equal(await own.getAttribute("aria-pressed"), "true");
  assert.match(await page.textContent("#halftone pre"), /chelsea\.png/);
});

test("keeps the picture that was chosen last, even if an earlier one arrives later", async () => {
  await open(few);
  const { page } = world;
  let release;
  const held = new Promise((resolve) => { release = resolve; });
  await page.route("**/cat.jpg", async (route) => {
    await held;
    await route.continue();
  });
  const arrived = page.waitForResponse("**/cat.jpg");
  await page.click("#halftone [data-sample='cat.jpg']");
  await page.click("#halftone [data-sample='camera.jpg']");
  await settled(page, "halftone");
  release();
  await (await arrived).finished();
  await settled(page, "halftone");
  assert.equal(await page.getAttribute("#halftone [data-sample='camera.jpg']", "aria-pressed"), "true");
  assert.match(await page.textContent("#halftone pre"), /camera\.jpg/);
});

test("keeps the last result if another picture cannot be loaded", async () => {
  await open();
  const { page } = world;
  await page.route("**/cat.jpg", (route) => route.abort());
  await page.click("#halftone [data-sample='cat.jpg']");
  await settled(page, "halftone", "failed");
  assert.equal(await page.textContent("#halftone .general"), "The server cannot be reached");
  assert.match(await page.textContent("#halftone .status"), /^20,000 dots/);
});

test("shows the colours of inverted pictures", async () => {
  await open(few);
  const { page } = world;
  const colours = () => page.locator("#halftone .fields :is([data-name=foreground], [data-name=background]) input[type=color]")
    .evaluateAll((wells) => wells.map(({ value }) => value));
  assert.deepEqual(await colours(), ["#000000", "#ffffff"]);
  await page.selectOption("#halftone [data-name=dots] select", "paper");
  await settled(page, "halftone");
  assert.deepEqual(await colours(), ["#ffffff", "#000000"]);
  assert.doesNotMatch(await page.textContent("#halftone pre"), /(fore|back)ground/);
  await page.locator("#halftone [data-name=foreground] input").fill("#ffcc00");
  await page.selectOption("#halftone [data-name=dots] select", "both");
  await settled(page, "halftone");
  assert.deepEqual(await colours(), ["#ffcc00", "#ffffff"]);
});

test("follows a slider with drafts, and is complete once it rests", async () => {
  await open();
  const seen = watchRequests();
  await slide(slider("sites"), [7, 7.5, 8, 8.5]);
  await settled(world.page, "halftone");
  const isDraft = ({ url }) => url.includes("quality=draft") && url.includes("iterations=1") && url.includes("passes=2");
  assert.deepEqual(seen.map(isDraft), [true, false]);
  assert.match(seen[0].failed, /ABORTED/);  // outdated once the slider rests
  const sites = await number("sites").inputValue();
  assert.equal(new URL(seen[1].url).searchParams.get("sites"), sites);
  assert.match(await world.page.textContent("#halftone .status"), new RegExp(`^${Number(sites).toLocaleString("en")} dots`));
});

/** Makes a photograph of 1.5 megapixels, and an animation of two frames. */
async function makePictures(folder) {
  await run("/usr/bin/python3", ["-c", `
import PIL.Image
cat = PIL.Image.open("${path.join(data, "images/chelsea.png")}").convert("RGB")
cat.resize((1500, 1000)).save("large.jpg", quality=95)
cat.resize((90, 60)).save("film.gif", save_all=True, append_images=[cat.resize((90, 60)).rotate(90)])`], { cwd: folder });
}

test("sends a large photograph reduced for drafts, and whole once the slider rests", async () => {
  const folder = await mkdtemp(path.join(tmpdir(), "ccdt-page-"));
  await makePictures(folder);
  const { size } = await stat(path.join(folder, "large.jpg"));
  await world.page.addInitScript(() => {
    const [read, send] = [window.createImageBitmap, window.fetch];
    window.last = {};
    window.fetch = (url, options) => {
      if (new URL(url).pathname === "/halftone") window.last.sent = options.body.size;
      return send(url, options);
    };
    window.createImageBitmap = async (blob) => {
      const bitmap = await read(blob);
      window.last.width = bitmap.width;
      return bitmap;
    };
  });
  await open(few);
  await world.page.setInputFiles("#halftone .file", path.join(folder, "large.jpg"));
  await settled(world.page, "halftone");
  /** Returns the query, the body and the answer of the request that an action causes. */
  const during = async (act) => {
    const [response] = await Promise.all([world.page.waitForResponse((one) => one.url().includes("/halftone?")), act()]);
    await settled(world.page, "halftone");
    return { query: new URL(response.url()).searchParams, ...(await world.page.evaluate(() => window.last)) };
  };
  const radius = () => number("dot").inputValue();
  const before = await radius();
  await during(() => slider("detail").dispatchEvent("input"));
  assert.ok(Math.abs(await radius() / before - 1) < 0.1, `${await radius()} and ${before}`);
  await during(() => world.page.uncheck("#halftone .fields [data-name=dot] input[type=checkbox]"));
  const draft = await during(() => slider("dot").evaluate((input) => {
    input.value = Math.log(6);
    input.dispatchEvent(new Event("input", { bubbles: true }));
  }));
  const whole = await during(() => slider("dot").dispatchEvent("change"));
  assert.ok(draft.sent < size / 4 && whole.sent === size, `${draft.sent}, ${whole.sent} of ${size} bytes`);
  assert.ok(draft.query.get("quality") === "draft" && draft.width <= 2 * Math.sqrt(1.5 * 300_000));
  const share = ({ query, width }) => Number(query.get("dot")) / width;  // the dot's radius over the picture's width
  assert.ok(Math.abs(share(draft) / share(whole) - 1) < 0.01, `${share(draft)} and ${share(whole)}`);
  await rm(folder, { recursive: true });
});

test("shows which frame of an animation is used", async () => {
  const folder = await mkdtemp(path.join(tmpdir(), "ccdt-page-"));
  await makePictures(folder);
  await open(few);
  await world.page.setInputFiles("#halftone .file", path.join(folder, "film.gif"));
  await settled(world.page, "halftone");
  assert.match(await world.page.textContent("#halftone .warnings"), /2 frames: the first is used/);
  await world.page.click("#halftone [data-sample='cat.jpg']");
  await settled(world.page, "halftone");
  assert.equal(await world.page.textContent("#halftone .warnings"), "");
  await rm(folder, { recursive: true });
});

test("requests the values of its fields", async () => {
  await open(few);
  const seen = watchRequests();
  await world.page.click("#halftone .more summary");
  await world.page.fill("#halftone .more [data-name=seed] input[type=number]", "7");
  await world.page.selectOption("#halftone [data-name=dots] select", "paper");
  await world.page.selectOption("#halftone [data-name=tone] select", "perceptual");
  await world.page.locator("#halftone [data-name=foreground] input").fill("#102a66");
  await world.page.check("#halftone [data-name=background] input[type=checkbox]");
  await world.page.uncheck("#halftone [data-name=dot] input[type=checkbox]");
  await number("dot").fill("2.5");
  await number("dot").blur();
  await settled(world.page, "halftone");
  assert.deepEqual(Object.fromEntries(new URL(seen.at(-1).url).searchParams), {
    sites: "500", dot: "2.5", tone: "perceptual", dots: "paper", foreground: "#102a66",
    background: "transparent", seed: "7", width: "1000",
  });
});

const optionsOf = (seen) => {
  const { sites, antialias, ...others } = Object.fromEntries(new URL(seen.at(-1).url).searchParams);
  return others;
};

test("replaces the number of dots by their radius, except for dots of one size", async () => {
  await open(few);
  const seen = watchRequests();
  await world.page.uncheck("#halftone [data-name=dot] input[type=checkbox]");
  await number("dot").fill("2.5");
  await number("dot").blur();
  await settled(world.page, "halftone");
  const sites = world.page.locator("#halftone [data-name=sites]");
  const requested = () => new URL(seen.at(-1).url).searchParams.get("sites");
  assert.deepEqual([requested(), await sites.isVisible()], [null, false]);
  await world.page.selectOption("#halftone [data-name=dots] select", "ink");
  await settled(world.page, "halftone");
  assert.deepEqual([requested(), await sites.isVisible()], ["500", true]);
});

test("emphasizes edges, and sets levels like an image editor", async () => {
  await open();
  const seen = watchRequests();
  await slide(slider("detail"), [0.9, 1]);
  await settled(world.page, "halftone");
  assert.deepEqual(optionsOf(seen), { detail: "1" });
  const levels = world.page.getByRole("group", { name: "Levels" });
  for (const [name, value] of [["black point", "0.1"], ["white point", "0.85"], ["gamma", "1.4"]]) {
    await levels.getByLabel(name).fill(value);
    await world.page.keyboard.press("Tab");
  }
  await settled(world.page, "halftone");
  assert.deepEqual(optionsOf(seen), { detail: "1", levels: "0.1,0.85,1.4" });
  await looksAsKept(world, world.page.locator("#halftone .canvas-frame"), "halftone-levels");
  await levels.getByLabel("black point").fill("0.9");
  await levels.getByLabel("black point").blur();
  await settled(world.page, "halftone", "failed");
  assert.match(await world.page.textContent("#halftone [data-name=levels] .error"), /black point below the white point/);
});

test("sets levels by brightness and contrast, and for the picture", async () => {
  await open("#halftone?picture=cat.jpg&sites=500");
  const seen = watchRequests();
  const levels = async () => {
    await settled(world.page, "halftone");
    return optionsOf(seen).levels;
  };
  await slide(world.page.getByLabel("Brightness"), [0.3, 0.5]);
  assert.equal(await levels(), "0,1,1.73");
  await slide(world.page.getByLabel("Contrast"), [0.2, 0.4]);
  assert.equal(await levels(), "0.2,0.8,1.73");
  await world.page.getByRole("group", { name: "Levels" }).getByLabel("black point").fill("0");
  await world.page.keyboard.press("Tab");
  assert.equal(await levels(), "0,0.8,1.73");
  await slide(world.page.getByLabel("Contrast"), [0.1]);
  assert.equal(await levels(), "0,0.9,1.73");
  await world.page.getByLabel("Auto levels").first().click();
  const [black, white, gamma] = (await levels()).split(",").map(Number);
  assert.ok(black > 0 && black < 0.2 && white > 0.7 && white < 1 && gamma === 1, `${black} ${white} ${gamma}`);
});

test("derives the number of dots from the picture, or from a pen", async () => {
  await open();
  const seen = watchRequests();
  await world.page.check("#halftone [data-name=sites] input[type=checkbox]");
  await settled(world.page, "halftone");
  assert.ok(!new URL(seen.at(-1).url).searchParams.has("sites"));
  assert.match(await world.page.textContent("#halftone .status"), /^dots of radius \d/);
  const width = world.page.locator("#halftone .fields [data-name=width_mm]");
  assert.ok(await width.isHidden());
  await world.page.uncheck("#halftone [data-name=dot] input[type=checkbox]");
  await number("dot").fill("0.5");
  await world.page.getByLabel("Radius, unit").selectOption("mm");
  await settled(world.page, "halftone");
  assert.ok(await width.isVisible());
  assert.deepEqual(optionsOf(seen), { dot: "0.5mm", width_mm: "200" });
  await number("width_mm").fill("100");
  await number("width_mm").blur();
  await settled(world.page, "halftone");
  assert.deepEqual(optionsOf(seen), { dot: "0.5mm", width_mm: "100" });
  assert.match(await world.page.textContent("#halftone .status"), /^dots of radius 2\.56,/);
  await looksAsKept(world, world.page.locator("#halftone .controls"), "halftone-pen");
});

/** Waits until most pixels of the canvas are black or white: dots have thin grey edges, but enlarged pixels are grey. */
const showsDots = () => world.page.waitForFunction(() => {
  const canvas = document.querySelector("#halftone canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let grey = 0;
  for (let i = 0; i < data.length; i += 4) if (data[i] > 30 && data[i] < 225) ++grey;
  return grey < 0.03 * canvas.width * canvas.height;
});

test("divides the picture from its dots, and zooms to single dots", async () => {
  await open();
  const frame = world.page.locator("#halftone .canvas-frame");
  const { x, y, width, height } = await world.page.locator(".divider").boundingBox();
  const knob = (share) => [x + 16 + share * (width - 32), y + height / 2];
  await world.page.mouse.move(...knob(0.1));
  await world.page.mouse.down();
  await world.page.mouse.move(...knob(0.6), { steps: 5 });
  await world.page.mouse.up();
  assert.ok(Math.abs(await world.page.inputValue(".divider") - 60) <= 1);
  await settled(world.page, "halftone");
  await looksAsKept(world, frame, "halftone-divided");
  await world.page.focus(".divider");
  await world.page.keyboard.press("Home");
  await world.page.focus("#halftone canvas");
  for (let i = 0; i < 12; ++i) await world.page.keyboard.press("+");
  await showsDots();
  await looksAsKept(world, frame, "halftone-zoomed");
  await world.page.keyboard.press("0");
  await world.page.click("#halftone [aria-label='Zoom in']");
  await world.page.click("#halftone [aria-label=Fit]");
});

/** Returns the pixels of the canvas in its left and its right half, as texts. */
const halves = () => world.page.evaluate(() => {
  const canvas = document.querySelector("#halftone canvas");
  const half = Math.floor(canvas.width / 2) - 20;  // without the divider
  return [0, canvas.width - half].map((x) => String(canvas.getContext("2d").getImageData(x, 0, half, canvas.height).data));
});

test("compares two settings, and names their differences", async () => {
  await open(few);
  const { page } = world;
  const place = page.locator("#halftone .comparison");
  const rows = async () => (await place.locator("tbody tr").all()).length && place.locator("tbody tr").evaluateAll((all) =>
    all.map(({ cells }) => [...cells].map(({ textContent }) => textContent)));
  await place.getByRole("button", { name: "Keep as A" }).click();
  await settled(page, "halftone");
  assert.equal(await page.inputValue(".divider"), "50");
  const before = await halves();
  await number("sites").fill("900");
  await number("sites").blur();
  await page.selectOption("#halftone [data-name=color] select", "palette");
  await settled(page, "halftone");
  assert.deepEqual(await rows(), [["Dots", "500", "900"], ["Inks", "one", "a palette"]]);
  const after = await halves();
  assert.equal(after[0], before[0]);
  assert.notEqual(after[1], before[1]);
  assert.match(await page.getAttribute(".divider", "aria-valuetext"), /^50 % A$/);
  await page.focus("#halftone canvas");
  for (let i = 0; i < 12; ++i) await page.keyboard.press("+");
  await page.locator(".divider").fill("100");
  await showsDots();
  await place.getByRole("button", { name: "Back to A" }).click();
  await settled(page, "halftone");
  assert.equal(await number("sites").inputValue(), "500");
  assert.equal(await rows(), 0);
  await page.getByRole("button", { name: "Risograph" }).click();
  await settled(page, "halftone");
  assert.deepEqual((await rows())[2], ["Palette", "\u2013", "Blue, Fluorescent pink, Yellow"]);
  await page.click("#halftone [data-sample='cat.jpg']");
  await settled(page, "halftone");
  assert.ok(await place.getByRole("button", { name: "Keep as A" }).isVisible());
  assert.equal(await page.inputValue(".divider"), "10");
});

test("keeps the divider within the picture on a phone across", async () => {
  const { page, viewport } = world;
  await page.setViewportSize({ width: 844, height: 390 });
  await open();
  const box = await page.locator(".divider").boundingBox();
  const frame = await page.locator("#halftone .canvas-frame").boundingBox();
  assert.ok(Math.abs(box.x + box.width / 2 - frame.x - frame.width / 2) <= 1, String(box.x));
  assert.ok(box.width < 0.7 * frame.width && Math.abs(box.width + 32 - frame.height) <= 1, String(box.width));
  await page.click("#halftone [aria-label='Zoom in']", { clickCount: 6 });
  await settled(page, "halftone");
  assert.equal((await page.locator(".divider").boundingBox()).width, frame.width);
  await page.setViewportSize(viewport);
});

test("leaves the swipes of a finger to the page if the picture fits", async () => {
  const context = await world.newContext({ viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  const page = await context.newPage();
  await page.goto(`${world.url}/${few}`);
  await settled(page, "halftone");
  const devtools = await context.newCDPSession(page);
  const touch = (type, ...touchPoints) => devtools.send("Input.dispatchTouchEvent", { type, touchPoints });
  /** Returns by how many pixels the page scrolls if a finger moves up on the picture. */
  const swipe = async () => {
    await page.evaluate(() => scrollTo(0, 0));
    await touch("touchStart", { x: 200, y: 400 });
    for (let y = 380; y >= 200; y -= 20) await touch("touchMove", { x: 200, y });
    await touch("touchEnd");
    await settled(page, "halftone");
    return page.evaluate(() => scrollY);
  };
  assert.ok(await swipe() > 100);
  await page.evaluate(() => scrollTo(0, 0));
  await page.click("#halftone [aria-label='Zoom in']");
  await settled(page, "halftone");
  assert.equal(await swipe(), 0);
  await context.close();
});

test("shows numbers that the server has chosen", async () => {
  const { page } = world;
  await open();
  const number = (name) => page.inputValue(`#halftone [data-name=${name}]:not([hidden]) input[type=number]`);
  assert.deepEqual([await number("width"), await number("height"), await number("scale")], ["1000", "1000", "1.95"]);
  assert.ok(Math.abs(await number("dot") - Math.sqrt(1e6 / 20000 / 10)) < 0.5, await number("dot"));
  const request = await page.textContent("#halftone pre");
  const auto = page.locator("#halftone [data-name=sites] input[type=checkbox]");
  await auto.check();
  await settled(page, "halftone");
  assert.equal(await number("sites"), "");
  assert.ok(!(await page.textContent("#halftone pre")).includes("?"));
  await auto.uncheck();
  await settled(page, "halftone");
  assert.equal(await page.textContent("#halftone pre"), request);
});

test("copies the picture", async () => {
  const { page } = world;
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  await open("#halftone?sites=500&width=300");
  const size = () => page.evaluate(async () => {
    const [item] = await navigator.clipboard.read();
    const { width, height } = await createImageBitmap(await item.getType("image/png"));
    return [width, height];
  });
  await page.click("#halftone .copy-picture");
  await page.getByText("Copied").waitFor();
  assert.deepEqual(await size(), [300, 300]);
  assert.match(await page.textContent("#halftone .status"), /^500 dots/);
  await page.goto(`${world.url}/#devices?width=90&height=60&format=raw`);
  await settled(page, "devices");
  await page.click("#devices .copy-picture");
  await page.locator("#devices").getByText("Copied").waitFor();
  assert.deepEqual(await size(), [90, 60]);
  await page.context().clearPermissions();
});

test("shows an element that requests the same dots", async () => {
  await open("#halftone?sites=700&color=cmyk&width=300&on_deadline=partial");
  const { page } = world;
  await page.click('#halftone .kinds button:text-is("HTML")');
  const text = await page.textContent("#halftone pre");
  assert.match(text, /^<!-- without on_deadline,/);
  await page.goto(`${world.url}/assets/reference.html`);
  const asked = page.waitForRequest((request) => request.url().includes("/halftone?"));
  await page.evaluate(async (html) => {
    document.body.insertAdjacentHTML("beforeend", html);
    await import(document.querySelector("script[src$='element.js']").src);
  }, text);
  const { sites, color, width } = Object.fromEntries(new URL((await asked).url()).searchParams);
  assert.deepEqual({ sites, color, width }, { sites: "700", color: "cmyk", width: "300" });
});

test("selects the request if the browser does not allow copying", async () => {
  await open(few);
  const { page } = world;
  const copy = page.locator("#halftone .copy");
  for (const [isAllowed, said] of [[true, "Copied"], [false, "Selected"]]) {
    await page.evaluate((allowed) => {
      navigator.clipboard.writeText = () => (allowed ? Promise.resolve() : Promise.reject(new DOMException("denied", "NotAllowedError")));
    }, isAllowed);
    await copy.click();
    await page.waitForFunction((text) => document.querySelector("#halftone .copy").textContent === text, said);
    assert.equal(await page.evaluate(() => getSelection().toString().trim()), (await page.textContent("#halftone pre")).trim());
  }
});

test("shows commands that send the same request when pasted", async () => {
  await open();
  await number("sites").fill("700");
  await number("sites").blur();
  await settled(world.page, "halftone");
  const folder = await mkdtemp(path.join(tmpdir(), "ccdt-page-"));
  const snippet = async (kind) => {
    await world.page.click(`#halftone .kinds button:text-is("${kind}")`);
    return world.page.textContent("#halftone pre");
  };
  for (const chosen of [false, true]) {
    if (chosen) {
      await world.page.setInputFiles("#halftone .file", picture);
      await settled(world.page, "halftone");
      await run("cp", [picture, folder]);
    }
    await run("bash", ["-c", await snippet("curl")], { cwd: folder });
    const byCurl = await readFile(path.join(folder, "dots.png"));
    await run("/usr/bin/python3", ["-c", await snippet("Python")], { cwd: folder });
    assert.deepEqual(await readFile(path.join(folder, "dots.png")), byCurl);
    for (const [kind, ...program] of [["ccdt", "bash"], ...(await hasPackage() ? [["import ccdt", "/usr/bin/python3"]] : [])]) {
      await run(program[0], ["-c", await snippet(kind)], { cwd: folder, env: local });
      assert.deepEqual(await readFile(path.join(folder, "dots.png")), byCurl, kind);
    }
    const printed = `image/png ${byCurl.length}\n`;
    assert.equal(await run(process.execPath, ["--input-type=module", "--eval", await snippet("Node")], { cwd: folder }), printed);
    assert.equal(await runInBrowser(world, await snippet("Browser"), chosen && picture), printed);
  }
  await rm(folder, { recursive: true });
});
