// SPDX-License-Identifier: GPL-3.0-or-later
// Sends requests to the server of the page.

import { Connection } from "./connection.js";

const keyName = "ccdt-key";

/** Sends requests at once or never, because the user may change the settings. */
export const client = new Connection("/", { key: sessionStorage.getItem(keyName), retries: 0 });

/** Whether the user has entered an API key in this session. */
export const hasKey = () => client.key !== null;
export function setKey(key) {
  sessionStorage.setItem(keyName, key);
  client.key = key;
}

/** Sends a request and returns the response. Throws a CcdtError if the status is an error. */
export async function ask(method, path, options) {
  try {
    return await client.request(method, path, options);
  } catch (error) {
    if (error.status === 401) document.dispatchEvent(new CustomEvent("keyneeded", { detail: error.message }));
    throw error;
  }
}

/** Formats, options, methods and limits of the server: the answer of `/capabilities`. */
export const capabilities = await (await ask("GET", "/capabilities")).json();

export const post = (path, body, options) => ask("POST", path, { body, ...options });

export const postJson = async (path, body, signal) =>
  (await post(path, JSON.stringify(body), { type: "application/json", signal })).json();

/**
 * Runs only the newest of several tasks. A new task cancels the running one. However, a draft waits for a running
 * draft, so that results appear while a slider moves.
 */
export class Newest {
  #running = null;
  #next = null;

  constructor({ started, ended }) {
    this.started = started;
    this.ended = ended;
  }

  /** Starts a task. A draft waits if a draft is running. */
  start(work, draft = false) {
    this.#next = null;
    if (this.#running?.draft && draft) {
      this.#next = work;
      return;
    }
    this.#running?.cancel.abort();
    this.#run(work, draft);
  }

  /** Cancels all tasks, and reports the end. */
  cancel() {
    this.abandon();
    this.ended(null);
  }

  /** Cancels all tasks without reporting the end, because another task will follow. */
  abandon() {
    this.#next = null;
    this.#running?.cancel.abort();
    this.#running = null;
  }

  async #run(work, draft) {
    const run = { draft, cancel: new AbortController() };
    this.#running = run;
    this.started(draft);
    let problem = null;
    try {
      await work(run.cancel.signal);
    } catch (error) {
      if (error.name !== "AbortError") problem = error;
    }
    if (this.#running !== run) return;
    this.#running = null;
    const next = this.#next;
    this.#next = null;
    if (next) this.#run(next, true);
    else this.ended(problem);
  }
}
