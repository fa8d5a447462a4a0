// SPDX-License-Identifier: GPL-3.0-or-later
// Tests the client in a project that has the package installed. Environment variables: CCDT_URL is the address of a
// server, CCDT_LIMITED that of one with the key CCDT_KEY and a rate limit of one request per second, CCDT_DATA is the
// folder tests/data.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { test } from "node:test";

import * as main from "ccdt";
import { CcdtError, Client, Job } from "ccdt/client";
import { HalftoneElement } from "ccdt/element";
import { bitmapOf, LocalClient, sample } from "ccdt/wasm";

const { CCDT_URL: url, CCDT_LIMITED: limited, CCDT_KEY: key, CCDT_DATA: data } = process.env;
const client = new Client(url);
const picture = await readFile(path.join(data, "images/chelsea.png"));
const house = await readFile(path.join(data, "meshes/house.obj"));
const triangulations = ["obj", "stl"];  // formats that have no points
const long = { sites: 500_000, quality: "best" };
const torus = { type: "torus", width: 16, height: 16 };

test("modules can be imported where there is no document", () => {
  assert.equal(main.Client, Client);
  assert.equal(typeof HalftoneElement, "function");
});

test("answers are objects, strings or Blobs, as the API describes each format", async () => {
  const { paths, components } = await (await client.request("GET", "/openapi.json")).json();
  const { halftone, sample, analyze } = await client.capabilities();
  const types = await readFile(new URL("node_modules/ccdt/types.d.ts", import.meta.url), "utf8");
  const declared = Object.fromEntries([...types.matchAll(/^ +(\w+): "(\w+\/\S+)";$/gm)].map(([, name, type]) => [name, type]));
  const offered = {};
  for (const [where, formats, ask] of [
    ["halftone", halftone.formats, (format) => client.halftone(picture, { sites: 50, width_mm: 100, format })],
    ["halftone", halftone.devices.formats, (format) => client.device(picture, { device: "1bit", width: 16, format })],
    ["sample", sample.formats, (format) => client.sample(format === "pmtiles"
      ? { sites: 50, polygon: [[0, 0], [9, 0], [9, 8]], coordinates: "lonlat", format }
      : { sites: 50, domain: { ...torus, type: "rectangle" }, width_mm: 100, format })],
    ["sample", sample.masks, (format) => client.sample({ domain: torus, format })],
    ["sample", sample.pixels.formats, (format) => client.sample({ sites: 5, domain: { ...torus, type: "pixels" }, format })],
    ["sample", sample.surfaces.formats,
      (format) => client.sampleMesh(house, { sites: 50, mesh: triangulations.includes(format), format })],
    ["sample", sample.volumes.formats,
      (format) => client.sample({ sites: 500, domain: { ...torus, depth: 9 }, mesh: format === "msh", format })],
    ["analyze", analyze.formats, (format) => client.analyze({ points: [[0, 0], [0.5, 0.5], [0.2, 0.7]], format })],
  ]) {
    for (const { name, media_type: type } of formats) {
      const { schema } = paths[`/${where}`].post.responses[200].content[type];
      const { format, type: kind = "object" } = schema.$ref ? components.schemas[schema.$ref.split("/").pop()] : schema;
      const answer = await ask(name);
      assert.equal(answer instanceof Blob ? "binary" : typeof answer, format ?? kind, `${where}, ${name}`);
      if (answer instanceof Blob) assert.equal(answer.type, type);
      offered[name] = type;
    }
  }
  assert.deepEqual(declared, offered);
});

test("pictures are bytes, Blobs, addresses or responses", async () => {
  const address = `${url}/assets/samples/camera.jpg`;
  const bytes = await (await fetch(address)).arrayBuffer();
  const draw = (input) => client.halftone(input, { sites: 90, format: "csv" });
  const expected = await draw(bytes);
  assert.match(expected, /^x,y/);
  for (const input of [Buffer.from(bytes), new Blob([bytes], { type: "image/jpeg" }), address, new URL(address), await fetch(address)])
    assert.equal(await draw(input), expected);
  await assert.rejects(draw(`${url}/assets/nothing.jpg`), /nothing\.jpg was answered with status 404/);
});

test("options may be lists, and are omitted if undefined", async () => {
  const draw = (options) => client.halftone(picture, { sites: 90, format: "csv", dots: "ink", ...options });
  const listed = await draw({ palette: ["#c03", "#036"], levels: [0.1, 0.9], seed: undefined });
  assert.equal(listed, await draw({ palette: "#c03,#036", levels: "0.1,0.9" }));
  assert.notEqual(listed, await draw({}));
});

