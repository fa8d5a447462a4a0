// SPDX-License-Identifier: GPL-3.0-or-later
// After a request is rejected, the page shows nothing that disagrees with its fields and its picture.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { test } from "node:test";

import { data, settled, useBrowser } from "./harness.js";

const world = useBrowser();

/** Returns the number of pixels of a panel's canvas that are about as dark as dots. */
const dark = (panel) => world.page.locator(`#${panel} .stage canvas:not(.of-surfaces)`).evaluate((canvas) => {
  const { data: values } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let number = 0;
  for (let i = 0; i < values.length; i += 4) number += values[i + 3] > 128 && values[i] + values[i + 1] + values[i + 2] < 150;
  return number;
});

const visibleError = (panel) => world.page.locator(`#${panel} .general`).boundingBox();

test("a refused file leaves the shown shape, its settings and its points", async () => {
  const { page } = world;
  await page.goto(`${world.url}/#sample`);
  await settled(page, "sample");
  const seen = async () => [await page.locator("#sample canvas.of-planes").evaluate((canvas) => canvas.toDataURL()), await page.textContent("#sample pre"), await page.evaluate(() => location.hash),
    await page.isVisible("#sample .trace"), await page.textContent("#sample .legend"), await page.inputValue("#shape")];
  const flat = JSON.stringify({ type: "Polygon", coordinates: [[[0, 0], [1, 1], [2, 2], [0, 0]]] });
  const refused = [["flat.json", flat, "the polygon has no area"], ["flat.obj", "v 0 0 0\nv 1 1 1\nf 1 2 2\n", "no triangle has an area"],
    ["cut.npy", "\x93NUMPY (2, 2, 2)", "the NPY file must have the version 1, 2 or 3"]];
  for (const own of [false, true]) {
    if (own) {
      await page.setInputFiles("#sample .file", path.join(data, "polygons/Italy-110m.geojson"));
      await settled(page, "sample");
      assert.ok((await dark("sample")) > 1000);
    }
    const before = await seen();
    for (const [name, text, reason] of refused) {
      await page.setInputFiles("#sample .file", { name, mimeType: "", buffer: Buffer.from(text, "latin1") });
      await settled(page, "sample", "failed");
      assert.equal(await page.textContent("#sample .general"), `${name} cannot be used: ${reason}`);
      assert.deepEqual(await seen(), before, name);
    }
    const { y, height } = await visibleError("sample");
    assert.ok(y >= 0 && y + height <= page.viewportSize().height);
  }
  await page.reload();
  await settled(page, "sample");
  assert.match(await page.textContent("#sample pre"), /Italy-110m/);
  await page.fill("#sample [data-name=sites] input", "900");
  await page.locator("#sample [data-name=sites] input").first().blur();
  await settled(page, "sample");
  assert.equal(await page.textContent("#sample .general"), "");
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
