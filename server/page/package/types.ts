// SPDX-License-Identifier: GPL-3.0-or-later
// Types of requests and answers, derived from the types that `pack` generates from api/openapi.json.

import type { components, paths } from "./openapi.js";

type Schemas = components["schemas"];

/** `preset` names options that the operator of the server has defined. Other options override them. */
interface WithPreset { preset?: string }

export type HalftoneOptions = Schemas["HalftoneOptions"] & WithPreset;
export type DeviceOptions = Schemas["DeviceOptions"] & WithPreset;
export type SampleRequest = Schemas["SampleRequest"] | Schemas["PixelRequest"] | Schemas["VolumeRequest"];
export type AnalyzeRequest = Schemas["AnalyzeRequest"];
export type Capabilities = Schemas["Capabilities"];
export type JobState = Schemas["Job"];

/** An error of one option. `pointer` is a JSON Pointer or the name of the option. */
export type OptionError = NonNullable<Schemas["Problem"]["errors"]>[number];

/** Options for a map in a file. `sites` is a number or the name of the property that holds the counts. */
export type MapOptions = Omit<Schemas["SampleOptions"], "sites"> & WithPreset & { sites?: number | string };

/** Options for points on a mesh in a file. */
export type SurfaceOptions = Schemas["SurfaceOptions"] & WithPreset;

/** Options for points in space, with a file of voxels or, with the domain `solid`, of a mesh. */
export type VolumeOptions = Schemas["VolumeOptions"] & WithPreset;

export type ChoiceRequest = Schemas["ChoiceRequest"];

/** Options for candidates in a file. They name columns of CSV, properties of GeoJSON or a PLY, or columns of NPY. */
export type ChoiceOptions = Omit<Schemas["ChoiceOptions"], "candidates"> & WithPreset;

/** Options for the analysis of points on a mesh. `points` may also be the text of a file. */
export type SurfaceAnalyzeOptions = Omit<Schemas["SurfaceAnalyzeOptions"], "points"> & WithPreset & { points: Schemas["Position"][] | string };
export type SurfaceAnalysis = Schemas["SurfaceAnalysis"];

export type HalftoneFormat = NonNullable<HalftoneOptions["format"]>;
export type DeviceFormat = NonNullable<DeviceOptions["format"]>;
export type SampleFormat = NonNullable<Schemas["SampleOptions"]["format"]>;
export type SurfaceFormat = NonNullable<SurfaceOptions["format"]>;
export type VolumeFormat = NonNullable<VolumeOptions["format"]>;
export type ChoiceFormat = NonNullable<ChoiceRequest["format"]>;
export type RecordFormat = NonNullable<ChoiceOptions["format"]>;
export type AnalyzeFormat = NonNullable<AnalyzeRequest["format"]>;

/** Media types of the formats, as in the answer of `/capabilities`. */
interface MediaTypes {
  json: "application/json";
  geojson: "application/geo+json";
  ndjson: "application/x-ndjson";
  geojsonseq: "application/geo+json-seq";
  csv: "text/csv";
  npy: "application/x-npy";
  svg: "image/svg+xml";
  png: "image/png";
  mask: "image/png";
  mask16: "image/png";
  masknpy: "application/x-npy";
  webp: "image/webp";
  jpeg: "image/jpeg";
  tiff: "image/tiff";
  bmp: "image/bmp";
  raw: "application/octet-stream";
  escpos: "application/x-escpos";
  pdf: "application/pdf";
  eps: "application/postscript";
  hpgl: "application/vnd.hp-hpgl";
  gcode: "text/x-gcode";
  dxf: "image/vnd.dxf";
  pmtiles: "application/vnd.pmtiles";
  ply: "model/ply";
  glb: "model/gltf-binary";
  obj: "model/obj";
  stl: "model/stl";
  vtu: "application/x-vtu";
  msh: "application/x-gmsh";
}

/** Content of an answer: an object for JSON and GeoJSON, a string for other text, otherwise a Blob. */
export type Answer<P extends "/halftone" | "/sample" | "/analyze", F extends keyof MediaTypes> =
  paths[P]["post"]["responses"][200]["content"] extends infer Contents ? Contents[MediaTypes[F] & keyof Contents] : never;

/** Content of an answer with chosen points. */
export type Choice<F extends RecordFormat> = F extends "json" ? Schemas["ChosenPoints"] : Answer<"/sample", F>;

/** Content of a file. */
export type Bytes = Blob | ArrayBuffer | ArrayBufferView;

/** A file: its content, its address, or the response that contains it. */
export type FileInput = Bytes | string | URL | Response;

export interface ConnectionOptions {
  /** API key, if the server requires one. */
  key?: string | null;
  /** Replaces the global `fetch`. */
  fetch?: typeof globalThis.fetch;
  /** Maximum number of repetitions of a request while the server is busy (429 or 503); 3 by default. */
  retries?: number;
  /** Ends all calls that have no signal of their own. */
  signal?: AbortSignal;
}

export interface RequestOptions {
  body?: Bytes | string | FormData;
  /** Media type of the body. */
  type?: string;
  headers?: Record<string, string>;
  /** Ends the request, and cancels its computation. null: no signal does, not even that of the connection. */
  signal?: AbortSignal | null;
  /** Receives the states of the computation, which runs as a job. The job is cancelled if the request ends early. */
  onProgress?: (state: JobState) => void;
  /** Replaces `retries` of the connection. */
  retries?: number;
  /** Lets the request outlive a page in a browser. */
  keepalive?: boolean;
}
