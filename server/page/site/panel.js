// SPDX-License-Identifier: GPL-3.0-or-later
// Base class of the panels: progress, status and errors.

import { hasKey, Newest } from "./api.js";
import { make, save } from "./dom.js";

export class Panel {
  #loads = 0;

  constructor(element) {
    this.element = element;
    this.progress = element.querySelector("progress");
    this.status = element.querySelector(".status");
    this.error = element.querySelector(".general");
    this.job = element.querySelector(".job");
    this.newest = new Newest({
      started: () => { this.progress.hidden = false; this.showJob(null); },
      ended: (problem) => { this.progress.hidden = true; this.showJob(null); this.show(problem); },
    });
    this.job.querySelector("button").addEventListener("click", () => this.#cancel());
  }

  #cancel() {
    this.newest.cancel();
    this.status.textContent = "Cancelled. The last result is shown";
  }

  /** Applies settings that `state` returned. `activate` then updates what is shown. */
  async restore() {}

  /** Returns the settings that differ from their initial values, as texts by name. */
  state() {
    return {};
  }

  /** Called when the panel becomes visible. Requests what is missing. */
  activate() {}

  /** Reports that settings have changed. A step becomes an entry in the history of the browser. */
  note(isStep = false) {
    this.element.dispatchEvent(new CustomEvent("settings", { detail: { isStep } }));
  }

  /** Shows the state of a job, or hides it if the state is null. */
  showJob = (state) => {
    this.job.hidden = state === null;
    if (!state) return this.progress.removeAttribute("value");
    const percent = Math.round(100 * state.progress);
    this.progress.value = percent;
    this.status.textContent = "";
    this.job.querySelector("output").textContent = state.status === "queued" ? "waiting" : `${percent} %`;
  };

  find(selector) {
    return this.element.querySelector(selector);
  }

  /** Shows a problem as a message and beside the fields that it is about. Null clears the message and these fields. */
  show(problem) {
    this.element.dataset.state = problem ? "failed" : "done";
    this.place(problem?.errors ?? []);
    const isShownElsewhere = !problem || (problem.status === 401 && !hasKey());
    this.error.textContent = isShownElsewhere ? "" : problem.message;
    if (!problem) return;
    this.status.textContent = "";
    this.forget();
  }

  /** Shows each error beside its field, and clears the errors of all other fields. */
  place() {}

  forget() {}

  /**
   * Waits until the user's choice is loaded. Returns null if the user has chosen something else in the meantime, so
   * that a slow answer does not replace a newer choice.
   */
  async loadNewest(loading) {
    this.element.dataset.state = "busy";
    const number = ++this.#loads;
    const [outcome] = await Promise.allSettled([loading]);
    if (number !== this.#loads) return null;
    if (outcome.status === "rejected") throw outcome.reason;
    return outcome.value;
  }

  /** Ignores what is still being loaded, because the user has chosen something else. */
  abandonLoads() {
    ++this.#loads;
  }

  /** Shows a problem and keeps the last result, because the problem is not about the current settings. */
  showProblem({ message }) {
    this.element.dataset.state = "failed";
    this.error.textContent = message;
  }

  /** Starts a task. It is a draft while an input moves. */
  start(work, draft = false) {
    this.element.dataset.state = "busy";
    this.newest.start(work, draft);
  }

  /** Creates a button that saves a file, which `ask(signal)` returns as {response, name}. */
  downloadButton(ask) {
    const button = make("button", { type: "button", className: "primary", textContent: "Download" });
    button.addEventListener("click", () => this.start(async (signal) => {
      const { response, name } = await ask(signal);
      save(await response.blob(), name);
    }));
    return button;
  }

  /** Adds a button that saves the answer of `ask(format, signal)`, and a menu of formats. */
  addDownload(ask) {
    this.format = make("select", { attributes: { "aria-label": "Format" } });
    this.find(".download").append(this.downloadButton(async (signal) => {
      const { value: format, selectedOptions: [{ dataset }] } = this.format;
      return { response: await ask(format, signal), name: dataset.file };
    }), this.format);
  }

  /**
   * Offers formats, and keeps the selected one if it is among them.
   * @param given  names of the options that are set; formats that need others are left out
   */
  offerDownloads(formats, file, given = []) {
    const { value } = this.format;
    const offered = formats.filter(({ needs = [] }) => needs.every((name) => given.includes(name)));
    const options = offered.map(({ name, title, extension }) => {
      const option = new Option(title, name, false, name === value);
      option.dataset.file = `${file}.${extension}`;
      return option;
    });
    this.format.replaceChildren(...options);
  }
}
