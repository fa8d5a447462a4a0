// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures keep their lightness in the page, in <ccdt-halftone>, and in the default answers of the server. The
// lightness is measured from screenshots, in each browser, with one and two device pixels per CSS pixel.

import assert from "node:assert/strict";
import { once } from "node:events";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import path from "node:path";
import { after, before, describe, test } from "node:test";

import { closeAtLimit, data, elementPage, patience, quiet, serveOrigin, startServer } from "./harness.js";

const require = createRequire(path.join(process.env.CCDT_NODE_MODULES, "of-the-tests"));
const puppeteer = require("puppeteer-core");

const pictures = ["camera.png", "chelsea.png"];  // pictures that were not used to tune the sizes of dots
const most = 1;  // maximum mean difference of L*
const screen = { width: 1280, height: 800 };

let running, origin;
before(async () => {
  running = await startServer([]);
  origin = await serveOrigin(() => elementPage(running.url));
});
after(async () => {
  origin.close();
  running.server.kill();
  await once(running.server, "exit");
});

/** Runs in a page. Returns the mean difference in L* of two pictures, over a grid of squares. */
async function differenceIn([shot, picture]) {
  const across = 24;
  const lightnessOf = async (base64) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
    const { width, height } = bitmap;
    const canvas = Object.assign(document.createElement("canvas"), { width, height });
    const context = canvas.getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data: values } = context.getImageData(0, 0, width, height);
    const linear = Float64Array.from({ length: 256 }, (_, i) => (i <= 10 ? i / 3294.6 : ((i / 255 + 0.055) / 1.055) ** 2.4));
    const sums = new Float64Array(across ** 2);
    const counts = new Float64Array(across ** 2);
    for (let y = 0; y < height; ++y) {
      for (let x = 0; x < width; ++x) {
        const at = 4 * (y * width + x);
        const square = Math.floor((y * across) / height) * across + Math.floor((x * across) / width);
        sums[square] += 0.2126 * linear[values[at]] + 0.7152 * linear[values[at + 1]] + 0.0722 * linear[values[at + 2]];
        ++counts[square];
      }
    }
    return sums.map((sum, i) => {
      const light = sum / counts[i];
      return light > 0.008856 ? 116 * Math.cbrt(light) - 16 : 903.3 * light;
    });
  };
  const [seen, wanted] = [await lightnessOf(shot), await lightnessOf(picture)];
  return seen.reduce((sum, lightness, i) => sum + lightness - wanted[i], 0) / seen.length;
}

/** Ways to show a picture. Each returns the part of the page to examine, in CSS pixels. */
const places = {
  async "the page"(page, name) {
    await page.goto(`${running.url}/#halftone`);
    await page.waitForSelector("#halftone[data-state=done]");
    const input = await page.$("#halftone .file");
    await input.uploadFile(path.join(data, "images", name));
    await page.waitForFunction((file) => {
      const text = document.querySelector("#halftone pre").textContent;
      return text.includes(file) && document.querySelector("#halftone").dataset.state === "done";
    }, {}, name);
    return page.evaluate(async () => {
      scrollTo(0, 0);
      const divider = document.querySelector("#halftone .divider");
      divider.value = 0;
      divider.dispatchEvent(new Event("input"));
      divider.style.visibility = "hidden";
      const picture = document.querySelector("#halftone .pictures .thumb canvas").parentElement;
      if (picture.getAttribute("aria-pressed") !== "true") throw new Error("another picture is shown");
      await new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)));
      const canvas = document.querySelector("#halftone canvas");
      const { data: values } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      const isDrawn = (column, row) => values[4 * (row * canvas.width + column) + 3] === 255;
      const [columns, rows] = [[], []];
      for (let i = 0; i < canvas.width; ++i) if (isDrawn(i, canvas.height >> 1)) columns.push(i);
      for (let i = 0; i < canvas.height; ++i) if (isDrawn(canvas.width >> 1, i)) rows.push(i);
      const box = canvas.getBoundingClientRect();
      return { x: box.x + columns[0] / devicePixelRatio, y: box.y + rows[0] / devicePixelRatio,
        width: columns.length / devicePixelRatio, height: rows.length / devicePixelRatio };
    });
  },
  async "the element"(page, name) {
    await page.goto(origin.url);
    return page.evaluate((source) => new Promise((resolve, reject) => {
      const element = document.createElement("ccdt-halftone");
      element.setAttribute("src", source);
      element.addEventListener("load", () => {
        const { x, y, width, height } = element.getBoundingClientRect();
        resolve({ x, y, width, height });
      });
      element.addEventListener("error", ({ message }) => reject(new Error(message)));
      document.body.replaceChildren(element);
    }), `/${name}`);
  },
  "the default answer": (page, name) => showAnswer(page, name, ""),
  "the default answer, fitted into the window": (page, name) => showAnswer(page, name, "max-width: 100vw; max-height: 100vh"),
};

/** Shows the server's answer to a request without options. */
async function showAnswer(page, name, style) {
  const body = await readFile(path.join(data, "images", name));
  const answer = await fetch(`${running.url}/halftone`, { method: "POST", body });
  const bytes = Buffer.from(await answer.arrayBuffer()).toString("base64");
  await page.goto("about:blank");
  return page.evaluate(async ([source, css]) => {
    document.body.style.margin = 0;
    const picture = Object.assign(new Image(), { src: source });
    picture.style.cssText = `display: block; ${css}`;
    document.body.replaceChildren(picture);
    await picture.decode();
    await new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)));
    const { width, height } = picture.getBoundingClientRect();
    return { x: 0, y: 0, width, height };
  }, [`data:image/png;base64,${bytes}`, style]);
}

const browsers = [["Chromium", "chrome", process.env.CCDT_CHROMIUM, quiet], ["Firefox", "firefox", process.env.CCDT_FIREFOX, []]];
for (const [title, kind, executablePath, args] of browsers) {
  describe(title, { skip: !executablePath }, () => {
    let browser;
    before(async () => {
      browser = await puppeteer.launch({ browser: kind, executablePath, args, timeout: patience });
      closeAtLimit(() => browser.process().kill("SIGKILL"));
    });
    after(() => browser.close());

    for (const ratio of [1, 2]) {
      for (const [index, [place, show]] of Object.entries(places).entries()) {
        // Half of the combinations contain all combinations of any three of browser, ratio, place and picture.
        const name = pictures[((kind === "chrome") + ratio + index) % 2];
        test(`${place}, ${ratio} to one, ${name}`, async () => {
          const page = await browser.newPage();
          page.setDefaultTimeout(patience);
          await page.setViewport({ ...(place === "the default answer" ? { width: 1300, height: 1300 } : screen), deviceScaleFactor: ratio });
          const box = Object.entries(await show(page, name)).map(([side, length]) => [side, Math.round(length * ratio) / ratio]);
          const shot = await page.screenshot({ clip: Object.fromEntries(box), encoding: "base64", captureBeyondViewport: false });
          const picture = (await readFile(path.join(data, "images", name))).toString("base64");
          await page.goto("about:blank");
          const difference = await page.evaluate(differenceIn, [shot, picture]);
          console.log(`${title}, ${place}, ${ratio} to one, ${name}: ${difference.toFixed(2)}`);
          assert.ok(Math.abs(difference) <= most, `L* differs by ${difference.toFixed(2)}`);
          await page.close();
        });
      }
    }
  });
}
