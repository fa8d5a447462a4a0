// SPDX-License-Identifier: GPL-3.0-or-later
// The client without a server: computes by WebAssembly, and leaves long computations to a server if there is one.

import { Client } from "./client.js";
import type { Call, Outcome as ClientOutcome } from "./client.js";
import type {
  Answer, ConnectionOptions, FileInput, HalftoneFormat, HalftoneOptions, JobState, RequestOptions,
} from "./types.js";
import { compute, failureOf, load } from "./compute.js";
import type { Outcome, Task } from "./compute.js";

export { bitmapOf } from "./loader.mjs";

export interface LocalOptions extends ConnectionOptions {
  /** Address of a server for what WebAssembly cannot do, or not in time. */
  server?: string | URL;
  /** Longest estimated time of a local computation if there is a server; 1 by default. */
  seconds?: number;
}

/** Statuses of answers that a server may give instead: too slow here, not offered here, too large, or failed. */
const elsewhere = [202, 406, 413, 415, 500];

/** Whether this is a page or a worker of one, not Deno or Bun, whose processes would wait for idle workers. */
const isPage = "document" in globalThis || "WorkerGlobalScope" in globalThis;

type Progress = (share: number) => void;

/** What LocalClient passes through Connection to its own `fetch`. */
interface LocalInit extends RequestInit {
  progress?: Progress;
}

/** A task without the module that computes it. */
type Work = Omit<Task, "module">;

/** Returns the task of a request, whose body is a form or a file. */
async function taskOf(operation: Task["operation"], request: Request, seconds: number): Promise<Work> {
  const options = [...new URL(request.url).searchParams];
  const type = request.headers.get("Content-Type") ?? "";
  if (!type.startsWith("multipart/form-data")) return { operation, options, type, body: await request.blob(), seconds };
  let body = new Blob();
  for (const [name, value] of await request.formData()) {
    if (typeof value === "string") options.push([name, value]);
    else body = value;
  }
  return { operation, options, type: "", body, seconds };
}

function responseOf({ status, type, body, warnings, repaired }: Outcome): Response {
  const headers = new Headers({ "Content-Type": type });
  if (warnings) headers.set("X-Warnings", warnings);
  if (repaired) headers.set("X-Repaired", repaired);
  return new Response(body, { status, headers });
}

/** Computes in a worker, which ends with the computation if that is aborted. */
class LocalWorker {
  #module: Promise<WebAssembly.Module> | undefined;
  #idle: Worker[] = [];

  async compute(work: Work, progress?: Progress, signal?: AbortSignal | null): Promise<Outcome> {
    signal?.throwIfAborted();
    try {
      const task = { ...work, module: await (this.#module ??= load()) };
      signal?.throwIfAborted();
      return await (globalThis.Worker ? this.#send(task, progress, signal) : compute(task, progress));
    } catch (error) {
      signal?.throwIfAborted();
      this.#module = undefined;  // it may not have been loaded
      return failureOf(error);
    }
  }

  async #send(task: Task, progress?: Progress, signal?: AbortSignal | null): Promise<Outcome> {
    const worker = this.#idle.pop() ?? new Worker(new URL("./wasm_worker.js", import.meta.url), { type: "module" });
    const listening = new AbortController();
    try {
      const outcome = await new Promise<Outcome>((resolve, reject) => {
        signal?.addEventListener("abort", () => reject(signal.reason), listening);
        worker.addEventListener("error", (event) => reject(new Error(event.message)), listening);
        worker.addEventListener("message", ({ data }) => (data.outcome ? resolve(data.outcome) : progress?.(data.share)), listening);
        worker.postMessage(task);
      });
      if (isPage) this.#idle.push(worker);
      else worker.terminate();
      return outcome;
    } catch (error) {
      worker.terminate();
      throw error;
    } finally {
      listening.abort();
    }
  }
}

/** A Client whose requests are answered in this process. Only a server has jobs and capabilities. */
export class LocalClient extends Client {
  #worker = new LocalWorker();

  constructor({ server, seconds = 1, fetch = (...request) => globalThis.fetch(...request), ...options }: LocalOptions = {}) {
    const answer = async (url: string | URL | Request, init: LocalInit = {}) => {
      const { progress, ...sent } = init;
      if (!sent.method) return fetch(url, sent);  // a file
      const operation = new URL(String(url)).pathname.split("/").pop() as Task["operation"];
      const isJob = new Headers(sent.headers).has("Prefer");
      if (isJob || sent.method !== "POST") {
        if (server) return fetch(url, sent);
        throw new Error("only a server has jobs and capabilities");
      }
      const task = await taskOf(operation, new Request(url, sent), server ? seconds : Infinity);
      const outcome = await this.#worker.compute(task, progress, sent.signal);
      return server && elsewhere.includes(outcome.status) ? fetch(url, sent) : responseOf(outcome);
    };
    super(server ?? "http://localhost", { ...options, fetch: answer });
  }

  /** Makes a halftone of a picture. The default format is SVG. */
  override async halftone<F extends HalftoneFormat = "svg", C extends Call = {}>(
    picture: FileInput, options: HalftoneOptions & { format?: F } = {}, call?: C): ClientOutcome<Answer<"/halftone", F>, C> {
    return super.halftone(picture, { format: "svg" as F, ...options }, call);
  }

  /** Reports the progress of local computations. */
  override async request(method: string, path: string, { onProgress, ...options }: RequestOptions = {}): Promise<Response> {
    const progress = onProgress && ((share: number) => {
      onProgress({ status: "running", progress: share } as JobState);
    });
    return super.request(method, path, { ...options, progress } as RequestOptions);
  }
}

const client = new LocalClient();

/** Spreads points, as LocalClient does without a server. */
export const sample: LocalClient["sample"] = (request, call) => client.sample(request, call);

/** Makes a halftone, as LocalClient does without a server. */
export const halftone: LocalClient["halftone"] = (picture, options, call) => client.halftone(picture, options, call);

/** Chooses among given points, as LocalClient does without a server. */
export const choose: LocalClient["choose"] = (request, call) => client.choose(request, call);
