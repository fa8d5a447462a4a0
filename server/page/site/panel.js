// SPDX-License-Identifier: GPL-3.0-or-later
// Base class of the panels: progress, status and errors.

import { hasKey, Newest } from "./api.js";
import { make, save } from "./dom.js";
import { isPicture } from "./file_kind.js";

const copiedFor = 2000;  // ms for which a button tells that it has copied

/** Returns the name of the file in an answer: the given one, or for several files that of their archive. */
export const fileOf = ({ headers }, name) =>
  (headers.get("Content-Type") === "application/zip" ? name.replace(/[^.]+$/, "zip") : name);

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

  /** Applies settings that `state` returned. Afterwards, `activate` updates the shown results. */
  async restore() {}

  /** Returns the settings that differ from their initial values, as texts by name. */
  state() {
    return {};
  }

  /** Called when the panel becomes visible. Requests missing results. */
  activate() {}

  /** Shows the result for files of the user, here or in the panel that the first one is for. */
  take(files) {
    this.#open(files, isPicture(files[0]) ? "halftone" : "sample");
  }

  #open(files, panel) {
    this.element.dispatchEvent(new CustomEvent("elsewhere", { detail: { files, panel } }));
  }

  /** Offers to open files that are for another panel there. Keeps the last result. */
  offerElsewhere(files, kind, panel) {
    this.showProblem({ message: `${files[0].name} is a ${kind}. ` });
    const button = make("button", { type: "button", textContent: `Open it in ${panel.title}` });
    button.addEventListener("click", () => {
      this.show(null);
      this.#open(files, panel.name);
    });
    this.error.append(button);
  }

  /** Reports that settings have changed. If `isStep`, the change becomes an entry in the history of the browser. */
  note(isStep = false) {
    this.element.dispatchEvent(new CustomEvent("settings", { detail: { isStep } }));
  }

  /** Shows the progress of a job; null hides it. */
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

  /** Shows a problem as a message, and its errors beside the fields at fault. Null clears both. */
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
   * Waits until a file that the user has chosen is loaded, and returns it. Returns null if the user has made another
   * choice in the meantime, so that a slow answer does not replace a newer choice.
   */
  async loadNewest(loading) {
    this.element.dataset.state = "busy";
    const number = ++this.#loads;
    const [outcome] = await Promise.allSettled([loading]);
    if (number !== this.#loads) return null;
    if (outcome.status === "rejected") throw outcome.reason;
    return outcome.value;
  }

  /** Ignores files that are still being loaded, because the user has made another choice. */
  abandonLoads() {
    ++this.#loads;
  }

  /** Shows a problem that does not concern the current settings. Keeps the last result. */
  showProblem({ message }) {
    this.element.dataset.state = "failed";
    this.error.textContent = message;
  }

  /** Starts a task; see Newest. Tasks are drafts while a slider moves. */
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

  /** Adds a button that copies a PNG, which `ask(signal)` returns. Browsers allow this over HTTPS and on the same machine. */
  addCopy(ask) {
    if (!navigator.clipboard?.write) return;
    const button = make("button", { type: "button", className: "copy-picture", textContent: "Copy", attributes: { "aria-label": "Copy the picture" } });
    button.addEventListener("click", () => this.start(async (signal) => {
      await navigator.clipboard.write([new ClipboardItem({ "image/png": ask(signal).then((response) => response.blob()) })]);
      button.textContent = "Copied";
      setTimeout(() => { button.textContent = "Copy"; }, copiedFor);
    }));
    this.find(".download").prepend(button);
  }

  /** Adds a button that saves the answer of `ask(format, signal)`, and a menu of formats. */
  addDownload(ask) {
    this.format = make("select", { attributes: { "aria-label": "Format" } });
    this.find(".download").append(this.downloadButton(async (signal) => {
      const { value: format, selectedOptions: [{ dataset }] } = this.format;
      const response = await ask(format, signal);
      return { response, name: fileOf(response, dataset.file) };
    }), this.format);
  }

  /**
   * Fills the menu of formats, JSON last, and keeps the selected format if it is still offered.
   * @param given  names of the options that are set; formats that need other options are omitted. Paper gives a width
   */
  offerDownloads(formats, file, given = []) {
    const { value } = this.format;
    const isGiven = (name) => given.includes(name) || (name === "width_mm" && given.includes("paper"));
    const offered = formats.filter(({ needs = [] }) => needs.every(isGiven))
      .sort((a, b) => (a.name === "json") - (b.name === "json"));
    const options = offered.map(({ name, title, extension }) => {
      const option = new Option(title, name, false, name === value);
      option.dataset.file = `${file}.${extension}`;
      return option;
    });
    this.format.replaceChildren(...options);
  }
}
