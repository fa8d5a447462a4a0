// SPDX-License-Identifier: GPL-3.0-or-later
// With API keys, everybody can open the page. The page asks for a key if the server requires one.

import assert from "node:assert/strict";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";

import { run, settled, useBrowser } from "./harness.js";

const key = "page-0123456789abcdef";
const folder = mkdtempSync(path.join(tmpdir(), "ccdt-page-"));
const file = path.join(folder, "keys");
writeFileSync(file, `page:${key}\n`);
const world = useBrowser({ flags: [`--api-key-file=${file}`] });

test("asks for a key, and again after a wrong one", async () => {
  const { page } = world;
  await page.goto(world.url);
  await page.waitForSelector("#access:not([hidden])");
  assert.match(await page.textContent("#key-error"), /API key is required/);
  await page.fill("#key", "x".repeat(20));
  await page.click("#access button");
  await page.waitForSelector("#key-error:text('unknown')");
  await page.fill("#key", key);
  await page.click("#access button");
  await settled(page, "halftone");
  assert.ok(await page.isHidden("#access"));
  await page.reload();
  await settled(page, "halftone");

  const curl = await page.textContent("#halftone pre");
  assert.ok(!curl.includes(key));
  await run("bash", ["-c", curl], { cwd: folder, env: { ...process.env, CCDT_KEY: key } });
  assert.match(await run("file", ["dots.png"], { cwd: folder }), /PNG image data/);
});

test("shows results in all panels once it has a key", async () => {
  const { page } = world;
  await page.goto(world.url);
  await page.waitForSelector("#access:not([hidden])");
  await page.fill("#key", key);
  await page.click("#access button");
  for (const panel of ["halftone", "devices", "sample"]) {
    await page.click(`#tab-${panel}`);
    await settled(page, panel);
  }
});
