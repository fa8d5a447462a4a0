// SPDX-License-Identifier: GPL-3.0-or-later
// Base class of the panels that turn a picture into something else: the choice of the picture, settings and presets.

import { ask } from "./api.js";
import { inMemory, make } from "./dom.js";
import { isShape } from "./file_kind.js";
import { keep, kept } from "./kept.js";
import { Panel } from "./panel.js";

const thumbSide = 128;  // pixels; side of a thumbnail
const ownPicture = "own";  // name in the address for a picture of the user, which the address cannot hold

const samplePath = (name) => `/assets/samples/${name}`;

/**
 * Loads a picture that comes with the page: {name, path, blob}. A picture of the user has no path. Once a picture is
 * chosen, its `original` is the decoded bitmap, or null if the browser cannot decode it.
 */
const sample = async (name) => ({ name, path: samplePath(name), blob: await (await ask("GET", samplePath(name))).blob() });
const ownOf = async (file) => ({ name: file.name, blob: await inMemory(file) });

/** Last picture of the user. All panels offer it. */
let own = null;

/** Returns the last picture of the user, also if it was chosen before the page was loaded, or else a sample. */
const lastOwn = async (instead) => own ?? await kept("picture") ?? { ...await sample(instead), isInstead: true };

/** Returns the middle square of a picture, or its name if the browser cannot decode it. */
function thumbnailOf({ name, original }) {
  if (!original) return make("span", { textContent: name });
  const canvas = make("canvas", { width: thumbSide, height: thumbSide });
  const side = Math.min(original.width, original.height);
  const context = canvas.getContext("2d");
  context.imageSmoothingQuality = "high";
  context.drawImage(original, (original.width - side) / 2, (original.height - side) / 2, side, side, 0, 0, thumbSide, thumbSide);
  return canvas;
}

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
 * - `shown` and `showResult(shown)`: what is shown; it has a `status` once there is a result
 */
export class PicturePanel extends Panel {
  picture = null;
  #before = null;  // {picture, shown} from before the choice of a picture that the server has not read yet
  #offered = null;  // picture of the user that the thumbnail shows
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
    if (state.picture === ownPicture) return this.#takeNewest(lastOwn(this.firstSample));
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
    if (!this.picture) await this.#takeNewest(own ?? sample(this.firstSample));
    this.refresh();
  }

  #listenForPictures() {
    this.thumbs = [...this.element.querySelectorAll(".thumb")];
    for (const thumb of this.thumbs) thumb.addEventListener("click", () => this.#choose(sample(thumb.dataset.sample)));
    this.ownThumb = make("button", { type: "button", className: "thumb", hidden: true });
    this.ownThumb.addEventListener("click", () => this.#choose(own));
    this.find(".pictures").prepend(this.ownThumb);
    this.find(".file").addEventListener("change", ({ target }) => {
      if (target.files.length > 0) this.take(target.files[0]);
      target.value = "";
    });
    document.addEventListener("paste", (event) => {
      const [file] = event.clipboardData.files;
      if (file && !this.element.hidden) this.take(file);
    });
  }

  take(file) {
    if (isShape(file)) return this.offerElsewhere(file, "shape", { name: "sample", title: "Sample" });
    this.#choose(ownOf(file));
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
    const { name, blob, path } = this.picture;
    if (!path && own !== this.picture) {
      own = this.picture;
      keep("picture", { name, blob });
    }
    this.#offerOwn();
  }

  #offerOwn() {
    if (this.#offered === own) return;
    this.#offered = own;
    this.ownThumb.hidden = false;
    this.ownThumb.ariaLabel = own.name;
    this.ownThumb.replaceChildren(thumbnailOf(own));
  }

  #tellPicture() {
    for (const thumb of this.thumbs) thumb.setAttribute("aria-pressed", String(this.picture?.path === samplePath(thumb.dataset.sample)));
    this.ownThumb.setAttribute("aria-pressed", String(this.picture === own));
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
