// SPDX-License-Identifier: GPL-3.0-or-later
// Long computations run as jobs, whose progress is shown.

import assert from "node:assert/strict";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { describe, test } from "node:test";

import { settled, useBrowser } from "./harness.js";

const asJob = ["POST /halftone 202", "GET /jobs/ID/events 200", "GET /jobs/ID/result 200", "DELETE /jobs/ID 204"];

/** Returns a function that returns all requests so far, without job ids, and the statuses of their answers. */
function watch(page) {
  const requests = [];
  page.on("request", (one) => {
    const { pathname } = new URL(one.url());
    if (/^\/(halftone|sample|jobs)/.test(pathname)) requests.push([one, `${one.method()} ${pathname.replace(/[0-9a-f]{32}/, "ID")}`]);
  });
  return () => Promise.all(requests.map(async ([one, what]) => `${what} ${(await one.response())?.status() ?? "lost"}`));
}

/** Returns a function that returns [percent, text] for each change of the progress bar so far. */
async function watchBar(page) {
  await page.evaluate(() => {
    const find = (selector) => document.querySelector(`#halftone ${selector}`);
    window.shown = [];
    new MutationObserver(() => {
      if (find("progress").hasAttribute("value")) window.shown.push([find("progress").value, find(".job").innerText]);
    }).observe(find(".stage"), { subtree: true, childList: true, attributes: true });
  });
  return () => page.evaluate(() => window.shown);
}

async function open(world) {
  await world.page.goto(`${world.url}/#halftone?sites=500`);
  await settled(world.page, "halftone");
}

async function makeLarge({ page }) {
  const sites = page.locator("#halftone [data-name=sites] input[type=number]");
  await sites.fill("45000");
  await sites.blur();
  await settled(page, "halftone");
  assert.match(await page.textContent("#halftone .status"), /^45,000 dots/);
}

/** Requests points that take much longer than a cancellation. Returns the job when it has made progress. */
async function beginLong(world) {
  const { page } = world;
  await page.goto(`${world.url}/#sample?shape=polygon`);
  await settled(page, "sample");
  const answered = page.waitForResponse((one) => one.status() === 202);
  const sites = page.locator("#sample [data-name=sites] input[type=number]");
  await sites.fill("5000");
  await sites.blur();
  await page.selectOption("#sample [data-name=method] select", "ccvt");
  const job = world.url + (await answered).headers().location;
  await page.waitForFunction(() => document.querySelector("#sample progress").value > 0);
  return job;
}

/** Waits for a job's last event and returns it. */
const endOf = async (job) => (await (await fetch(`${job}/events`)).text()).match(/event: (.*)\ndata: .*\n\n$/)[1];

describe("a large request", () => {
  const world = useBrowser();

  test("shows its progress", async () => {
    await open(world);
    const seen = watch(world.page);
    const shown = await watchBar(world.page);
    await makeLarge(world);
    const steps = await shown();
    const values = steps.map(([value]) => value);
    assert.deepEqual(values, [...values].sort((a, b) => a - b));
    assert.ok(new Set(values.filter((value) => value > 0 && value < 100)).size >= 4, String(values));
    for (const [value, text] of steps) assert.match(text, value > 0 ? new RegExp(`^${value} %\\s*Cancel$`) : /^(waiting|0 %)\s*Cancel$/);
    assert.ok(await world.page.isHidden("#halftone .job"));
    assert.deepEqual(await seen(), asJob);
  });

  test("reports its percentage to screen readers, and can be cancelled", async () => {
    const job = await beginLong(world);
    const session = await world.page.context().newCDPSession(world.page);
    const { nodes } = await session.send("Accessibility.getFullAXTree");
    const [bar, ...others] = nodes.filter(({ role, ignored }) => role?.value === "progressbar" && !ignored);
    assert.deepEqual(others, []);
    assert.equal(bar.name.value, "Computing");
    assert.ok(Number(bar.value.value) > 0 && Number(bar.value.value) < 100, JSON.stringify(bar.value));
    await world.page.click("#sample .job button");
    await settled(world.page, "sample");
    assert.match(await world.page.textContent("#sample .status"), /^Cancelled/);
    assert.equal(await endOf(job), "cancelled");
  });

  test("is cancelled once it is outdated", async () => {
    const job = await beginLong(world);
    await world.page.selectOption("#sample [data-name=method] select", "random");
    await settled(world.page, "sample");
    assert.match(await world.page.textContent("#sample .status"), /^5,000 points/);
    assert.equal(await endOf(job), "cancelled");
  });

  test("is cancelled when the page is left", async () => {
    const job = await beginLong(world);
    await world.page.goto("about:blank");
    assert.equal(await endOf(job), "cancelled");
  });

  test("is polled when its events are lost", async () => {
    await open(world);
    await world.page.route("**/events", (route) => route.abort());
    const seen = watch(world.page);
    const shown = await watchBar(world.page);
    await makeLarge(world);
    assert.ok((await shown()).length > 0);
    const polls = (await seen()).filter((one) => one === "GET /jobs/ID 200");
    assert.ok(polls.length > 0);
    const [accepted, , ...rest] = asJob;
    assert.deepEqual(await seen(), [accepted, "GET /jobs/ID/events lost", ...polls, ...rest]);
  });

  test("is polled when its events stop", async () => {
    const { page } = world;
    await page.clock.install();
    await open(world);
    await page.route("**/events", () => {});  // never answered
    const polled = page.waitForRequest((one) => /\/jobs\/[0-9a-f]+$/.test(one.url()) && one.method() === "GET");
    const later = page.waitForRequest("**/events").then(() => page.clock.fastForward(60000));
    await Promise.all([makeLarge(world), polled, later]);
    await page.unrouteAll({ behavior: "ignoreErrors" });
  });
});

describe("a server that accepts no jobs", () => {
  const world = useBrowser({ flags: ["--job-queue=0"] });

  test("gets a synchronous request instead", async () => {
    await open(world);
    const seen = watch(world.page);
    await makeLarge(world);
    assert.deepEqual(await seen(), ["POST /halftone 429", "POST /halftone 200"]);
  });
});

describe("a server with too small a limit for the result", () => {
  const world = useBrowser({ flags: ["--job-bytes=128KiB"] });

  test("gets a synchronous request instead", async () => {
    await open(world);
    const seen = watch(world.page);
    await makeLarge(world);
    const [accepted, events, , removed] = asJob;
    assert.deepEqual(await seen(), [accepted, events, "GET /jobs/ID/result 507", removed, "POST /halftone 200"]);
  });
});

describe("a server with keys", () => {
  const key = "page-0123456789abcdef";
  const file = path.join(mkdtempSync(path.join(tmpdir(), "ccdt-page-")), "keys");
  writeFileSync(file, `page:${key}\n`);
  const world = useBrowser({ flags: [`--api-key-file=${file}`] });

  test("sends the key with all requests about a job", async () => {
    await world.page.goto(world.url);
    await world.page.fill("#key", key);
    await world.page.click("#access button");
    await settled(world.page, "halftone");
    const seen = watch(world.page);
    await makeLarge(world);
    assert.deepEqual(await seen(), asJob);
  });
});
