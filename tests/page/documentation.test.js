// SPDX-License-Identifier: GPL-3.0-or-later
// The pages of the documentation in Chromium. CCDT_SITE is their folder.

import assert from "node:assert/strict";
import path from "node:path";
import { test } from "node:test";
import { pathToFileURL } from "node:url";

import { appearances, isAccessible, useBrowser } from "./harness.js";

const site = process.env.CCDT_SITE;
const names = ["index.html", "gallery.html", "reference.html", "classccdt_1_1server_1_1FileFolder.html",
  "file__folder_8h_source.html"];
const phone = { width: 375, height: 800 };

const world = useBrowser({ flags: [`--docs=${site}`] });

/** Loads all pictures of a page, and returns the addresses of those that the browser cannot show. */
const brokenPictures = (page) => page.evaluate(async () => {
  const broken = [];
  for (const image of document.images) {
    image.loading = "eager";
    await image.decode().catch(() => broken.push(image.src));
  }
  return broken;
});

test("shows all pictures, and violates no policy", async () => {
  const { page } = world;
  await page.goto(`${world.url}/docs/`);
  await page.getByRole("navigation").getByRole("link", { name: "Gallery" }).click();
  await page.waitForURL("**/gallery.html");
  assert.ok(await page.locator("figure img").count() > 25);
  assert.deepEqual(await brokenPictures(page), []);
});

test("works from files", async () => {
  const { page } = world;
  await page.goto(pathToFileURL(path.join(site, "index.html")).href);
  await page.getByRole("navigation").getByRole("link", { name: "Reference" }).click();
  await page.getByRole("link", { name: "FileFolder", exact: true }).click();
  assert.match(await page.textContent("h1"), /FileFolder/);
  assert.equal(await page.locator("header nav").evaluate((nav) => getComputedStyle(nav).display), "flex");
  assert.deepEqual(await brokenPictures(page), []);
});

for (const { colorScheme, size, viewport, tags } of appearances) {
  test(`is accessible and fits: ${colorScheme}, ${size}`, async () => {
    const narrow = viewport.width < phone.width + 100;
    const context = await world.newContext({ colorScheme, viewport: narrow ? phone : viewport, bypassCSP: true });
    const page = await context.newPage();
    for (const name of names) {
      await page.goto(`${world.url}/docs/${name}`);
      await isAccessible(page, { tags, about: name });
      const width = await page.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(width <= page.viewportSize().width, `${name} is ${width} pixels wide`);
    }
    await context.close();
  });
}
