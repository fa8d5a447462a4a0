// SPDX-License-Identifier: GPL-3.0-or-later
// Answers requests by the WebAssembly module: node wasm_answers.mjs ccdt.wasm
// Reads and writes lines of JSON: { operation, options, type, body }, { status, type, body }. Bodies are base64.

import { readFile } from "node:fs/promises";
import { createInterface } from "node:readline";

import { Engine, Refusal } from "../../api/wasm/loader.mjs";

const engine = new Engine(await WebAssembly.compile(await readFile(process.argv[2])));

function answerTo({ operation, body, ...request }) {
  try {
    const answer = engine.answer(operation, Buffer.from(body, "base64"), request);
    return { status: 200, type: answer.type, body: Buffer.from(answer.body).toString("base64") };
  } catch (error) {
    if (!(error instanceof Refusal)) return { status: 0, type: "", body: btoa(error) };
    return { status: error.status, type: "application/problem+json", body: btoa(JSON.stringify(error.problem)) };
  }
}

for await (const line of createInterface({ input: process.stdin })) console.log(JSON.stringify(answerTo(JSON.parse(line))));
