// SPDX-License-Identifier: GPL-3.0-or-later
// The worker in which wasm.ts computes.

import { compute } from "./compute.js";

globalThis.addEventListener("message", async ({ data }) => {
  globalThis.postMessage({ outcome: await compute(data, (share) => globalThis.postMessage({ share })) });
});
