// SPDX-License-Identifier: GPL-3.0-or-later
// Pages in the READMEs, opened unchanged from another origin than the server.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { after, before, test } from "node:test";

import { data, serveOrigin, useBrowser } from "./harness.js";

const world = useBrowser();

let origin, lines;

/** Returns the pages in a README. */
async function examplesOf(readme) {
  const text = await readFile(path.join(data, "../..", readme), "utf8");
  return [...text.matchAll(/^```html\n(.*?)^```$/gms)].map(([, example]) => example);
}

before(async () => {
  origin = await serveOrigin(() => lines.replace("http://localhost:8080", world.url));
});

after(() => origin.close());

test("the lines in the READMEs put dots into a page of another origin", async () => {
  for (const [name, wide] of [["README.md", 451], ["server/page/README.md", 600]]) {
    lines = (await examplesOf(name)).find((example) => example.includes("<ccdt-halftone"));
    await world.page.goto(origin.url);
    await world.page.waitForFunction(() => {
      const [picture, drawing] = document.querySelector("ccdt-halftone").shadowRoot?.children ?? [];
      return drawing?.hidden && picture.naturalWidth > 0;
    });
    const [alt, width] = await world.page.evaluate(() => {
      const element = document.querySelector("ccdt-halftone");
      return [element.shadowRoot.querySelector("img").alt, element.clientWidth];
    });
    assert.deepEqual([alt, width], ["A photograph as dots", wide]);
  }
});

test("the page in the README of halftones draws rings with the tone of the picture", async () => {
  lines = (await examplesOf("api/halftone/README.md")).find((example) => example.includes("evenodd"));
  await world.page.goto(origin.url);
  const inkOf = () => world.page.evaluate(() => {
    const { width, height } = document.querySelector("canvas");
    const { data } = document.querySelector("canvas").getContext("2d").getImageData(0, 0, width, height);
    let sum = 0;
    for (let i = 3; i < data.length; i += 4) sum += data[i];
    return sum / 255 / (width * height);
  });
  await world.page.waitForFunction(() => document.querySelector("canvas").height !== 150);
  const meanLuminance = 0.2023;  // of chelsea.png
  assert.ok(Math.abs(1 - (await inkOf()) - meanLuminance) < 0.01, String(await inkOf()));
});

test("the README's page puts a dotted picture into a page of another origin", async () => {
  [lines] = await examplesOf("README.md");
  await world.page.goto(origin.url);
  for (const viewport of [{ width: 1280, height: 860 }, { width: 390, height: 844 }]) {
    await world.page.setViewportSize(viewport);
    await world.page.reload();
    await world.page.setInputFiles("input", { name: "letter.txt", mimeType: "text/plain", buffer: Buffer.from("Dear reader") });
    await world.page.waitForFunction(() => /this is text/.test(document.querySelector("output").value));
    await world.page.setInputFiles("input", path.join(data, "images/chelsea.png"));
    await world.page.waitForFunction(() => document.querySelector("img").naturalWidth > 0);
    const shown = await world.page.evaluate(() => {
      const { naturalWidth, naturalHeight, width } = document.querySelector("img");
      return { naturalWidth, naturalHeight, width, taken: document.documentElement.scrollWidth, said: document.querySelector("output").value };
    });
    const width = Math.min(viewport.width - 16, 800);
    assert.deepEqual(shown, { naturalWidth: width, naturalHeight: Math.round((300 * width) / 451), width, taken: viewport.width, said: "" });
  }
});
