// SPDX-License-Identifier: GPL-3.0-or-later
// Base class of the panels that turn a picture into something else: the choice of the picture, settings and presets.

import { ask } from "./api.js";
import { make, save } from "./dom.js";
import { isShape } from "./file_kind.js";
import { lastOfVisit, lastOwn, OwnThumbs, ownPicturesOf, rememberOwn } from "./own_pictures.js";
import { Panel } from "./panel.js";

const ownPicture = "own";  // name in the address for a picture of the user, which the address cannot hold

/** Repetitions of a request for one of several pictures while the server is busy. */
export const batchRetries = 5;

const samplePath = (name) => `/assets/samples/${name}`;

/**
 * Loads a picture that comes with the page: {name, path, blob}. A picture of the user has no path. Once a picture is
 * chosen, its `original` is the decoded bitmap, or null if the browser cannot decode it.
 */
const sample = async (name) => ({ name, path: samplePath(name), blob: await (await ask("GET", samplePath(name))).blob() });

/** Returns the last picture of the user, or else a sample. */
const lastOwnOr = async (instead) => await lastOwn() ?? { ...await sample(instead), isInstead: true };

/** Returns the warnings of an answer. */
export const warningsOf = (response) => JSON.parse(response.headers.get("X-Warnings") ?? "[]").map(({ detail }) => detail);

/** Returns the decoded picture of an answer. */
export async function canvasOf(response) {
  const bitmap = await createImageBitmap(await response.blob());
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  canvas.getContext("2d", { willReadFrequently: true }).drawImage(bitmap, 0, 0);
  return canvas;
}

/**
 * Subclasses provide
 * - `parts`: the fields
 * - `offerFields()`: shows the fields that have a meaning with the current settings
 * - `showRequest()`: shows the request as code
 * - `task(draft)`: returns a task that sends the request and shows its result
 * - `resultFor(picture, signal)`: returns {response, extension}, the file for another picture with the same settings
 * - `shown` and `showResult(shown)`: what is shown; it has a `status` once there is a result
 */
export class PicturePanel extends Panel {
  picture = null;
  #before = null;  // {picture, shown} from before the choice of a picture that the server has not read yet
  #isStale = true;

  /** @param firstSample  name of the picture that the panel begins with */
  constructor(element, presets, firstSample = "astronaut.jpg") {
    super(element);
    this.firstSample = firstSample;
    this.find(".picture").append(document.getElementById("picture").content.cloneNode(true));
    this.#offerPresets(presets);
    this.#listenForPictures();
    element.addEventListener("autolevels", () => this.#setLevels());
  }

  /** Sets the levels for the picture. Does nothing if the browser cannot decode it. */
  async #setLevels() {
    if (!this.picture?.original) return;
    const { levelsOf } = await import("./levels.js");
    this.fields.put("levels", levelsOf(this.picture.original));
    this.refresh();
  }

  state() {
    const { path, name } = this.picture ?? { path: "", name: this.firstSample };
    const picture = path === undefined ? ownPicture : name;
    return { ...(picture !== this.firstSample && { picture }), ...this.settings };
  }

  /** Shows the picture until there is a result, if the panel can. */
  showPicture() {}

  get settings() {
    return Object.assign({}, ...this.parts.map((part) => part.state()));
  }

