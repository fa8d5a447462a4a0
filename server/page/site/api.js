// SPDX-License-Identifier: GPL-3.0-or-later
// Sends requests to the server of the page.

const keyName = "ccdt-key";

/** An error response of the server: status, message, and one error for each option at fault. Status 0: no response. */
export class Problem extends Error {
  constructor(status, detail, errors = []) {
    super(detail);
    this.status = status;
    this.errors = errors;
  }
}

/** Whether the user has entered an API key in this session. */
export const hasKey = () => sessionStorage.getItem(keyName) !== null;
export const setKey = (key) => sessionStorage.setItem(keyName, key);

function headers({ type, prefer }) {
  const list = {};
  if (type) list["Content-Type"] = type;
  if (prefer) list.Prefer = prefer;
  if (hasKey()) list.Authorization = `Bearer ${sessionStorage.getItem(keyName)}`;
  return list;
}

async function problemOf(response) {
  const isProblem = response.headers.get("Content-Type")?.startsWith("application/problem+json");
  const problem = isProblem ? await response.json() : { detail: `The server answered with status ${response.status}` };
  if (response.status === 401) document.dispatchEvent(new CustomEvent("keyneeded", { detail: problem.detail }));
  return new Problem(response.status, problem.detail, problem.errors);
}

/** Sends a request and returns the response. Throws a Problem if the status is an error. */
export async function ask(method, path, { body, signal, keepalive, ...forHeaders } = {}) {
  let response;
  try {
    response = await fetch(path, { method, body, signal, keepalive, headers: headers(forHeaders) });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Problem(0, "The server cannot be reached");
  }
  if (!response.ok) throw await problemOf(response);
  return response;
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
