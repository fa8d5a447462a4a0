// SPDX-License-Identifier: GPL-3.0-or-later
// Connection to ccdt-server for the page, the element and the npm package, in browsers and in Node.js 18 or later. When
// `server/page/package/pack` makes the package, it checks the types in this file.

/** @typedef {import("./types.js").ConnectionOptions} ConnectionOptions */
/** @typedef {import("./types.js").RequestOptions} RequestOptions */
/** @typedef {import("./types.js").JobState} JobState */
/** @typedef {import("./types.js").OptionError} OptionError */

const busy = [429, 503];  // statuses after which a request is repeated
const maxDelay = 60;  // s; if the server asks for a longer delay, the request fails
const pollInterval = 1;  // s between two requests for the state of a job
const maxMisses = 30;  // successive failures to reach the server while a job is polled
const maxSilence = 40;  // s without an event; the server sends one at least every 15 s
const objects = ["application/json", "application/geo+json"];
const texts = /^text\/|\+xml$|postscript$|hpgl$|dxf$|ndjson$|json-seq$/;

/** An error response of the server: status, message, and one error for each option at fault. Status 0: no response. */
export class CcdtError extends Error {
  /**
   * @param {number} status
   * @param {string} detail  text that describes all errors
   * @param {OptionError[]} [errors]
   * @param {unknown} [cause]
   */
  constructor(status, detail, errors = [], cause) {
    super(detail, { cause });
    this.name = "CcdtError";
    this.status = status;
    this.detail = detail;
    /** @type {OptionError[]} */
    this.errors = errors;
  }
}

/** @param {Response} response */
async function errorOf(response) {
  const isProblem = response.headers.get("Content-Type")?.startsWith("application/problem+json");
  const { detail, errors } = isProblem ? await response.json() : { detail: `The server answered with status ${response.status}` };
  return new CcdtError(response.status, detail, errors);
}

/**
 * Returns the number of seconds after which a request may be repeated.
 * @param {Response} response
 */
function delayOf(response) {
  const after = response.headers.get("Retry-After") ?? "1";
  return Number.isNaN(Number(after)) ? (Date.parse(after) - Date.now()) / 1000 : Number(after);
}

/**
 * @param {number} seconds
 * @param {AbortSignal | null} [signal]  ends the wait with an exception
 */
async function sleep(seconds, signal) {
  signal?.throwIfAborted();
  await new Promise((resume) => {
    const timer = setTimeout(end, 1000 * seconds);
    function end() {
      clearTimeout(timer);
      signal?.removeEventListener("abort", end);
      resume(null);
    }
    signal?.addEventListener("abort", end);
  });
  signal?.throwIfAborted();
}

/**
 * Returns the content of an answer, depending on its media type: an object, a string or a Blob.
 * @param {Response} response
 */
export function contentOf(response) {
  const [type] = (response.headers.get("Content-Type") ?? "").split(";");
  if (objects.includes(type)) return response.json();
  return texts.test(type) ? response.text() : response.blob();
}

/**
 * Yields the states of a job from its server-sent events, until the stream is silent for `maxSilence`.
 * @param {Connection} connection
 * @param {string} id
 * @param {AbortSignal | null} [signal]
 * @returns {AsyncGenerator<JobState>}
 */
async function* eventsOf(connection, id, signal) {
  const stop = new AbortController();
  const abort = () => stop.abort();
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  const listen = () => {
    clearTimeout(timer);
    timer = setTimeout(abort, 1000 * maxSilence);
  };
  signal?.addEventListener("abort", abort);
  try {
    listen();
    const { body } = await connection.request("GET", `jobs/${id}/events`, { signal: stop.signal, retries: 0 });
    if (!body) return;
    const reader = body.pipeThrough(new TextDecoderStream()).getReader();
    for (let rest = ""; ;) {
      const { value, done } = await reader.read();
      if (done) return;
      listen();
      const events = (rest + value).split("\n\n");
      rest = events.pop() ?? "";
      for (const event of events) {
        const data = event.match(/^data: (.*)$/m);
        if (data) yield JSON.parse(data[1]);
      }
    }
  } finally {
    clearTimeout(timer);
    signal?.removeEventListener("abort", abort);
    abort();
  }
}

/**
 * Yields the states of a job by polling. Tolerates up to `maxMisses` successive failures to reach the server.
 * @param {Connection} connection
 * @param {string} id
 * @param {AbortSignal | null} [signal]
 * @returns {AsyncGenerator<JobState>}
 */
async function* pollsOf(connection, id, signal) {
  for (let misses = 0; ; await sleep(pollInterval, signal)) {
    try {
      yield (await connection.request("GET", `jobs/${id}`, { signal })).json();
      misses = 0;
    } catch (error) {
      if (!(error instanceof CcdtError) || error.status !== 0 || ++misses > maxMisses) throw error;
    }
  }
}

/**
 * A computation on the server. Its states can be iterated: `for await (const { progress } of job)`.
 * @template T  type of the result
 */
export class Job {
  #connection;
  #hasEnded = false;

  /**
   * @param {Connection} connection
   * @param {string} id
   */
  constructor(connection, id) {
    this.#connection = connection;
    this.id = id;
  }

