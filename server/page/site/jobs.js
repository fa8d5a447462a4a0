// SPDX-License-Identifier: GPL-3.0-or-later
// Sends long requests as jobs, so that the page can show their progress.

import { ask, capabilities, post } from "./api.js";

/** Estimated duration in seconds above which a request is sent as a job. */
const maxSynchronousSeconds = 0.6;

/** Statuses of a server that has no capacity for a job or has lost it. Synchronous requests may still succeed. */
const refusals = [404, 410, 413, 429, 503, 507];

const pause = 1000;  // ms between two requests for the state of a job
const maxMisses = 30;
const maxSilence = 40000;  // ms without an event; the server sends one at least every 15 s
const startedJobs = new Set();

/** Whether a request takes long enough to be sent as a job. Drafts, which have one iteration, do not. */
function isLong({ sites, method: name, quality = "standard", iterations = 5 }) {
  const { methods } = capabilities.sample;
  const method = methods.find((one) => one.name === name) ?? methods[0];
  return iterations > 1 && sites * method.seconds_per_site[quality] > maxSynchronousSeconds;
}

/** Deletes a job, which also cancels it. The browser sends the request even if the page is closed. */
function remove(job) {
  startedJobs.delete(job);
  ask("DELETE", job, { keepalive: true }).catch(() => {});
}
addEventListener("pagehide", () => startedJobs.forEach(remove));

/** Yields the states of a job from its server-sent events, until the stream is silent for `maxSilence`. */
async function* eventsOf(job, signal) {
  const silence = new AbortController();
  let timer = null;
  const listen = () => {
    clearTimeout(timer);
    timer = setTimeout(() => silence.abort(), maxSilence);
  };
  try {
    listen();
    const { body } = await ask("GET", `${job}/events`, { signal: AbortSignal.any([signal, silence.signal]) });
    const reader = body.pipeThrough(new TextDecoderStream()).getReader();
    for (let rest = ""; ;) {
      const { value, done } = await reader.read();
      if (done) return;
      listen();
      const events = (rest + value).split("\n\n");
      rest = events.pop();
      for (const event of events) {
        const data = event.match(/^data: (.*)$/m);
        if (data) yield JSON.parse(data[1]);
      }
    }
  } finally {
    clearTimeout(timer);
    silence.abort();
  }
}

/** Yields the states of a job by polling. Tolerates up to `maxMisses` successive failures to reach the server. */
async function* statesOf(job, signal) {
  for (let misses = 0; ; await new Promise((resume) => setTimeout(resume, pause))) {
    signal.throwIfAborted();
    try {
      yield (await ask("GET", job, { signal })).json();
      misses = 0;
    } catch (error) {
      if (error.status !== 0 || ++misses > maxMisses) throw error;
    }
  }
}

/** Reports the states of a job until its end, from its event stream or, after a loss of the stream, by polling. */
async function follow(job, signal, onProgress) {
  const hasEnded = async (states) => {
    for await (const state of states) {
      signal.throwIfAborted();
      onProgress(state);
      if (state.finished) return true;
    }
    return false;
  };
  try {
    if (await hasEnded(eventsOf(job, signal))) return;
  } catch {
    signal.throwIfAborted();
  }
  await hasEnded(statesOf(job, signal));
}

/** Starts a job. Takes no abort signal, because a job can only be deleted when the answer has named it. */
async function begin(path, body, type) {
  const response = await post(path, body, { type, prefer: "respond-async" });
  if (response.status !== 202) return { response };
  const job = response.headers.get("Location");
  startedJobs.add(job);
  return { job };
}

async function postAsJob(path, body, { type, signal, onProgress }) {
  const { response, job } = await begin(path, body, type);
  if (response) return response;
  try {
    await follow(job, signal, onProgress);
    const result = await ask("GET", `${job}/result`, { signal });
    return new Response(await result.blob(), { headers: result.headers });
  } finally {
    remove(job);
  }
}

/**
 * Sends a POST request, as a job if the answer is expected to take long.
 *
 * @param options     options of the request, for the estimate of its duration
 * @param onProgress  called with each reported state of the job, and finally with null
 */
export async function postPatiently(path, body, options, { type, signal, onProgress }) {
  if (isLong(options)) {
    try {
      return await postAsJob(path, body, { type, signal, onProgress });
    } catch (error) {
      signal.throwIfAborted();
      if (!refusals.includes(error.status)) throw error;
    } finally {
      if (!signal.aborted) onProgress(null);
    }
  }
  return post(path, body, { type, signal });
}
