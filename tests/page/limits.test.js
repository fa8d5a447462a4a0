// SPDX-License-Identifier: GPL-3.0-or-later
// A server with small limits accepts everything that its page offers.

import assert from "node:assert/strict";
import { test } from "node:test";

import { settled, useBrowser } from "./harness.js";

const world = useBrowser({ flags: ["--max-sites=700"] });

test("begins with as many points as the server accepts, and does not exceed them", async () => {
  const { page } = world;
  await page.goto(`${world.url}/#sample`);
  await settled(page, "sample");
  assert.match(await page.textContent("#sample .status"), /^[1-6]\d\d points/);
  await page.click("#sample .knot");
  await settled(page, "sample");
  assert.match(await page.textContent("#sample .status"), /^700 points/);
  for (const panel of ["halftone", "sample"]) {
    await page.goto("about:blank");
    await page.goto(`${world.url}/#${panel}?${panel === "sample" ? "shape=polygon" : ""}`);
    await settled(page, panel);
    assert.match(await page.textContent(`#${panel} .status`), /^700 /);
    const most = await page.getAttribute(`#${panel} .fields [data-name=sites] input[type=range]`, "max");
    assert.equal(Math.round(Math.exp(Number(most))), 700);
  }
});
