// SPDX-License-Identifier: GPL-3.0-or-later
// Computes the answers of wasm.ts: in a worker, or in the thread of Node.js.

import { bitmapOf, Engine, Refusal } from "./loader.mjs";

/**
 * @typedef {object} Task
 * @property {WebAssembly.Module} module
 * @property {"halftone" | "sample" | "analyze"} operation
 * @property {[string, string][]} options
 * @property {string} type
 * @property {Blob} body
 * @property {number} seconds  limit of the estimated time
 */
/**
 * @typedef {object} Outcome
 * @property {number} status  as in HTTP; 202 if the estimated time is longer than the limit
 * @property {string} type
 * @property {Uint8Array<ArrayBuffer> | string} body
 * @property {string} [warnings]
 * @property {string} [repaired]
 */

/** @type {Engine | undefined} */
let engine;

/** Compiles the module, which lies beside this file. Workers share it. */
export async function load() {
  const url = new URL("./ccdt.wasm", import.meta.url);
  if (url.protocol !== "file:") return WebAssembly.compileStreaming(fetch(url));
  const files = "node:fs/promises";
  const { readFile } = await import(files);
  return WebAssembly.compile(await readFile(url));
}

/**
 * Returns the outcome of a task whose computation has failed.
 * @param {unknown} error
 * @returns {Outcome}
 */
export function failureOf(error) {
  const problem = error instanceof Refusal ? error.problem : { status: 500, detail: `WebAssembly failed: ${error}` };
  return { status: problem.status, type: "application/problem+json", body: JSON.stringify(problem) };
}

/**
 * Decodes a picture by the browser, and returns its pixels as BMP. If there is no decoder for it, returns the file.
 * @param {Blob} file
 */
async function decoded(file) {
  const [first] = new Uint8Array(await file.slice(0, 1).arrayBuffer());
  const isBitmap = first === 0x42, isJson = first === 0x7b;
  if (isBitmap || isJson || !globalThis.OffscreenCanvas) return new Uint8Array(await file.arrayBuffer());
  const image = await createImageBitmap(file).catch(() => null);
  const context = image && new OffscreenCanvas(image.width, image.height).getContext("2d");
  if (!context) return new Uint8Array(await file.arrayBuffer());
  context.drawImage(image, 0, 0);
  return bitmapOf(context.getImageData(0, 0, image.width, image.height));
}

/**
 * @param {Task} task
 * @param {(share: number) => void} [progress]
 * @returns {Promise<Outcome>}
 */
export async function compute({ module, operation, body, ...request }, progress) {
  try {
    engine ??= new Engine(module);
    const bytes = operation === "halftone" ? await decoded(body) : new Uint8Array(await body.arrayBuffer());
    const answer = engine.answer(operation, bytes, { ...request, progress });
    return answer ? { status: 200, ...answer } : { status: 202, type: "", body: "" };
  } catch (error) {
    return failureOf(error);
  }
}
