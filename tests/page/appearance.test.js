// SPDX-License-Identifier: GPL-3.0-or-later
// The page in light and dark, wide and narrow, by keyboard and for screen readers.

import assert from "node:assert/strict";
import { test } from "node:test";

import { appearances, isAccessible, looksAsKept, settled, useBrowser } from "./harness.js";

const world = useBrowser();
const panels = ["halftone", "devices", "sample", "analyze"];

/** Returns the selects that are too narrow for one of their choices. */
const cutSelects = (page) => page.evaluate(() => {
  const probe = document.body.appendChild(document.createElement("select"));
  const cut = [...document.querySelectorAll(".controls select, .bar select")].filter((select) => {
    probe.style.font = getComputedStyle(select).font;
    probe.replaceChildren(...[...(getComputedStyle(select).fieldSizing === "content" ? select.selectedOptions : select.options)].map(({ text }) => new Option(text)));
    return select.offsetParent && select.offsetWidth + 1 < probe.offsetWidth;
  });
  probe.remove();
  return cut.map(({ innerText }) => innerText);
});

/** Opens all parts that are closed at first: rare options, help texts, and the controls of the plotter. */
async function unfold(page, panel) {
  await page.evaluate((id) => {
    const place = document.getElementById(id);
    for (const details of place.querySelectorAll("details")) details.open = true;
    place.querySelector(".plotter input[type=checkbox]")?.click();
    for (const button of place.querySelectorAll(".about")) button.click();
  }, panel);
  await settled(page, panel);
}

for (const { colorScheme, size, viewport, tags } of appearances) {
  test(`is accessible and fits: ${colorScheme}, ${size}`, async () => {
    const context = await world.newContext({ colorScheme, viewport, bypassCSP: true });
    const page = await context.newPage();
    const examine = async (about) => {
      await isAccessible(page, { tags, about });
      const taken = await page.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(taken <= viewport.width, `${about} is ${taken} wide`);
      assert.deepEqual(await cutSelects(page), [], about);
    };
    await page.goto(world.url);
    for (const panel of panels) {
      await page.click(`#tab-${panel}`);
      await settled(page, panel);
      if (panel !== "analyze") await looksAsKept(world, page, `page-${panel}-${colorScheme}-${size}`);
      if (panel === "sample") {
        await page.selectOption("#shape", "mask");
        await settled(page, panel);
        await examine("mask");
        await page.selectOption("#shape", "surface");
        await settled(page, panel);
        await looksAsKept(world, page, `page-surface-${colorScheme}-${size}`);
        await examine("surface");
        await page.selectOption("#shape", "polygon");
        await settled(page, panel);
      }
      await unfold(page, panel);
      if (panel === "devices") {
        await page.selectOption("#devices [data-name=device] select", "custom");
        await page.selectOption("#devices [data-name=format] select", "raw");
        await settled(page, panel);
      }
      if (panel === "sample") {
        await page.selectOption("#sample [data-name=order] select", "progressive");
        await settled(page, panel);
      }
      await examine(panel);
    }
    await context.close();
  });
}

test("works by keyboard alone", async () => {
  const { page } = world;
  await page.goto(world.url);
  await settled(page, "halftone");
  await page.keyboard.press("Tab");
  assert.equal(await page.evaluate(() => document.activeElement.id), "tab-halftone");
  await page.keyboard.press("ArrowRight");
  await settled(page, "devices");
  assert.equal(await page.evaluate(() => document.activeElement.id), "tab-devices");
  await page.keyboard.press("ArrowLeft");
  await settled(page, "halftone");
  await page.focus("#halftone [data-name=sites] input[type=range]");
  const before = await page.textContent("#halftone pre");
  await page.keyboard.press("ArrowLeft");
  await settled(page, "halftone");
  assert.notEqual(await page.textContent("#halftone pre"), before);
});
