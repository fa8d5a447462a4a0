// SPDX-License-Identifier: GPL-3.0-or-later
// Uses of the package that must compile. Those after an expected error must not.

import { CcdtError, Client } from "ccdt/client";
import type { HalftoneOptions, Job, JobState } from "ccdt";
import "ccdt/element";

const client = new Client("http://localhost:8080", { key: "k", retries: 1, fetch, signal: AbortSignal.timeout(1000) });
const picture = new Blob();
const torus = { type: "torus", width: 1, height: 1 } as const;
const { signal } = new AbortController();

export const png: Promise<Blob> = client.halftone(picture);
export const svg: Promise<string> = client.halftone("photo.jpg", { format: "svg", palette: ["#c03"], levels: [0.1, 0.9] });
export const either: Promise<string | Blob> = client.halftone(new Uint8Array(9), { format: "png" as "png" | "csv" });
export const poster: Promise<string> = client.halftone(picture, { preset: "poster", format: "svg" });
export const raw: Promise<Blob> = client.device(picture, { device: "spectra6", format: "raw" }, { signal });
export const points: Promise<number[][]> = client.sample({ sites: 9, domain: torus }).then((answer) => answer.points);
export const features: Promise<"Feature" | "FeatureCollection"> =
  client.sample({ sites: 9, polygon: [[0, 0], [1, 0], [0, 1]], format: "geojson" }).then((answer) => answer.type);
export const mask: Promise<Blob> = client.sample({ domain: torus, format: "mask" });
export const csv: Promise<string> = client.sampleMap(new URL("http://localhost/map.zip"), { sites: "people", per: 10, format: "csv" });
export const districts: Promise<string> = client.sampleMap(picture, { preset: "districts", format: "svg" });
export const mesh: Promise<Blob> = client.sampleMesh(picture, { sites: 9, mesh: true, density: [1, 2], format: "glb" });
export const inside: Promise<Blob> = client.sampleMesh(picture, { sites: 9, domain: "solid", mesh: true, format: "vtu" });
export const voxels: Promise<string> = client.sampleVoxels(picture, { sites: 9, domain: { ...torus, depth: 2 }, format: "csv" });
export const space: Promise<Blob> = client.sample({ sites: 9, domain: { ...torus, depth: 2 }, mesh: true, format: "msh" });
export const chosen: Promise<number[]> = client.choose({ candidates: [[0, 0], [1, 1]], sites: 1 }).then((answer) => answer.indices);
export const records: Promise<string> = client.chooseRecords(picture, { sites: 9, priority: "rank", format: "csv" });
export const measured: Promise<number> = client.analyze({ points: [[0, 0], [0.5, 0.5]] }).then((answer) => answer.mean_distance);
export const onMesh: Promise<number[]> = client.analyzeMesh(picture, { points: [[0, 0, 0], [1, 1, 1]], modes: 9 }).then((answer) => answer.eigenvalues);
export const limit: Promise<number> = client.capabilities().then((answer) => answer.limits.max_sites);

export async function follow(options: HalftoneOptions): Promise<string> {
  const job: Job<string> = await client.halftone(picture, { ...options, format: "svg" }, { job: true });
  for await (const state of job) show(state);
  try {
    return await job.result({ signal });
  } catch (error) {
    return error instanceof CcdtError ? error.errors.map(({ pointer, detail }) => `${pointer}: ${detail}`).join() : "";
  }
}

export const show = ({ status, progress }: JobState): boolean => status === "succeeded" || progress === 1;
document.querySelector("ccdt-halftone")?.abort();
document.querySelector("ccdt-halftone")?.refresh();

// @ts-expect-error: a number
client.halftone(picture, { sites: "many" });
// @ts-expect-error: a name
client.halftone(picture, { preset: 9 });
// @ts-expect-error: no such option
client.halftone(picture, { site: 9 });
// @ts-expect-error: no such format
client.halftone(picture, { format: "gif" });
// @ts-expect-error: no such value
client.halftone(picture, { tone: "loud" });
// @ts-expect-error: an option of devices
client.halftone(picture, { device: "1bit" });
// @ts-expect-error: no device
client.device(picture, { width: 800 });
// @ts-expect-error: not a picture
client.halftone(9);
// @ts-expect-error: no area
client.sample({ sites: 9 });
// @ts-expect-error: a number or a property
client.sample({ sites: true, domain: torus });
// @ts-expect-error: a name
client.halftone(picture, { preset: 9 });
// @ts-expect-error: no such option
client.sample({ sites: 9, domain: torus, color: "cmyk" });
// @ts-expect-error: no points
client.analyze({ max_frequency: 2 });
// @ts-expect-error: no points
client.analyzeMesh(picture, { modes: 9 });
// @ts-expect-error: a Blob
client.halftone(picture, { format: "png" }).then((answer) => answer.points);
// @ts-expect-error: a job
client.sample({ sites: 9, domain: torus }, { job: true }).then((answer) => answer.points);
// @ts-expect-error: not a signal
client.capabilities({ signal: 9 });
// @ts-expect-error: no such member
new Client("http://localhost:8080", { token: "k" });
