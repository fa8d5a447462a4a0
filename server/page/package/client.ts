// SPDX-License-Identifier: GPL-3.0-or-later
// Client of ccdt-server with a method for each computation.

import { Connection, contentOf } from "./connection.js";
import type { Job } from "./connection.js";
import type {
  AnalyzeFormat, AnalyzeRequest, Answer, Bytes, Capabilities, Choice, ChoiceFormat, ChoiceOptions, ChoiceRequest,
  DeviceFormat, DeviceOptions, FileInput, HalftoneFormat, HalftoneOptions, MapOptions, RecordFormat, RequestOptions,
  SampleFormat, SampleRequest, SurfaceAnalysis, SurfaceAnalyzeOptions, SurfaceFormat, SurfaceOptions, VolumeFormat,
  VolumeOptions,
} from "./types.js";

export { CcdtError, Connection, Job } from "./connection.js";
export type * from "./types.js";

export interface Call {
  /** Ends the call, and cancels its computation unless `job` is true. */
  signal?: AbortSignal;
  /** Receives the states of the computation, which runs as a job. */
  onProgress?: RequestOptions["onProgress"];
  /** Starts a job, and returns it instead of the answer. */
  job?: boolean;
}

/** Result of a call: a job if `job` is true, otherwise the answer. */
export type Outcome<A, C extends Call> = Promise<C extends { job: true } ? Job<A> : A>;

/** Returns options as parameters of a URL or fields of a form. Items of lists are separated by commas. */
function parametersOf(options: object): [string, string][] {
  return Object.entries(options).filter(([, value]) => value !== undefined).map(([name, value]) => [name, String(value)]);
}

export class Client extends Connection {
  /** Makes a halftone of a picture. The default format is PNG. */
  async halftone<F extends HalftoneFormat = "png", C extends Call = {}>(
    picture: FileInput, options: HalftoneOptions & { format?: F } = {}, call?: C): Outcome<Answer<"/halftone", F>, C> {
    return this.#draw(picture, options, call);
  }

  /** Converts a picture to the pixels and colours of a device. The default format is PNG. */
  async device<F extends DeviceFormat = "png", C extends Call = {}>(
    picture: FileInput, options: DeviceOptions & { format?: F }, call?: C): Outcome<Answer<"/halftone", F>, C> {
    return this.#draw(picture, options, call);
  }

  /** Spreads points in a polygon, a map, a rectangle, a torus, a raster or a box. The default format is JSON. */
  async sample<F extends SampleFormat | VolumeFormat = "json", C extends Call = {}>(
    request: SampleRequest & { format?: F }, call?: C): Outcome<Answer<"/sample", F>, C> {
    return this.#compute("sample", { body: JSON.stringify(request), type: "application/json" }, call);
  }

  /** Spreads points in a map from a file: GeoJSON, TopoJSON or a zipped shapefile. The default format is JSON. */
  async sampleMap<F extends SampleFormat = "json", C extends Call = {}>(
    map: FileInput, options: MapOptions & { format?: F }, call?: C): Outcome<Answer<"/sample", F>, C> {
    const body = new FormData();
    body.append("map", new Blob([await this.#contentOf(map, call) as BlobPart]));
    for (const [name, value] of parametersOf(options)) body.append(name, value);
    return this.#compute("sample", { body }, call);
  }

  /**
   * Spreads points on the surface of a mesh in a file or, with the domain `solid`, inside it. The file is STL, OBJ, PLY,
   * OFF, GLB or glTF. The default format is JSON.
   */
  async sampleMesh<F extends SurfaceFormat | VolumeFormat = "json", C extends Call = {}>(
    mesh: FileInput, options: (SurfaceOptions | VolumeOptions) & { format?: F },
    call?: C): Outcome<Answer<"/sample", F>, C> {
    return this.#send("sample", mesh, options, call);
  }

  /** Spreads points in space with the density in a file of voxels: NPY or TIFF. The default format is JSON. */
  async sampleVoxels<F extends VolumeFormat = "json", C extends Call = {}>(
    voxels: FileInput, options: VolumeOptions & { format?: F }, call?: C): Outcome<Answer<"/sample", F>, C> {
    return this.#send("sample", voxels, options, call);
  }

  /** Chooses an exact number of given points, evenly spread. The default format is JSON. */
  async choose<F extends ChoiceFormat = "json", C extends Call = {}>(
    request: ChoiceRequest & { format?: F }, call?: C): Outcome<Choice<F>, C> {
    return this.#compute("sample", { body: JSON.stringify(request), type: "application/json" }, call);
  }

  /**
   * Chooses among the records of a file: CSV, GeoJSON, NPY or PLY. The default format is JSON, with the indices of the
   * chosen records. In the file's own format, the answer consists of these records, unchanged.
   */
  async chooseRecords<F extends RecordFormat = "json", C extends Call = {}>(
    file: FileInput, options: ChoiceOptions & { format?: F }, call?: C): Outcome<Choice<F>, C> {
    return this.#send("sample", file, { format: "json", ...options, candidates: "body" }, call);
  }

  /** Measures how evenly points are spread. The default format is JSON. */
  async analyze<F extends AnalyzeFormat = "json", C extends Call = {}>(
    request: AnalyzeRequest & { format?: F }, call?: C): Outcome<Answer<"/analyze", F>, C> {
    return this.#compute("analyze", { body: JSON.stringify(request), type: "application/json" }, call);
  }

  /** Measures points on the surface of a mesh in a file. */
  async analyzeMesh<C extends Call = {}>(
    mesh: FileInput, options: SurfaceAnalyzeOptions, call?: C): Outcome<SurfaceAnalysis, C> {
    return this.#send("analyze", mesh, options, call);
  }

  /** Returns the formats, options, methods and limits of the server. */
  async capabilities(call?: { signal?: AbortSignal }): Promise<Capabilities> {
    return (await this.request("GET", "capabilities", call)).json();
  }

  async #draw(picture: FileInput, options: object, call?: Call): Promise<any> {
    const body = await this.#contentOf(picture, call);
    return this.#compute(`halftone?${new URLSearchParams(parametersOf(options))}`, { body, type: "application/octet-stream" }, call);
  }

  /** Sends a file and options as a form. */
  async #send(path: string, file: FileInput, options: object, call?: Call): Promise<any> {
    const body = new FormData();
    body.append("file", new Blob([await this.#contentOf(file, call) as BlobPart]));
    const texts = Object.entries(options).map(([name, value]) => [name, typeof value === "object" ? JSON.stringify(value) : value]);
    for (const [name, value] of parametersOf(Object.fromEntries(texts))) body.append(name, value);
    return this.#compute(path, { body }, call);
  }

  async #compute(path: string, content: RequestOptions, { job, ...options }: Call = {}): Promise<any> {
    const request = { ...options, ...content };
    return job ? this.start("POST", path, request) : contentOf(await this.request("POST", path, request));
  }

  /** Returns the content of a file. Fetches it if it is given by its address. */
  async #contentOf(file: FileInput, { signal = this.signal }: Call = {}): Promise<Bytes> {
    const { fetch } = this;
    const found = typeof file === "string" || file instanceof URL ? await fetch(file, { signal }) : file;
    if (!("ok" in found)) return found;
    if (!found.ok) throw new Error(`${found.url} was answered with status ${found.status}`);
    return found.blob();
  }
}
