// The README's page, as it stands there, opened from another origin than the server's.

import assert from "node:assert/strict";
import { once } from "node:events";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import path from "node:path";
import { after, before, test } from "node:test";

import { data, useBrowser } from "./harness.js";

const world = useBrowser();

let origin;

before(async () => {
  const readme = await readFile(path.join(data, "../../README.md"), "utf8");
  const [, example] = readme.match(/^```html\n(.*?)^```$/ms);
  origin = createServer((request, response) => {
    response.setHeader("Content-Type", "text/html");
    response.end(example.replace("http://localhost:8080", world.url));
  });
  origin.listen(0, "127.0.0.1");
  await once(origin, "listening");
});

after(() => origin.close());

test("the README's page puts a dotted picture into a page of another origin", async () => {
  await world.page.goto(`http://127.0.0.1:${origin.address().port}/`);
  await world.page.setInputFiles("input", path.join(data, "images/chelsea.png"));
  await world.page.waitForFunction(() => document.querySelector("img").naturalWidth > 0);
  const [width, height] = await world.page.evaluate(() => {
    const picture = document.querySelector("img");
    return [picture.naturalWidth, picture.naturalHeight];
  });
  assert.equal(width % 451, 0);
  assert.equal(height, 300 * (width / 451));
});
