// SPDX-License-Identifier: GPL-3.0-or-later
// Sends long requests as jobs, so that the page can show their progress.

import { capabilities, client, post } from "./api.js";

/** Estimated duration in seconds above which a request is sent as a job. */
const maxSynchronousSeconds = 0.6;

/** Statuses of a server that has no capacity for a job or has lost it. Synchronous requests may still succeed. */
const refusals = [404, 410, 413, 429, 503, 507];

/** Whether a request takes long enough to be sent as a job. Drafts, which have one iteration, do not. */
function isLong({ sites, method: name, quality = "standard", iterations = 5 }) {
  const { methods } = capabilities.sample;
  const method = methods.find((one) => one.name === name) ?? methods[0];
  return iterations > 1 && sites * method.seconds_per_site[quality] > maxSynchronousSeconds;
}

addEventListener("pagehide", () => client.cancelJobs());

/**
 * Sends a POST request, as a job if the answer is expected to take long.
 *
 * @param options     options of the request, for the estimate of its duration
 * @param onProgress  called with each reported state of the job, and finally with null
 */
export async function postPatiently(path, body, options, { type, signal, retries, onProgress }) {
  if (isLong(options)) {
    try {
      return await post(path, body, { type, signal, retries, onProgress });
    } catch (error) {
      signal.throwIfAborted();
      if (!refusals.includes(error.status)) throw error;
    } finally {
      if (!signal.aborted) onProgress(null);
    }
  }
  return post(path, body, { type, signal, retries });
}
