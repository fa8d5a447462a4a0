// SPDX-License-Identifier: GPL-3.0-or-later
// After a request is rejected, the page shows nothing that disagrees with its fields and its picture.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { test } from "node:test";

import { data, settled, useBrowser } from "./harness.js";

const world = useBrowser();

/** Returns the number of pixels of a panel's canvas that are about as dark as dots. */
const dark = (panel) => world.page.locator(`#${panel} canvas:not(.of-surfaces)`).evaluate((canvas) => {
  const { data: values } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let number = 0;
  for (let i = 0; i < values.length; i += 4) number += values[i + 3] > 128 && values[i] + values[i + 1] + values[i + 2] < 150;
  return number;
});

const visibleError = (panel) => world.page.locator(`#${panel} .general`).boundingBox();

test("a refused shape shows no points of the previous one", async () => {
  const { page } = world;
  await page.goto(`${world.url}/#sample?shape=polygon`);
  await settled(page, "sample");
  await page.setInputFiles("#sample .file", path.join(data, "polygons/Italy-110m.geojson"));
  await settled(page, "sample");
  assert.ok((await dark("sample")) > 1000);
  const flat = { type: "Polygon", coordinates: [[[0, 0], [1, 1], [2, 2], [0, 0]]] };
  await page.setInputFiles("#sample .file", { name: "flat.json", mimeType: "application/json", buffer: Buffer.from(JSON.stringify(flat)) });
  await settled(page, "sample", "failed");
  assert.equal(await dark("sample"), 0);
  assert.ok(await page.isHidden("#sample .trace"));
  assert.equal(await page.textContent("#sample .status"), "");
  const { y, height } = await visibleError("sample");
  assert.ok(y >= 0 && y + height <= page.viewportSize().height);
});

test("a file that is not a picture leaves the shown picture", async () => {
  const { page } = world;
  await page.goto(world.url);
  await settled(page, "halftone");
  const before = await dark("halftone");
  const bytes = await readFile(path.join(data, "images/camera.png"));
  const broken = Buffer.concat([bytes.subarray(0, 60), Buffer.from("no pixels"), bytes.subarray(69)]);
  await page.setInputFiles("#halftone .file", { name: "broken.png", mimeType: "image/png", buffer: broken });
  await settled(page, "halftone", "failed");
  assert.equal(await dark("halftone"), before);
  assert.match(await page.textContent("#halftone .general"), /^This file is not a supported image: /);
  assert.equal(await page.getAttribute("#halftone [data-sample='astronaut.jpg']", "aria-pressed"), "true");
  await page.click("#halftone [data-sample='cat.jpg']");
  await settled(page, "halftone");
  assert.equal(await page.textContent("#halftone .general"), "");
});
