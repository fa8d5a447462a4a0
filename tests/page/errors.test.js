// SPDX-License-Identifier: GPL-3.0-or-later
// Errors of the server are shown beside the fields at fault.

import assert from "node:assert/strict";
import path from "node:path";
import { test } from "node:test";

import { data, settled, useBrowser } from "./harness.js";

const world = useBrowser({ flags: ["--max-sites=50000"] });

test("shows errors of options out of range", async () => {
  const { page } = world;
  await page.goto(world.url);
  await settled(page, "halftone");
  const field = page.locator("#halftone [data-name=sites]");
  const input = field.locator("input[type=number]");
  await input.fill("50001");
  await input.blur();
  await settled(page, "halftone", "failed");
  assert.match(await field.locator(".error").textContent(), /50000/);
  assert.equal(await input.getAttribute("aria-invalid"), "true");
  assert.equal(await input.getAttribute("aria-describedby"), await field.locator(".error").getAttribute("id"));
  assert.match(await page.textContent("#halftone .general"), /50000/);
  await input.fill("500");
  await input.blur();
  await settled(page, "halftone");
  assert.equal(await field.locator(".error").textContent(), "");
  assert.equal(await page.textContent("#halftone .general"), "");
});

test("shows the error of a file that is not a picture", async () => {
  const { page } = world;
  await page.goto(world.url);
  await settled(page, "halftone");
  await page.setInputFiles("#halftone .file", { name: "letter.txt", mimeType: "text/plain", buffer: Buffer.from("Dear reader") });
  await settled(page, "halftone", "failed");
  assert.equal(await page.textContent("#halftone .general"), "This file is not a supported image: this is text");
  assert.match(await page.textContent("#halftone .status"), /^20,000 dots/);
  assert.match(await page.textContent("#halftone pre"), /astronaut\.jpg/);
  assert.equal(await page.evaluate(() => location.hash), "#halftone");
});

test("shows the errors of a shape and a file without area", async () => {
  const { page } = world;
  await page.goto(`${world.url}/#sample?shape=polygon`);
  await settled(page, "sample");
  await page.click("#sample summary");
  await page.fill("#corners", '{"polygon": [[0, 0], [1, 1], [2, 2]]}');
  await page.locator("#corners").blur();
  await settled(page, "sample", "failed");
  assert.match(await page.textContent("#shape-error"), /no area/);
  await page.fill("#corners", "corners");
  await page.locator("#corners").blur();
  assert.match(await page.textContent("#shape-error"), /must be JSON/);
  await page.setInputFiles("#sample .file", { name: "empty.json", mimeType: "application/json", buffer: Buffer.from("{}") });
  await settled(page, "sample", "failed");
  assert.match(await page.textContent("#sample .general"), /^empty\.json contains no GeoJSON polygons$/);
});

test("offers to open a file in the panel that it is for", async () => {
  const { page } = world;
  for (const [panel, file, target, shown] of [["halftone", "polygons/Italy-110m.geojson", "sample", /^1,000 points/], ["devices", "meshes/spot.obj", "sample", /^1,000 points/], ["sample", "images/camera.png", "halftone", /^20,000 dots/]]) {
    await page.goto("about:blank");
    await page.goto(`${world.url}/#${panel}`);
    await settled(page, panel);
    const status = await page.textContent(`#${panel} .status`);
    await page.setInputFiles(`#${panel} .file`, path.join(data, file));
    await settled(page, panel, "failed");
    assert.match(await page.textContent(`#${panel} .general`), /^[\w.-]+ is a (shape|picture)\. Open it in (Sample|Halftone)$/);
    assert.equal(await page.textContent(`#${panel} .status`), status);
    await page.click(`#${panel} .general button`);
    await settled(page, target);
    assert.match(await page.textContent(`#${target} .status`), shown);
    assert.match(await page.textContent(`#${target} pre`), new RegExp(path.basename(file)));
    assert.match(await page.evaluate(() => location.hash), new RegExp(`^#${target}.*own`));
  }
});
