// SPDX-License-Identifier: GPL-3.0-or-later
// What the three panels have in common: progress, status, errors.

import { hasKey, Newest } from "./api.js";
import { make, save } from "./dom.js";

export class Panel {
  constructor(element) {
    this.element = element;
    this.progress = element.querySelector("progress");
    this.status = element.querySelector(".status");
    this.error = element.querySelector(".general");
    this.job = element.querySelector(".job");
    this.newest = new Newest({
      started: () => { this.progress.hidden = false; this.tell(null); },
      ended: (problem) => { this.progress.hidden = true; this.tell(null); this.show(problem); },
    });
    this.job.querySelector("button").addEventListener("click", () => this.#cancel());
  }

  #cancel() {
    this.newest.cancel();
    this.status.textContent = "Cancelled: what is shown was made before";
  }

  /** Puts settings, as `state` tells them, into the panel; what is shown is made anew once it is looked at. */
  async restore() {}

  /** Its settings that are not as they were at first, by name, as texts. */
  state() {
    return {};
  }

  /** The panel is looked at: what is not there yet is made. */
  look() {}

  /** Tells that settings have changed; a step is one to go back from. */
  note(isStep = false) {
    this.element.dispatchEvent(new CustomEvent("settings", { detail: { isStep } }));
  }

  /** Shows where a job stands; null: what is under way is none. */
  tell = (state) => {
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

  /** Shows a problem, or that there is none: where one looks, and at the fields that it is about. */
  show(problem) {
    this.element.dataset.state = problem ? "failed" : "done";
    this.place(problem?.errors ?? []);
    const isToldElsewhere = !problem || (problem.status === 401 && !hasKey());
    this.error.textContent = isToldElsewhere ? "" : problem.message;
    if (!problem) return;
    this.status.textContent = "";
    this.forget();
  }

  /** Shows each error at the field that it is about, and of no other field any. */
  place() {}

  /** Lets go of what was made before. */
  forget() {}

  /** Asks for work; a draft while something moves. */
  wish(work, draft = false) {
    this.element.dataset.state = "busy";
    this.newest.wish(work, draft);
  }

  /** Adds a button that saves what `ask(format, signal)` answers, and a choice among the formats that are offered. */
  addDownload(ask) {
    this.format = make("select", { attributes: { "aria-label": "Format" } });
    const button = make("button", { type: "button", className: "primary", textContent: "Download" });
    button.addEventListener("click", () => this.wish(async (signal) => {
      const { value: name, selectedOptions: [{ dataset }] } = this.format;
      save(await (await ask(name, signal)).blob(), dataset.file);
    }));
    this.find(".download").append(button, this.format);
  }

  /**
   * Offers formats, and keeps the one that is chosen if it is among them.
   * @param given  names of options that are set: a format is offered if it needs no others
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
