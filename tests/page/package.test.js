// SPDX-License-Identifier: GPL-3.0-or-later
// The npm package, installed from its tarball into an empty project: its client in Debian's Node.js (CCDT_NODE), its
// types, its element in a page, and the examples of its README.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { cp, mkdir, mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import path from "node:path";
import { after, before, test } from "node:test";

import { closeAtLimit, data, launchChromium, patience, run, serveOrigin, startServer, useBrowser } from "./harness.js";

const require = createRequire(path.join(process.env.CCDT_NODE_MODULES, "of-the-tests"));
const puppeteer = require("puppeteer-core");
const ts = require("typescript");

const root = path.resolve(import.meta.dirname, "../..");
const key = "package-0123456789abcdef";
const world = useBrowser();

let folder, project, tarballs, origin, limited, page;

/** Makes the package in a new folder, and returns the path of its tarball. */
async function pack(name, umask) {
  const target = path.join(folder, name);
  await mkdir(target);
  const script = path.join(root, "server/page/package/pack");
  return path.join(target, (await run("bash", ["-c", `umask ${umask}; exec "$0" "$1"`, script, target])).trim());
}

/** Runs a script in the project with Debian's Node.js. Fails unless it exits with 0. */
async function runInProject(script, environment) {
  const child = spawn(process.env.CCDT_NODE, [script], { cwd: project, stdio: ["ignore", "inherit", "inherit"], env: { ...process.env, ...environment } });
  closeAtLimit(() => child.kill("SIGKILL"));
  const [code] = await once(child, "exit");
  assert.equal(code, 0);
}

/** Returns the examples in the package's README, with the address of the server under test. */
async function examplesOf(language) {
  const readme = await readFile(path.join(project, "node_modules/ccdt/README.md"), "utf8");
  const blocks = [...readme.matchAll(new RegExp(`^\`\`\`${language}\n(.*?)^\`\`\`$`, "gms"))];
  return blocks.map(([, text]) => text.replaceAll("http://localhost:8080", world.url));
}

before(async () => {
  folder = await mkdtemp(path.join(tmpdir(), "ccdt-package-"));
  project = path.join(folder, "project");
  await mkdir(project);
  await writeFile(path.join(project, "package.json"), JSON.stringify({ private: true, type: "module" }));
  tarballs = await Promise.all([pack("first", "022"), pack("second", "077")]);
  await run(path.join(root, "docker/npm"), ["install", "--offline", "--no-audit", "--no-fund", tarballs[0]], { cwd: project });
  await cp(path.join(import.meta.dirname, "package"), project, { recursive: true });
  await cp(path.join(data, "images/chelsea.png"), path.join(project, "photo.jpg"));
  await writeFile(path.join(folder, "keys"), `package:${key}\n`);
  limited = await startServer([`--api-key-file=${path.join(folder, "keys")}`, "--rate-limit=1", "--rate-burst=1"]);
  origin = await serveOrigin((address) => (address === "/" ? page : readFile(path.join(project, address))));
});

after(async () => {
  origin.close();
  limited.server.kill();
  await once(limited.server, "exit");
  await rm(folder, { recursive: true });
});

test("the same sources give the same tarball", async () => {
  const [first, second] = await Promise.all(tarballs.map((file) => readFile(file)));
  assert.ok(first.equals(second));
});

test("the package has no dependencies, and names its licence", async () => {
  const contentOf = (name) => readFile(path.join(project, "node_modules/ccdt", name), "utf8");
  const { dependencies, license } = JSON.parse(await contentOf("package.json"));
  assert.deepEqual([dependencies, license], [undefined, "GPL-3.0-or-later"]);
  assert.match(await contentOf("LICENSE"), /GNU GENERAL PUBLIC LICENSE/);
});

test("the client works in Debian's Node.js", () =>
  runInProject("client.test.js", { CCDT_URL: world.url, CCDT_LIMITED: limited.url, CCDT_KEY: key, CCDT_DATA: data }));

test("the types accept right uses and reject wrong ones", () => {
  const options = { strict: true, noEmit: true, types: [], target: ts.ScriptTarget.ESNext, module: ts.ModuleKind.NodeNext };
  const program = ts.createProgram([path.join(project, "types.ts")], options);
  const complaints = ts.getPreEmitDiagnostics(program).map(({ file, start, messageText }) =>
    `${file?.getLineAndCharacterOfPosition(start).line + 1}: ${ts.flattenDiagnosticMessageText(messageText, "\n")}`);
  assert.deepEqual(complaints, []);
});

test("the examples of the README run in Node.js", async () => {
  const examples = await examplesOf("js");
  assert.ok(examples.length > 0);
  await writeFile(path.join(project, "examples.js"), examples.join(""));
  await runInProject("examples.js");
  assert.match(await run("file", ["dots.png"], { cwd: project }), /PNG image data/);
});

