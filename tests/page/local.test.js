// SPDX-License-Identifier: GPL-3.0-or-later
// <ccdt-halftone> of the npm package, which computes in the browser: in Chromium and in Firefox.

import assert from "node:assert/strict";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import path from "node:path";
import { after, before, test } from "node:test";

import { closeAtLimit, data, elementPage, patience, run, serveOrigin, useBrowser } from "./harness.js";

const require = createRequire(path.join(process.env.CCDT_NODE_MODULES, "of-the-tests"));
const puppeteer = require("puppeteer-core");

const root = path.resolve(import.meta.dirname, "../..");
const world = useBrowser();
const hasFirefox = process.env.CCDT_FIREFOX?.startsWith("/");

const page = `<!DOCTYPE html><html lang="en"><title>Dots</title><link rel="icon" href="data:,">
<script type="module" src="/package/element.js"></script><body></body></html>`;

let folder, origin, firefox, tab;

before(async () => {
  folder = await mkdtemp(path.join(tmpdir(), "ccdt-local-"));
  const tarball = (await run(path.join(root, "server/page/package/pack"), [folder])).trim();
  await run("tar", ["--extract", "--gzip", `--file=${path.join(folder, tarball)}`, `--directory=${folder}`]);
  origin = await serveOrigin((address) => {
    if (address === "/served") return elementPage(world.url);
    return address.startsWith("/package/") ? readFile(path.join(folder, address)) : page;
  });
  if (!hasFirefox) return;
  firefox = await puppeteer.launch({ browser: "firefox", executablePath: process.env.CCDT_FIREFOX, timeout: patience });
  closeAtLimit(() => firefox.process().kill("SIGKILL"));
});

after(async () => {
  await firefox?.close();
  origin.close();
  await rm(folder, { recursive: true });
});

/** Defines a test for each browser. It gets a new tab, in which `show` adds an element to the page. */
function testInBrowsers(name, run) {
  for (const browser of ["Chromium", "Firefox"]) {
    test(`${name} (${browser})`, { skip: browser === "Firefox" && !hasFirefox }, async () => {
      tab = browser === "Firefox" ? await firefox.newPage() : world.page;
      await tab.goto(origin.url);
      await prepare();
      await run();
      if (browser === "Firefox") await tab.close();
    });
  }
}

/** Adds to the page: `show(attributes)`, `change(attributes)`, `next(type)`, which wait for an event, and `svg()`. */
const prepare = () => tab.evaluate(() => {
  const set = (given) => { for (const [name, value] of Object.entries(given)) dots.setAttribute(name, value); };
  window.next = (...types) => new Promise((resolve) => {
    for (const type of types) dots.addEventListener(type, ({ message }) => resolve(message ?? type), { once: true });
  });
  window.change = (given) => {
    const ended = next("load", "error");
    set(given);
    return ended;
  };
  window.show = (given) => {
    window.dots = document.createElement("ccdt-halftone");
    set(given);
    const ended = next("load", "error");
    document.body.append(dots);
    return ended;
  };
  window.svg = async () => (await fetch(dots.shadowRoot.children[0].src)).text();
});

/** Returns the answer of the server. */
async function expected(query) {
  const body = await readFile(path.join(data, "images/chelsea.png"));
  return (await fetch(`${world.url}/halftone?${query}&format=svg`, { method: "POST", body })).text();
}

testInBrowsers("draws without a server what a server would draw", async () => {
  const [event, drawn, hidden] = await tab.evaluate(async () => {
    const ended = await show({ src: "/cat.png", sites: "900", color: "cmyk", alt: "A cat" });
    return [ended, await svg(), dots.shadowRoot.children[1].hidden];
  });
  assert.deepEqual([event, hidden], ["load", true]);
  assert.ok(drawn === await expected("sites=900&color=cmyk&width=451"));
});