test("maps are read from files", async () => {
  const map = await readFile(path.join(data, "polygons/two-countries.zip"));
  const rows = (await client.sampleMap(map, { sites: 100, properties: ["name"], format: "csv" })).trim().split("\r\n");
  assert.deepEqual([rows.length, rows[0]], [101, "x,y,feature,name"]);
});

test("meshes are read from files", async () => {
  const options = { sites: 50, seed: 2, fixed: [[2, 0, 5]], mesh: true };
  const { faces, points, mesh: { vertices } } = await client.sampleMesh(house, options);
  assert.equal(faces.length, 50);
  const ply = await (await client.sampleMesh(house, { ...options, format: "ply" })).text();
  assert.equal((await client.analyzeMesh(house, { points, modes: 5 })).power.length, 5);
  assert.match(ply, new RegExp(`^ply\nformat binary_little_endian 1.0\nelement vertex ${vertices.length}\n`));
});

test("voxels are read from files", async () => {
  const voxels = await readFile(path.join(data, "voxels/cloud.npy"));
  const { points } = await client.sampleVoxels(voxels, { sites: 50, domain: { type: "box", width: 1, height: 1, depth: 1 } });
  assert.ok(points.length === 50 && points.flat().every((each) => each > 0 && each < 1));
});

test("points are chosen among given ones", async () => {
  const candidates = Array.from({ length: 100 }, (_, i) => [i % 10, Math.floor(i / 10)]);
  const { indices, points } = await client.choose({ candidates, sites: 9, keep: [0] });
  assert.ok(indices.length === 9 && indices[0] === 0);
  assert.deepEqual(points, indices.map((index) => candidates[index]));
  const table = new TextEncoder().encode(`name,x,y\n${candidates.map(([x, y]) => `"${x}",${x}.0,${y}\n`).join("")}`);
  const lines = await client.chooseRecords(table, { sites: 9, format: "csv" });
  assert.match(lines, /^name,x,y\n("\d",\d\.0,\d\n){9}$/);
  assert.equal((await client.chooseRecords(table, { sites: 9, order: "progressive" })).indices.length, 9);
});

test("a job has states and a result", async () => {
  const options = { sites: 30_000, format: "csv" };
  const job = await client.halftone(picture, options, { job: true });
  assert.ok(job instanceof Job);
  const states = [];
  for await (const state of job) states.push(state);
  const progress = states.map((state) => state.progress);
  assert.ok(progress.some((part) => part > 0 && part < 1), String(progress));
  assert.deepEqual(progress, [...progress].sort((a, b) => a - b));
  assert.equal(states.at(-1).status, "succeeded");
  const expected = await client.halftone(picture, options);
  assert.equal(await job.result(), expected);
  assert.equal(await client.job(job.id).result(), expected);
  await job.delete();
  await assert.rejects(job.result(), { name: "CcdtError", status: 404 });
});

test("a call reports its progress", async () => {
  const progress = [];
  const options = { sites: 30_000, seed: 1 };
  const dots = await client.halftone(picture, options, { onProgress: (state) => progress.push(state.progress) });
  assert.equal(progress.at(-1), 1);
  assert.ok(progress.length > 2, String(progress));
  const expected = await client.halftone(picture, options);
  assert.deepEqual([dots.type, Buffer.from(await dots.arrayBuffer())], [expected.type, Buffer.from(await expected.arrayBuffer())]);
});

test("an aborted call cancels its job", async () => {
  const controller = new AbortController();
  let id;
  const onProgress = (state) => {
    id = state.id;
    controller.abort();
  };
  await assert.rejects(client.halftone(picture, long, { onProgress, signal: controller.signal }), { name: "AbortError" });
  let last;
  for await (const state of client.job(id)) last = state;
  assert.equal(last.status, "cancelled");
  await assert.rejects(client.job(id).result(), { name: "CcdtError", status: 410 });
  await assert.rejects(client.halftone(picture, long, { signal: controller.signal }), { name: "AbortError" });
});