  /**
   * Yields the state of the job at once, after each step and at its end, from its event stream or, after a loss of the
   * stream, by polling. A signal ends the iteration, but not the job.
   * @param {{ signal?: AbortSignal | null }} [options]
   * @returns {AsyncGenerator<JobState, void, undefined>}
   */
  async *states({ signal = this.#connection.signal } = {}) {
    for (const statesOf of [eventsOf, pollsOf]) {
      signal?.throwIfAborted();
      try {
        for await (const state of statesOf(this.#connection, this.id, signal)) {
          this.#hasEnded = state.finished !== null;
          yield state;
          if (this.#hasEnded) return;
        }
      } catch (error) {
        signal?.throwIfAborted();
        if (statesOf === pollsOf) throw error;
      }
    }
  }

  /** @returns {AsyncGenerator<JobState, void, undefined>} */
  [Symbol.asyncIterator]() {
    return this.states();
  }

  /**
   * Waits for the end of the job, and returns the response with its result. Throws a CcdtError if the job has failed or
   * was cancelled. A signal ends the wait, but not the job.
   * @param {{ signal?: AbortSignal | null }} [options]
   */
  async response(options) {
    if (!this.#hasEnded) for await (const _ of this.states(options));
    return this.#connection.request("GET", `jobs/${this.id}/result`, options);
  }

  /**
   * Returns the content of `response`.
   * @param {{ signal?: AbortSignal | null }} [options]
   * @returns {Promise<T>}
   */
  async result(options) {
    return contentOf(await this.response(options));
  }

  /** Cancels the job or, if it has ended, deletes it. A browser does so even if the page is closed. */
  async delete() {
    await this.#connection.request("DELETE", `jobs/${this.id}`, { signal: null, keepalive: true });
  }
}

/** Sends requests to a server. The members `key`, `fetch`, `retries` and `signal` may change between requests. */
export class Connection {
  #url;
  /** @type {Set<Job<unknown>>} */
  #jobs = new Set();

  /**
   * @param {string | URL} url  address of the server; in browsers, it may be relative to the page
   * @param {ConnectionOptions} [options]
   */
  constructor(url, { key, fetch = (...request) => globalThis.fetch(...request), retries = 3, signal } = {}) {
    this.#url = new URL(url, globalThis.location?.href);
    if (!this.#url.pathname.endsWith("/")) this.#url.pathname += "/";
    this.key = key;
    this.fetch = fetch;
    this.retries = retries;
    this.signal = signal;
  }

  /**
   * Sends a request and returns the response, also if its status is 304. Throws a CcdtError if the status is an error.
   * If the server is busy, repeats the request after the delay that the server asks for.
   * @param {string} method
   * @param {string} path  relative to the address of the server
   * @param {RequestOptions} [options]
   * @returns {Promise<Response>}
   */
  async request(method, path, { onProgress, signal = this.signal, ...options } = {}) {
    if (!onProgress) return this.#send(method, path, { signal, ...options }, signal);
    const job = await this.start(method, path, { signal, ...options });
    if (job instanceof Response) return job;
    this.#jobs.add(job);
    try {
      for await (const state of job.states({ signal })) onProgress(state);
      const response = await job.response({ signal });
      return new Response(await response.blob(), { headers: response.headers });
    } finally {
      this.#jobs.delete(job);
      job.delete().catch(() => {});
    }
  }

  /**
   * Starts a job. A signal ends the wait for a busy server, but not the request itself, because a job can only be
   * deleted when the answer has named it.
   * @param {string} method
   * @param {string} path
   * @param {RequestOptions} [options]
   * @returns {Promise<Job<any> | Response>}  a response if its status is 304
   */
  async start(method, path, { signal = this.signal, headers, ...options } = {}) {
    const response = await this.#send(method, path, { ...options, headers: { ...headers, Prefer: "respond-async" } }, signal);
    return response.status === 202 ? new Job(this, (await response.json()).id) : response;
  }

  /**
   * Returns a job that was started earlier, perhaps by another client.
   * @param {string} id
   * @returns {Job<unknown>}
   */
  job(id) {
    return new Job(this, id);
  }

  /** Cancels the jobs of all requests with `onProgress`. A browser does so even if the page is being closed. */
  cancelJobs() {
    for (const job of this.#jobs) job.delete().catch(() => {});
    this.#jobs.clear();
  }

  /**
   * @param {string} method
   * @param {string} path
   * @param {RequestOptions} options
   * @param {AbortSignal | null} [waiting]  ends the wait for a busy server
   */
  async #send(method, path, { type, headers, retries = this.retries, ...options }, waiting) {
    const url = new URL(this.#url + path.replace(/^\//, ""));  // always the server that the key is for
    const sent = new Headers(headers);
    if (type) sent.set("Content-Type", type);
    if (this.key) sent.set("Authorization", `Bearer ${this.key}`);
    for (; ; --retries) {
      waiting?.throwIfAborted();
      const response = await this.#reach(url, /** @type {RequestInit} */ ({ method, headers: sent, ...options }));
      if (response.ok || response.status === 304) return response;
      const delay = delayOf(response);
      if (retries <= 0 || !busy.includes(response.status) || !(delay <= maxDelay)) throw await errorOf(response);
      await response.body?.cancel();
      await sleep(delay, waiting);
    }
  }

  /**
   * @param {URL} url
   * @param {RequestInit} options
   */
  async #reach(url, options) {
    const { fetch } = this;
    try {
      return await fetch(url, options);
    } catch (error) {
      options.signal?.throwIfAborted();
      throw new CcdtError(0, "The server cannot be reached", [], error);
    }
  }
}
