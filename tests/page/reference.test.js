// SPDX-License-Identifier: GPL-3.0-or-later
// The API's reference shows the contents of /openapi.json.

import assert from "node:assert/strict";
import path from "node:path";
import { test } from "node:test";

import { appearances, isAccessible, settled, useBrowser } from "./harness.js";

const world = useBrowser();
const documented = useBrowser({ flags: [`--docs=${path.join(import.meta.dirname, "../../server/page/site")}`] });

async function open(page) {
  await page.goto(`${world.url}/assets/reference.html`);
  await page.waitForSelector("main[data-state=done]");
}

test("has all routes, options, defaults and statuses", async () => {
  const { page } = world;
  await open(page);
  const { paths, components } = await (await fetch(`${world.url}/openapi.json`)).json();
  const titles = Object.entries(paths).flatMap(([path, { parameters, ...operations }]) =>
    Object.keys(operations).map((method) => `${method.toUpperCase()} ${path}`));
  assert.deepEqual(await page.locator("h2").allTextContents(), titles);

  const rows = (label) => page.getByRole("region", { name: label, exact: true }).locator("tbody tr")
    .evaluateAll((lines) => lines.map(({ cells }) => [...cells].map(({ textContent }) => textContent)));
  const options = await rows("Members for POST /halftone");
  assert.deepEqual(options.map(([name]) => name), [...Object.keys(components.schemas.HalftoneOptions.properties), "image"]);
  const described = Object.fromEntries(options.map(([name, ...cells]) => [name, cells.slice(0, 2)]));
  assert.deepEqual(described.scale, ["number 0.1 to 16", ""]);
  assert.deepEqual(described.dot, ["number above 0, up to 65536 or auto or string ^[0-9.eE+-]+mm$", "auto"]);
  assert.deepEqual(described.quality, ["draft, standard, best", "standard"]);
  assert.deepEqual(described.image, ["string", "required"]);
  const devices = await rows("Members for POST /halftone: DeviceRequest");
  assert.deepEqual(devices.map(([name]) => name), [...Object.keys(components.schemas.DeviceOptions.properties), "image"]);
  const statuses = await rows("Answers of POST /sample");
  assert.deepEqual(statuses.map(([status]) => status), Object.keys(paths["/sample"].post.responses));
  assert.equal(await page.textContent(".error"), "");
  assert.ok(!(await page.textContent("main")).includes("`"));
  assert.equal(await page.locator("p code").first().textContent(), "image");
});

test("is linked from the page, and shows examples", async () => {
  const { page } = world;
  await page.goto(world.url);
  await page.click("footer a");
  await page.waitForSelector("main[data-state=done]");
  await page.click("summary >> nth=0");
  assert.match(await page.textContent("details[open] pre"), /^curl .*\/halftone -d '\{/);
});

test("stands beside a link to the documentation if the server offers it", async () => {
  const link = (page) => page.locator("footer").getByRole("link", { name: "Documentation" });
  await world.page.goto(world.url);
  await settled(world.page, "halftone");
  assert.equal(await link(world.page).count(), 0);
  await documented.page.goto(documented.url);
  await settled(documented.page, "halftone");
  await link(documented.page).click();
  await documented.page.waitForURL(`${documented.url}/docs/`);
  assert.match(await documented.page.title(), /^ccdt/);
});

for (const { colorScheme, size, viewport, tags } of appearances) {
  test(`is accessible and fits: ${colorScheme}, ${size}`, async () => {
    const context = await world.newContext({ colorScheme, viewport, bypassCSP: true });
    const page = await context.newPage();
    await open(page);
    await isAccessible(page, { tags });
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= viewport.width);
    const widths = await page.locator(".lead, td:nth-child(4):not(:empty)").evaluateAll((all) => all.map((one) => one.getBoundingClientRect().width));
    assert.ok(Math.min(...widths) > Math.min(viewport.width - 60, 300), String(widths));
    await context.close();
  });
}
