// SPDX-License-Identifier: GPL-3.0-or-later
// api/openapi.json, checked by Redocly's public validator with its recommended rules, and by a generator of clients.

import assert from "node:assert/strict";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";

import { generateTypes } from "../../server/page/package/generate_types.js";

const require = createRequire(path.join(process.env.CCDT_NODE_MODULES, "of-the-tests"));
const { createConfig, lint } = require("@redocly/openapi-core");
const ts = require("typescript");

const api = path.resolve(import.meta.dirname, "../../api/openapi.json");

// Operators choose the address of their server, so the document may name an example.
const unwanted = { "no-server-example.com": "off" };

test("the document is valid, and has no unused components", async () => {
  const config = await createConfig({ extends: ["recommended"], rules: unwanted });
  const problems = await lint({ ref: api, config });
  assert.deepEqual(problems.map(({ ruleId, message, location }) => [ruleId, message, location[0]?.pointer]), []);
});

// TypeScript whose statements must all compile except the last one.
const uses = `
type Halftone = paths["/halftone"]["post"];
type Sent = NonNullable<Halftone["requestBody"]>["content"];
type Got = Halftone["responses"][200]["content"];
const picture = new Blob();
export const body: Sent["application/octet-stream"] = picture;
export const form: Sent["multipart/form-data"] = { image: picture, sites: 9 };
export const show = async (png: Got["image/png"], npy: Got["application/x-npy"]) => [await png.arrayBuffer(), await npy.text()];
export const read = (json: Got["application/json"]) => ("points" in json ? json.points[0] : json.inks[0].points);
// @ts-expect-error: the range of sites is a number's
export const wrong: Sent["multipart/form-data"] = { image: picture, sites: "many" };
`;

test("generated clients compile, and send and receive pictures as Blobs", async () => {
  const folder = await mkdtemp(path.join(tmpdir(), "ccdt-client-"));
  const file = path.join(folder, "client.ts");
  await writeFile(file, (await generateTypes(api)) + uses);
  const program = ts.createProgram([file], { strict: true, noEmit: true, types: [], target: ts.ScriptTarget.ESNext });
  const complaints = ts.getPreEmitDiagnostics(program).map(({ messageText }) => ts.flattenDiagnosticMessageText(messageText, "\n"));
  await rm(folder, { recursive: true });
  assert.deepEqual(complaints, []);
});