  #restoreSettings(state) {
    for (const part of this.parts) part.restore(state);
    this.offerFields();
  }

  /** Sets all fields, as a step in the history, and shows the result. */
  applySettings(settings) {
    this.#restoreSettings(settings);
    this.note(true);
    this.refresh();
  }

  #offerPresets(presets) {
    this.presets = presets.map(({ title, settings }) => {
      const button = make("button", { type: "button", textContent: title });
      button.addEventListener("click", () => this.applySettings(settings));
      return { button, settings };
    });
    this.find(".presets").append(...this.presets.map(({ button }) => button));
  }

  #tellPreset() {
    const text = (settings) => JSON.stringify(Object.entries(settings).sort());
    const now = text(this.settings);
    for (const { button, settings } of this.presets) button.setAttribute("aria-pressed", String(text(settings) === now));
  }

  async restore(state) {
    this.#isStale = true;
    this.element.dataset.state = "busy";
    this.#restoreSettings(state);
    if (state.picture === ownPicture) return this.#takeNewest(lastOwnOr(this.firstSample));
    const isOffered = this.thumbs.some(({ dataset }) => dataset.sample === state.picture);
    const name = isOffered ? state.picture : this.firstSample;
    if (this.picture?.path === samplePath(name)) return this.abandonLoads();
    await this.#takeNewest(sample(name));
  }

  activate() {
    this.#offerOwn();
    if (this.#isStale) this.#lookAnew();
  }

  async #lookAnew() {
    if (!this.picture) await this.#takeNewest(lastOfVisit() ?? sample(this.firstSample));
    this.refresh();
  }

  #listenForPictures() {
    this.thumbs = [...this.element.querySelectorAll(".thumb")];
    for (const thumb of this.thumbs) thumb.addEventListener("click", () => this.#choose(sample(thumb.dataset.sample)));
    this.ownThumbs = new OwnThumbs(this.find(".pictures"), (picture) => this.#choose(picture));
    this.find(".all button").addEventListener("click", () => this.#saveAll());
    this.find(".file").addEventListener("change", ({ target }) => {
      if (target.files.length > 0) this.take([...target.files]);
      target.value = "";
    });
    document.addEventListener("paste", (event) => {
      const files = [...event.clipboardData.files];
      if (files.length > 0 && !this.element.hidden) this.take(files);
    });
  }

  take(files) {
    const pictures = files.filter((file) => !isShape(file));
    if (pictures.length === 0) return this.offerElsewhere(files, "shape", { name: "sample", title: "Sample" });
    this.#choose(ownPicturesOf(pictures).then(([first]) => {
      this.#offerOwn();
      return first;
    }));
  }

  /** Saves the results for all pictures that the user has chosen together, with the same settings. */
  #saveAll() {
    const { pictures } = this.ownThumbs;
    this.start(async (signal) => {
      const [{ resultsFor }, { zipOf }] = [await import("./batch.js"), await import("./zip.js")];
      const { files, problems } = await resultsFor(pictures, (picture) => this.resultFor(picture, signal), {
        signal,
        progress: (done) => this.showJob({ status: "running", progress: done / pictures.length }),
      });
      if (files.length === 0) throw new Error(problems[0]);
      save(await zipOf(files), "dots.zip");
      this.status.textContent = `${files.length} of ${pictures.length} pictures saved`;
      this.showWarnings(problems);
    });
  }

  /** Shows the result for a picture, or for the one that a promise yields. */
  async #choose(picture) {
    if (!(await this.#takeNewest(picture))) return;
    this.note(true);
    this.refresh();
  }

  /** Takes a picture once it is loaded, unless another one is chosen before. Returns whether it was taken. */
  async #takeNewest(loading) {
    try {
      const picture = await this.loadNewest(loading);
      if (!picture) return false;
      this.#before ??= { picture: this.picture, shown: this.shown };
      await this.#take(picture);
      return picture === this.picture;
    } catch (problem) {
      this.showProblem(problem);
      return false;
    }
  }

  /** Loads a picture. If the browser cannot decode it, such as a TIFF, the server can still read it. */
  async #take(picture) {
    this.element.dataset.state = "busy";
    this.newest.abandon();
    this.picture = picture;
    if (picture.original === undefined) picture.original = await createImageBitmap(picture.blob).catch(() => null);
    if (picture !== this.picture) return;
    if (picture.original) this.#keepOwn();
    this.#tellPicture();
    if (picture.original) this.showPicture();
  }

  /** Takes the first sample if there is no picture yet. */
  async takeFirst() {
    if (!this.picture) await this.#take(await sample(this.firstSample));
  }

  #keepOwn() {
    if (!this.picture.path) rememberOwn(this.picture);
    this.#offerOwn();
  }

  #offerOwn() {
    this.ownThumbs.offer();
    const { length } = this.ownThumbs.pictures;
    this.find(".all").hidden = length < 2;
    this.find(".all button").textContent = `Download all ${length}`;
  }

  #tellPicture() {
    for (const thumb of this.thumbs) thumb.setAttribute("aria-pressed", String(this.picture?.path === samplePath(thumb.dataset.sample)));
    this.ownThumbs.tell(this.picture);
  }

  refresh(draft = false) {
    this.offerFields();
    this.#tellPreset();
    if (!this.picture) return;
    this.#isStale = false;
    this.showRequest();
    if (!draft) this.note();
    this.start(this.task(draft), draft);
  }

  /** Keeps the picture, because the server has read it. */
  keepPicture() {
    this.#before = null;
    this.#keepOwn();
    this.#tellPicture();
  }

  showWarnings(warnings) {
    const lost = this.picture?.isInstead ? ["Your picture is not stored in this browser. Choose it again"] : [];
    this.find(".warnings").textContent = [...lost, ...warnings].join("; ");
  }

  /** Whether the server cannot read the picture. Browsers show parts of some broken pictures. */
  #isUnreadable({ status, message }) {
    return status === 415 || (status === 422 && /^the image is (broken|of a kind)/.test(message));
  }

  show(problem) {
    const isUnreadable = problem && this.#isUnreadable(problem);
    if (isUnreadable) {
      const text = problem.message.replace(/; (the supported formats|accepted) are .*$/, "");
      const rest = text.replace(/^this is not a supported image/, "");
      problem.message = `This file is not a supported image${rest === text ? ": " : ""}${rest}`;
    }
    super.show(problem);
    if (isUnreadable && this.#before?.shown.status) this.#goBack();
    else if (problem) this.#before = null;
  }

  #goBack() {
    const { picture, shown } = this.#before;
    this.picture = picture;
    this.#before = null;
    this.#tellPicture();
    this.showResult(shown);
    this.showRequest();
    this.note();
  }

  place(errors) {
    for (const part of this.parts) part.show(errors);
  }
}