test("the example of the README shows dots in a page of another origin, as the client returns them", async () => {
  [page] = await examplesOf("html");
  await world.page.goto(origin.url);
  const shown = await world.page.waitForFunction(() => {
    const [picture, drawing] = document.querySelector("ccdt-halftone").shadowRoot?.children ?? [];
    return drawing?.hidden && picture.naturalWidth > 0 && picture.src;
  });
  const [inElement, inClient] = await world.page.evaluate(async ([address, url]) => {
    const { Client } = await import("/node_modules/ccdt/client.js");
    const dots = await new Client(url).halftone("photo.jpg", { sites: 20000, color: "cmyk", width: 451 });
    return Promise.all([await fetch(address), new Response(dots)].map(async (one) => [...new Uint8Array(await one.arrayBuffer())]));
  }, [await shown.jsonValue(), world.url]);
  assert.ok(inElement.length > 1000);
  assert.deepEqual(inElement, inClient);
});

test("the example with a camera follows it", async () => {
  [, page] = await examplesOf("html");
  const browser = await launchChromium("--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream");
  const tab = await browser.newPage();
  tab.setDefaultTimeout(patience);
  await tab.goto(origin.url);
  const frames = await tab.evaluate(() => new Promise((resolve) => {
    const frames = [];
    document.querySelector("ccdt-halftone").addEventListener("load", ({ target }) => {
      if (frames.push(target.shadowRoot.children[0].src) === 3) resolve(frames);
    });
  }));
  assert.equal(new Set(frames).size, 3);
  await browser.close();
});

test("the example without a server draws its points in a page", async () => {
  [, , page] = await examplesOf("html");
  await world.page.goto(origin.url);
  await world.page.waitForFunction(() => {
    const { data } = document.querySelector("canvas").getContext("2d").getImageData(0, 0, 400, 400);
    return data.filter((value) => value > 0).length > 9000;
  });
});

test("a page draws a halftone of a picture that the browser decodes, and ends a computation", async () => {
  page = "<!DOCTYPE html><title>Local</title>";
  await world.page.goto(origin.url);
  const [svg, name] = await world.page.evaluate(async () => {
    const { halftone, sample } = await import("/node_modules/ccdt/wasm.js");
    const long = { sites: 1_000_000, domain: { type: "torus", width: 1, height: 1 } };
    const signal = AbortSignal.timeout(300);
    const ended = await sample(long, { signal }).catch((error) => error.name);
    return [await halftone("photo.jpg", { sites: 500 }), ended];
  });
  assert.equal(svg.match(/<circle|<use|[Mm]/g).length > 400, true);
  assert.equal(name, "TimeoutError");
});

test("a computation that is aborted before its worker has it does not begin", async () => {
  page = "<!DOCTYPE html><title>Local</title>";
  await world.page.goto(origin.url);
  const name = await world.page.evaluate(async () => {
    const { sample } = await import("/node_modules/ccdt/wasm.js");
    const controller = new AbortController();
    const ended = sample({ sites: 1000, domain: { type: "torus", width: 1, height: 1 } }, { signal: controller.signal });
    controller.abort();
    return ended.then(() => "computed", (error) => error.name);
  });
  assert.equal(name, "AbortError");
});

test("a client loads the module again after a failure", async () => {
  page = "<!DOCTYPE html><title>Local</title>";
  await world.page.goto(origin.url);
  const [{ status, message }, { points }] = await world.page.evaluate(async () => {
    const { sample } = await import("/node_modules/ccdt/wasm.js");
    const { fetch } = window;
    window.fetch = () => Promise.reject(new TypeError("the network is down"));
    const request = { sites: 9, domain: { type: "torus", width: 1, height: 1 } };
    const error = await sample(request).catch(({ status, message }) => ({ status, message }));
    window.fetch = fetch;
    return [error, await sample(request)];
  });
  assert.deepEqual([status, message, points.length], [500, "WebAssembly failed: TypeError: the network is down", 9]);
});

test("Firefox computes without a network, with the bytes of Chromium", async (context) => {
  if (!process.env.CCDT_FIREFOX?.startsWith("/")) return context.skip("Firefox is missing");
  page = '<!DOCTYPE html><title>Local</title><link rel="icon" href="data:,">';
  const browser = await puppeteer.launch({ browser: "firefox", executablePath: process.env.CCDT_FIREFOX, timeout: patience });
  closeAtLimit(() => browser.process().kill("SIGKILL"));
  const served = await serveOrigin((address) => (address === "/" ? page : readFile(path.join(project, address))));
  const answers = async (tab, offline) => {
    await tab.goto(served.url);
    await tab.evaluate(async () => {
      globalThis.ccdt = await import("/node_modules/ccdt/wasm.js");
      globalThis.picture = await (await fetch("chelsea.png")).blob();
      await ccdt.sample({ sites: 9, domain: { type: "torus", width: 1, height: 1 } });  // loads the module
    });
    offline();
    return tab.evaluate(async () => [
      await ccdt.sample({ sites: 1000, domain: { type: "torus", width: 1, height: 1 }, format: "csv" }),
      await ccdt.halftone(picture, { sites: 2000 }),
    ]);
  };
  const inChromium = await answers(world.page, () => {});
  assert.deepEqual(await answers(await browser.newPage(), served.close), inChromium);
  await browser.close();
});
