// SPDX-License-Identifier: GPL-3.0-or-later
// The address of the page holds the settings, survives a reload, and follows the history of the browser.

import assert from "node:assert/strict";
import path from "node:path";
import { test } from "node:test";

import { data, settled, useBrowser } from "./harness.js";

const world = useBrowser();
const hash = () => world.page.evaluate(() => location.hash);
const snippet = (panel) => world.page.textContent(`#${panel} pre`);
const settings = async () => Object.fromEntries(new URLSearchParams((await hash()).split("?")[1]));

async function open(address = "") {
  await world.page.goto(`${world.url}/${address}`);
  await settled(world.page, address.match(/#(\w+)/)?.[1] ?? "halftone");
}

async function type(panel, name, value) {
  const input = world.page.locator(`#${panel} .fields [data-name=${name}] input[type=number]`);
  await input.fill(value);
  await input.blur();
  await settled(world.page, panel);
}

/** Checks that a new page with the same address shows the same request. */
async function isShared(panel) {
  const [address, request] = [await hash(), await snippet(panel)];
  const page = await world.page.context().newPage();
  await page.goto(world.url + "/" + address);
  await settled(page, panel);
  assert.equal(await page.textContent(`#${panel} pre`), request);
  assert.equal(await page.evaluate(() => location.hash), address);
  await page.close();
}

test("leaves out settings that have their defaults", async () => {
  await open();
  assert.equal(await hash(), "#halftone");
  await type("halftone", "sites", "700");
  assert.equal(await hash(), "#halftone?sites=700");
  await type("halftone", "sites", "20000");
  assert.equal(await hash(), "#halftone");
});

test("does not scroll the head out of view if the address names a panel", async () => {
  await open("#halftone");
  assert.ok(await world.page.evaluate(() => document.documentElement.scrollHeight > innerHeight));
  assert.equal(await world.page.evaluate(() => scrollY), 0);
});

test("follows a link that is clicked while the first picture is loaded", async () => {
  const { page } = world;
  let release;
  const held = new Promise((resolve) => { release = resolve; });
  const asked = page.waitForRequest((request) => request.url().endsWith("astronaut.jpg") && request.resourceType() === "fetch");
  await page.route("**/astronaut.jpg", async (route) => {
    if (route.request().resourceType() === "fetch") await held;
    await route.continue();
  });
  await page.goto(world.url);
  await asked;
  await page.evaluate(() => { location.hash = "#halftone?sites=700"; });
  release();
  await page.waitForFunction(() => /^700 dots/.test(document.querySelector("#halftone .status").textContent));
  assert.equal(await hash(), "#halftone?sites=700");
});

test("shares the settings of every kind of field of a halftone", async () => {
  await open();
  const { page } = world;
  await page.click("#halftone [data-sample='cat.jpg']");
  await page.uncheck("#halftone .fields [data-name=dot] input[type=checkbox]");
  await page.getByLabel("Radius, unit").selectOption("mm");
  await type("halftone", "dot", "2");
  await page.uncheck("#halftone [data-name=antialias] input");
  await page.selectOption("#halftone [data-name=color] select", "palette");
  await page.click("#halftone [data-name=palette] button:text-is('Add')");
  await page.check("#halftone [data-name=background] input[type=checkbox]");
  await page.click("#halftone .more summary");
  await page.locator("#halftone").getByLabel("black point").fill("0.1");
  await page.locator("#halftone .more [data-name=iterations] input[type=number]").fill("3");
  await page.locator("#halftone .more [data-name=iterations] input[type=number]").blur();
  await settled(page, "halftone");
  const { picture, dot, levels, antialias, palette, background, iterations } = await settings();
  assert.deepEqual({ picture, dot, levels, antialias, background, iterations }, {
    picture: "cat.jpg", dot: "2mm", levels: "0.1,1,1", antialias: "false", background: "transparent", iterations: "3",
  });
  assert.equal(palette.split(",").length, 5);
  await isShared("halftone");
  await page.reload();
  await settled(page, "halftone");
  assert.equal((await settings()).picture, "cat.jpg");
});

test("shares a radius in pixels with the width at which it was shown", async () => {
  await open("#halftone?sites=500&dots=ink");
  await world.page.uncheck("#halftone .fields [data-name=dot] input[type=checkbox]");
  await type("halftone", "dot", "2.5");
  assert.deepEqual(await settings(), { sites: "500", dots: "ink", dot: "2.5", width: "1000" });
  await isShared("halftone");
});

test("shares the settings of a device", async () => {
  for (const address of [
    "#devices?picture=camera.jpg&device=acep7&width=200&height=auto&rotate=90&seen=false",
    "#devices?device=custom&palette=%23000000%2C%23ffffff%2C%23aa2200&width=90&height=60&fit=contain&background=%23aa2200&levels=0.1%2C1%2C1",
    "#devices?width=64&height=64&format=raw&bit_order=lsb&invert_bits=true",
  ]) {
    await open(address);
    assert.equal(await hash(), address);
    await isShared("devices");
    await world.page.goto("about:blank");
  }
});

test("shares a shape: drawn, with sides, or a map", async () => {
  const { page } = world;
  for (const address of [
    "#sample?shape=polygon&corners=" + encodeURIComponent('{"polygon":[[0,0],[2,0],[2,1],[0,1]]}') + "&sites=300&seed=4&iteration=3",
    "#sample?shape=torus&torus=2,1&method=odt&tiles=on",
    "#sample?shape=torus&sites=400&quality=stealthy",
    "#sample?shape=mask&tile=32,16&format=mask16&seed=3",
    "#sample?shape=polygon&sites=400&order=progressive&first=120",
    "#sample?shape=rectangle&sites=50&mesh=on&avoid=" + encodeURIComponent("[[[0.2,0.2],[0.6,0.2],[0.4,0.6]]]"),
    "#sample?shape=texas.geojson&counted=unemployed&per=5000",
  ]) {
    await open(address);
    const [expected, restored] = [address, await hash()].map((text) => Object.fromEntries(new URLSearchParams(text.split("?")[1])));
    assert.deepEqual(restored, expected);
    await isShared("sample");
    await page.goto("about:blank");
  }
});

test("ignores texts that are not valid settings", async () => {
  await open("#halftone?sites=many&tone=loud&picture=../key&palette=red&color=palette&dot=3furlongs&nothing=7");
  assert.deepEqual(await settings(), { color: "palette" });
  await open("#sample?corners=%7B&shape=own&iteration=x&sites=");
  assert.equal((await settings()).sites, undefined);
  assert.match(await world.page.textContent("#sample .status"), /^1,000 points/);
});

test("goes back and forward through panels, pictures and shapes, but not through numbers", async () => {
  await open();
  const { page } = world;
  await type("halftone", "sites", "900");
  await type("halftone", "sites", "800");
  await page.setInputFiles("#halftone .file", path.join(data, "images/camera.png"));
  await settled(page, "halftone");
  await page.click("#tab-sample");
  await settled(page, "sample");
  await page.selectOption("#shape", "torus");
  await settled(page, "sample");
  assert.equal(await hash(), "#sample?shape=torus");

  await page.goBack();
  await settled(page, "sample");
  assert.equal(await page.inputValue("#shape"), "file");
  assert.equal(await hash(), "#sample");
  await page.goBack();
  await settled(page, "halftone");
  assert.deepEqual(await settings(), { picture: "own", sites: "800" });
  assert.match(await snippet("halftone"), /camera\.png/);
  await page.goBack();
  await settled(page, "halftone");
  assert.deepEqual(await settings(), { sites: "800" });
  assert.match(await snippet("halftone"), /astronaut\.jpg/);
  await page.goForward();
  await settled(page, "halftone");
  assert.match(await snippet("halftone"), /camera\.png/);
  await page.reload();
  await settled(page, "halftone");
  assert.deepEqual(await settings(), { picture: "own", sites: "800" });
  assert.match(await snippet("halftone"), /camera\.png/);
  await page.evaluate(() => new Promise((done) => { indexedDB.deleteDatabase("ccdt").onblocked = done; }));
  await page.reload();
  await settled(page, "halftone");
  assert.deepEqual(await settings(), { sites: "800" });
  assert.match(await page.textContent("#halftone .warnings"), /not stored in this browser/);
});

test("keeps the shape of the user when the page is loaded again", async () => {
  await open("#sample?shape=own");
  const { page } = world;
  await settled(page, "sample");
  assert.match(await page.textContent("#sample .warnings"), /not stored in this browser/);
  await page.setInputFiles("#sample .file", path.join(data, "polygons/Italy-110m.geojson"));
  await settled(page, "sample");
  assert.equal(await page.textContent("#sample .warnings"), "");
  await type("sample", "sites", "900");
  await page.reload();
  await settled(page, "sample");
  assert.deepEqual(await settings(), { shape: "own", sites: "900" });
  assert.match(await snippet("sample"), /Italy-110m\.geojson/);
  assert.match(await page.textContent("#sample .status"), /^900 points/);
});

test("allows going back before what is shown is ready", async () => {
  await open("#halftone?sites=300");
  const { page } = world;
  for (const name of ["cat.jpg", "camera.jpg", "astronaut.jpg"]) {
    await page.click(`#halftone [data-sample='${name}']`);
    await settled(page, "halftone");
  }
  await page.evaluate(() => { history.back(); history.back(); });
  await page.waitForFunction(() => document.querySelector("#halftone pre").textContent.includes("cat.jpg"));
  await settled(page, "halftone");
  assert.equal(await page.getAttribute("#halftone [data-sample='cat.jpg']", "aria-pressed"), "true");
  assert.equal(await hash(), "#halftone?picture=cat.jpg&sites=300");
});

test("shows the map without a shape in the address, and the polygon with other settings", async () => {
  for (const [address, shape] of [["#sample", "file"], ["#sample?sites=300", "polygon"], ["#analyze", "polygon"]]) {
    await open(address);
    assert.equal(await world.page.inputValue("#shape"), shape);
    await world.page.goto("about:blank");
  }
});

test("shares an analysis with the points that were analyzed", async () => {
  await open("#analyze?shape=torus&sites=400");
  assert.match(await world.page.textContent("#analyze tbody tr td"), /^400$/);
  await world.page.click("#tab-sample");
  await settled(world.page, "sample");
  assert.equal(await hash(), "#sample?shape=torus&sites=400");
});