testInBrowsers("shows drafts while an option changes, and then the final dots", async () => {
  const { drafts, isShown } = await tab.evaluate(async (wanted) => {
    await show({ src: "/cat.png", sites: "900" });
    const seen = new Set();
    let isShown = true;
    dots.addEventListener("load", async () => seen.add(await svg()));
    new MutationObserver(() => { isShown &&= !dots.shadowRoot.children[0].hidden; })
      .observe(dots.shadowRoot, { subtree: true, attributes: true });
    for (let sites = 1000; seen.size < 3; sites += 10) {
      dots.setAttribute("sites", sites);
      await new Promise((resume) => setTimeout(resume, 20));
    }
    const drafts = seen.size;
    dots.setAttribute("sites", "700");
    do await next("load"); while (await svg() !== wanted);
    return { drafts, isShown };
  }, await expected("sites=700&width=451"));
  assert.ok(drafts >= 3, String(drafts));
  assert.ok(isShown, "the dots were hidden");
});

testInBrowsers("shows errors, and recovers", async () => {
  const [error, message, event, isHidden] = await tab.evaluate(async () => {
    await show({ src: "/cat.png", sites: "300" });
    const text = dots.shadowRoot.querySelector("p");
    const error = await change({ sites: "0" });
    const message = !text.hidden && text.textContent;
    return [error, message, await change({ sites: "400" }), text.hidden];
  });
  assert.match(error, /^sites must be/);
  assert.deepEqual([message, event, isHidden], [error, "load", true]);
});

testInBrowsers("replaces a worker that has failed", async () => {
  const [error, event] = await tab.evaluate(async () => {
    const workers = [];
    window.Worker = class extends Worker {
      constructor(...given) {
        super(...given);
        workers.push(this);
      }
      postMessage(task) {
        super.postMessage(task);
        if (workers.length === 1) this.dispatchEvent(new ErrorEvent("error", { message: "out of memory" }));
      }
    };
    return [await show({ src: "/cat.png", sites: "300" }), await change({ sites: "400" })];
  });
  assert.match(error, /out of memory/);
  assert.equal(event, "load");
});

testInBrowsers("follows a video, and draws the picture of a canvas", async () => {
  const [ended, frames, isChanged] = await tab.evaluate(async () => {
    const canvas = Object.assign(document.createElement("canvas"), { id: "drawing", width: 320, height: 240 });
    const context = canvas.getContext("2d");
    let turn = 0;
    const timer = setInterval(() => {
      context.fillStyle = "#fff";
      context.fillRect(0, 0, 320, 240);
      context.fillStyle = "#333";
      context.fillRect(turn = (turn + 7) % 200, 60, 120, 120);
    }, 30);
    const video = Object.assign(document.createElement("video"), { id: "camera", muted: true, srcObject: canvas.captureStream(30) });
    document.body.append(canvas, video);
    await video.play();
    const ended = await show({ src: "#camera", sites: "3000", dots: "ink" });
    const seen = new Set();
    for (let frame = 0; frame < 8; ++frame) {
      await next("load");
      seen.add(await svg());
    }
    clearInterval(timer);
    video.pause();
    await change({ src: "#drawing" });
    const before = await svg();
    context.fillRect(0, 0, 320, 240);
    const after = next("load");
    dots.refresh();
    await after;
    return [ended, seen.size, before !== await svg()];
  });
  assert.deepEqual([ended, isChanged], ["load", true]);
  assert.ok(frames > 2, String(frames));
});

testInBrowsers("computes by the engine that the page names, in an element from a server", async () => {
  await tab.goto(`${origin.url}/served`);
  await prepare();
  const requests = [];
  tab.on("request", (request) => requests.push(request.url()));
  const [event, drawn] = await tab.evaluate(async () => [await show({ src: "/cat.png", sites: "600", engine: "/package/engine.js" }), await svg()]);
  assert.equal(event, "load");
  assert.ok(drawn === await expected("sites=600&width=451"));
  assert.deepEqual(requests.filter((url) => url.includes("halftone?")), []);
});
