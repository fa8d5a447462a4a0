// SPDX-License-Identifier: GPL-3.0-or-later
// Long requests, asked for as jobs: how far they are can be told.

import { ask, capabilities, post } from "./api.js";

/** Seconds of placing dots, by the server's estimate, from which on progress is shown. */
const patience = 0.6;

/** Whoever has no room for a job, or lost it, may still answer at once. */
const refusals = [404, 410, 413, 429, 503, 507];

const pause = 1000;  // ms between questions
const mostMisses = 30;
const longestSilence = 40000;  // ms; the server says something every 15 s
const begun = new Set();

/** Drafts, of one iteration, are not. */
function isLong({ sites, method: name, quality = "standard", iterations = 5 }) {
  const { methods } = capabilities.sample;
  const method = methods.find((one) => one.name === name) ?? methods[0];
  return iterations > 1 && sites * method.seconds_per_site[quality] > patience;
}

/** Ends a job, or lets the server forget it; also while the page is being left. */
function remove(job) {
  begun.delete(job);
  ask("DELETE", job, { keepalive: true }).catch(() => {});
}
addEventListener("pagehide", () => begun.forEach(remove));

/** What a job's server-sent events say, one after the other. A stream that is silent for too long is lost. */
async function* eventsOf(job, signal) {
  const silence = new AbortController();
  let timer = null;
  const listen = () => {
    clearTimeout(timer);
    timer = setTimeout(() => silence.abort(), longestSilence);
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

/** Asks again and again where a job stands. The server may be out of reach for a while. */
async function* statesOf(job, signal) {
  for (let misses = 0; ; await new Promise((resume) => setTimeout(resume, pause))) {
    signal.throwIfAborted();
    try {
      yield (await ask("GET", job, { signal })).json();
      misses = 0;
    } catch (error) {
      if (error.status !== 0 || ++misses > mostMisses) throw error;
    }
  }
}

/** Tells where a job stands until it has ended: by its events, or once they are lost by asking. */
async function follow(job, signal, told) {
  const hasEnded = async (states) => {
    for await (const state of states) {
      signal.throwIfAborted();
      told(state);
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

/** Waits for the answer even if it is not wanted any more: it names the job, which is to be ended then. */
async function begin(path, body, type) {
  const response = await post(path, body, { type, prefer: "respond-async" });
  if (response.status !== 202) return { response };
  const job = response.headers.get("Location");
  begun.add(job);
  return { job };
}

async function postAsJob(path, body, { type, signal, told }) {
  const { response, job } = await begin(path, body, type);
  if (response) return response;
  try {
    await follow(job, signal, told);
    const result = await ask("GET", `${job}/result`, { signal });
    return new Response(await result.blob(), { headers: result.headers });
  } finally {
    remove(job);
  }
}

/**
 * Posts, as a job if that will take long.
 *
 * @param options  what the request asks for
 * @param told     called with where the job stands, as the server says it, and in the end with null
 */
export async function postPatiently(path, body, options, { type, signal, told }) {
  if (isLong(options)) {
    try {
      return await postAsJob(path, body, { type, signal, told });
    } catch (error) {
      signal.throwIfAborted();
      if (!refusals.includes(error.status)) throw error;
    } finally {
      if (!signal.aborted) told(null);
    }
  }
  return post(path, body, { type, signal });
}