test("a signal of the client ends all calls that have none of their own", async () => {
  const controller = new AbortController();
  const mine = new Client(url, { signal: controller.signal });
  const job = await mine.halftone(picture, long, { job: true });
  for await (const { status } of client.job(job.id)) {
    if (status === "running") break;
  }
  const ends = Promise.allSettled([mine.halftone(picture, long), job.result()]);
  controller.abort(new Error("enough"));
  for (const { reason } of await ends) assert.equal(reason, controller.signal.reason);
  assert.equal((await (await client.request("GET", `jobs/${job.id}`)).json()).status, "running");
  await job.delete();
});

test("an error has a status, a text, and pointers to the options at fault", async () => {
  for (const [ask, expected] of [
    [() => client.halftone(picture, { sites: 0, tone: "loud" }), ["sites", "tone"]],
    [() => client.sample({ sites: 9, domain: { ...torus, width: -1 } }), ["/domain/width"]],
  ]) {
    await assert.rejects(ask, (error) => {
      assert.ok(error instanceof CcdtError);
      assert.equal(error.status, 400);
      assert.equal(error.message, error.detail);
      assert.deepEqual(error.errors.map(({ pointer }) => pointer).sort(), expected);
      return true;
    });
  }
  await assert.rejects(new Client("http://127.0.0.1:1").capabilities(), { name: "CcdtError", status: 0 });
});

test("a request with an entity tag is answered with 304", async () => {
  const options = { body: picture, type: "application/octet-stream" };
  const response = await client.request("POST", "/halftone?sites=90", options);
  await response.body.cancel();  // an unread body would keep the process alive
  const headers = { "If-None-Match": response.headers.get("ETag") };
  assert.equal((await client.request("POST", "/halftone?sites=90", { ...options, headers })).status, 304);
});

test("a busy server is asked again after the delay that it states", async () => {
  const statuses = [];
  const watch = async (...request) => {
    const response = await fetch(...request);
    statuses.push(response.status);
    return response;
  };
  const request = { sites: 9, domain: torus };
  const impatient = new Client(limited, { key, retries: 0 });
  const { points } = await impatient.sample(request);
  await assert.rejects(impatient.sample(request), { name: "CcdtError", status: 429 });
  assert.deepEqual((await new Client(limited, { key, fetch: watch }).sample(request)).points, points);
  assert.deepEqual(statuses, [429, 200]);
  await assert.rejects(new Client(limited).sample(request), { name: "CcdtError", status: 401 });
});

test("the address of the server may have a path", async () => {
  const seen = [];
  const strip = (address, options) => {
    seen.push(address.pathname);
    return fetch(String(address).replace("/dots/", "/"), options);
  };
  const job = await new Client(`${url}/dots`, { fetch: strip }).sample({ sites: 9, domain: torus }, { job: true });
  assert.equal((await job.result()).points.length, 9);
  assert.deepEqual(seen, ["/dots/sample", `/dots/jobs/${job.id}/events`, `/dots/jobs/${job.id}/result`]);
});

test("WebAssembly gives the answers of the server", async () => {
  const request = { sites: 300, domain: torus, format: "csv" };
  assert.equal(await sample(request), await client.sample(request));
  const bitmap = bitmapOf({ width: 32, height: 32, data: Uint8Array.from({ length: 4096 }, (_, i) => (i % 4 === 3 ? 255 : i / 16)) });
  const shares = [];
  const svg = await new LocalClient().halftone(bitmap, { sites: 200 }, { onProgress: ({ progress }) => shares.push(progress) });
  assert.equal(svg, await client.halftone(bitmap, { sites: 200, format: "svg" }));
  assert(shares.length > 0 && shares.every((share) => share > 0 && share < 1));
});

test("a LocalClient throws the errors of a server", async () => {
  await assert.rejects(sample({ sites: 0, domain: torus }), (error) =>
    error instanceof CcdtError && error.status === 400 && error.errors[0].pointer === "/sites");
  await assert.rejects(sample({ sites: 9, domain: torus, format: "png" }), { status: 406 });
  await assert.rejects(new LocalClient().capabilities(), { status: 0 });
});

test("a LocalClient leaves to its server what takes long or is not offered", async () => {
  const asked = [];
  const far = new LocalClient({ server: url, seconds: 0.1, fetch: (address, init) => {
    asked.push(init.method);
    return fetch(address, init);
  } });
  await far.sample({ sites: 100, domain: torus });
  assert.equal(asked.length, 0);
  await far.sample({ sites: 100, domain: torus, format: "png" });
  await far.sample({ sites: 50_000, domain: torus, format: "csv" });
  await far.capabilities();
  assert.deepEqual(asked, ["POST", "POST", "GET"]);
});
