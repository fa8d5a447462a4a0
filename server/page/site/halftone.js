// SPDX-License-Identifier: GPL-3.0-or-later
// Panel that turns a picture into dots.

import { ask, capabilities } from "./api.js";
import { acceptDrops, count, make, seconds } from "./dom.js";
import { Fields } from "./fields.js";
import { fields, moreFields, presets } from "./halftone_options.js";
import { inksOf } from "./ink.js";
import { postPatiently } from "./jobs.js";
import { lightOfColour, scaledAsLight } from "./light.js";
import { Panel } from "./panel.js";
import { Plotter } from "./plotter.js";
import { isLarge, reduced } from "./reduced.js";
import { Snippets } from "./snippets.js";
import { Viewport } from "./viewport.js";

const draftOptions = { quality: "draft", iterations: 1, passes: 2 };
const draftScale = 2;  // maximum scale of a draft of a reduced picture
const thumbWidth = 32;  // CSS pixels; width of the handle of the divider
const thumbSide = 128;  // pixels; side of a thumbnail
const toneTolerance = 0.05;
const firstSample = "astronaut.jpg";
const ownPicture = "own";  // name in the address for a picture of the user, which is not part of the address

const samplePath = (name) => `/assets/samples/${name}`;

/**
 * Loads a picture of the page: {name, path, blob}. A picture of the user has no path. When a picture is chosen, it gets
 * `original`: the decoded bitmap, or null if the browser cannot decode it.
 */
const sample = async (name) => ({ name, path: samplePath(name), blob: await (await ask("GET", samplePath(name))).blob() });
const ownOf = (file) => ({ name: file.name, blob: file });

function canvasOf(bitmap) {
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  canvas.getContext("2d", { willReadFrequently: true }).drawImage(bitmap, 0, 0);
  return canvas;
}

async function drawingOf(svg, width, height, paper = "#ffffff") {
  const image = new Image();
  image.src = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  await image.decode();
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.fillStyle = paper;
  context.fillRect(0, 0, width, height);
  context.drawImage(image, 0, 0, width, height);
  URL.revokeObjectURL(image.src);
  return canvas;
}

async function shownPart(original, dots) {
  if (!original) return null;
  const scale = Math.max(dots.width / original.width, dots.height / original.height);
  const [width, height] = [dots.width / scale, dots.height / scale].map(Math.round);
  // If the dots have the aspect ratio of the picture, up to a rounding of one pixel, they show the whole picture.
  if (Math.max(original.width - width, original.height - height) * scale < 2) return original;
  return createImageBitmap(original, (original.width - width) / 2, (original.height - height) / 2, width, height);
}

/** Returns the middle square of a picture on a canvas, or its name as text if the browser cannot decode it. */
function thumbnailOf({ name, original }) {
  if (!original) return make("span", { textContent: name });
  const canvas = make("canvas", { width: thumbSide, height: thumbSide });
  const side = Math.min(original.width, original.height);
  const context = canvas.getContext("2d");
  context.imageSmoothingQuality = "high";
  context.drawImage(original, (original.width - side) / 2, (original.height - side) / 2, side, side, 0, 0, thumbSide, thumbSide);
  return canvas;
}

const isOfBothSides = ({ palette, dots, tone, style = "fill", minutes, background }) =>
  !palette && !dots && tone !== "density" && style === "fill" && minutes === undefined && background !== "transparent";

/** Whether a pen draws more than a short stroke for each dot, so that dots and drawing look different. */
const isOfStrokes = ({ style = "fill" }) => !["fill", "stroke"].includes(style);

/** Whether a drawing is for print. Drawings for print are not antialiased by default. */
const isForPrint = ({ scale, width_mm: print }) => scale !== undefined || print !== undefined;

/**
 * Returns the options of the request whose answer the panel shows. Sets `antialias` explicitly, so that the server does
 * not prepare edges for scaling: the panel scales in linear light.
 */
const shownOptions = (options) => {
  const isSized = isForPrint(options) || options.width !== undefined || options.height !== undefined;
  return isSized ? options : { antialias: true, ...options };
};

const marks = { fill: "dots", stroke: "pen strokes", spiral: "spirals", circles: "dots of nested circles", path: "dots on one line" };

/**
 * Describes the drawn marks by their number or, if the server has chosen the number, by their radius in pixels of the
 * picture. Does not name a radius for lines, which have the width of the pen.
 */
function describe({ sites, style = "fill", color, palette }, response) {
  if (sites !== undefined) return `${count(Number(sites))} ${marks[style]}`;
  if (style === "path") return `one line through the dots${color || palette ? " of each ink" : ""}`;
  return `${marks[style]} of radius ${Number(response.headers.get("X-Radius")).toPrecision(3)}`;
}

/**
 * Returns the options of a draft of a picture whose width was divided by `factor`. Adapts scale and radius, so that
 * dots keep their size on the screen.
 */
function draftOf(options, factor) {
  const draft = { ...shownOptions(options), ...draftOptions };
  if (factor === 1 || options.scale === undefined) return draft;
  draft.scale = Math.min(options.scale * factor, draftScale);
  if (typeof options.dot === "number") draft.dot = (options.dot * draft.scale) / (options.scale * factor);
  return draft;
}

function warningsOf(response, isTimed) {
  const warnings = JSON.parse(response.headers.get("X-Warnings") ?? "[]").map(({ detail }) => detail);
  const tone = Number(response.headers.get("X-Tone") ?? 1);
  if (Math.abs(tone - 1) > toneTolerance && !isTimed) warnings.push(`the dots cover ${Math.round(100 * tone)} % of the area that the tone of the picture needs; with Dots on auto, the tone is right`);
  if (response.headers.has("X-Partial")) warnings.push("the time limit of the server was reached before all dots were spread evenly");
  return warnings.join("; ");
}

export class Halftone extends Panel {
  #picture = null;
  #own = null;
  // What the panel shows. After a request that is not a draft, it includes `scale` (output pixels per pixel of the
  // picture), `status` and `warnings`.
  #shown = { original: null, dots: null };
  #before = null;  // {picture, shown} to return to if the server cannot read the chosen picture
  #scaled = {};  // last drawn scaled dots
  #planned = null;  // result of `inksOf` for the picture
  #isStale = true;

  constructor(element) {
    super(element);
    this.divider = this.find(".divider");
    this.viewport = new Viewport(this.find("canvas"), this.find(".zoom"), (...args) => this.#draw(...args));
    this.fields = new Fields(this.find(".fields"), fields, (draft) => this.refresh(draft));
    this.moreFields = new Fields(this.find(".more form"), moreFields, (draft) => this.refresh(draft));
    this.plotter = new Plotter(this.find(".plotter"), {
      size: () => this.#picture?.original ?? this.#shown.dots ?? { width: 1, height: 1 },
      plan: () => this.#plan(),
      isTimed: true,
      changed: (draft) => this.refresh(draft),
      dot: (radius) => `${Number(radius.toPrecision(6))}mm`,
      turned: (isOn) => this.#penTurned(isOn),
      noted: () => this.note(),
    });
    this.addDownload((format, signal) => this.ask(format, signal));
    this.#offerPresets();
    this.#offerFields();
    this.snippets = new Snippets(this.find(".snippets"));
    this.divider.addEventListener("input", () => { this.#tellDivider(); this.viewport.redraw(); });
    this.#tellDivider();
    this.#listenForPictures();
  }

  #tellDivider() {
    this.divider.setAttribute("aria-valuetext", `${Math.round(this.divider.value)} % picture`);
  }

  state() {
    const { path, name } = this.#picture ?? { path: "", name: firstSample };
    const picture = path === undefined ? ownPicture : name;
    return { ...(picture !== firstSample && { picture }), ...this.#settings(), ...this.#heldWidth };
  }

  get #parts() {
    return [this.fields, this.moreFields, this.plotter];
  }

  #settings() {
    return Object.assign({}, ...this.#parts.map((part) => part.state()));
  }

  #restoreSettings(state) {
    for (const part of this.#parts) part.restore(state);
    this.#offerFields();
  }

  #offerPresets() {
    this.presets = presets.map(({ title, settings }) => {
      const button = make("button", { type: "button", textContent: title });
      button.addEventListener("click", () => {
        this.#restoreSettings(settings);
        this.note(true);
        this.refresh();
      });
      return { button, settings };
    });
    this.find(".presets").append(...this.presets.map(({ button }) => button));
  }

  #tellPreset() {
    const text = (settings) => JSON.stringify(Object.entries(settings).sort());
    const now = text(this.#settings());
    for (const { button, settings } of this.presets) button.setAttribute("aria-pressed", String(text(settings) === now));
  }

  async restore(state) {
    this.#isStale = true;
    this.element.dataset.state = "busy";
    this.#restoreSettings(state);
    if (state.picture === ownPicture && this.#own) return this.#takeNewest(this.#own);
    const isOffered = this.thumbs.some(({ dataset }) => dataset.sample === state.picture);
    const name = isOffered ? state.picture : firstSample;
    if (this.#picture?.path === samplePath(name)) return this.abandonLoads();
    await this.#takeNewest(sample(name));
  }

  activate() {
    if (this.#isStale) this.#lookAnew();
  }

  async #lookAnew() {
    if (!this.#picture) await this.#takeNewest(sample(firstSample));
    this.refresh();
  }

  #listenForPictures() {
    this.thumbs = [...this.element.querySelectorAll(".thumb")];
    for (const thumb of this.thumbs) thumb.addEventListener("click", () => this.#choose(sample(thumb.dataset.sample)));
    this.ownThumb = make("button", { type: "button", className: "thumb", hidden: true });
    this.ownThumb.addEventListener("click", () => this.#choose(this.#own));
    this.find(".pictures").prepend(this.ownThumb);
    this.find(".file").addEventListener("change", ({ target }) => {
      if (target.files.length > 0) this.#choose(ownOf(target.files[0]));
      target.value = "";
    });
    acceptDrops(this.find(".drop"), (file) => this.#choose(ownOf(file)));
    document.addEventListener("paste", (event) => {
      const [file] = event.clipboardData.files;
      if (file && !this.element.hidden) this.#choose(ownOf(file));
    });
  }

  /** Chooses a picture (or a promise of a picture), and requests its dots. */
  async #choose(picture) {
    if (!(await this.#takeNewest(picture))) return;
    this.note(true);
    this.refresh();
  }

  /** Takes a picture when it is loaded, unless the user chooses another one before. Returns whether it was taken. */
  async #takeNewest(loading) {
    try {
      const picture = await this.loadNewest(loading);
      if (!picture) return false;
      this.#before ??= { picture: this.#picture, shown: this.#shown };
      await this.#take(picture);
      return picture === this.#picture;
    } catch (problem) {
      this.showProblem(problem);
      return false;
    }
  }

  /** Makes a picture the current one, even if only the server can decode it, such as a TIFF. */
  async #take(picture) {
    this.element.dataset.state = "busy";
    this.newest.abandon();
    this.#picture = picture;
    if (picture.original === undefined) picture.original = await createImageBitmap(picture.blob).catch(() => null);
    if (picture !== this.#picture) return;
    if (picture.original) this.#keepOwn();
    this.#tellPicture();
    if (picture.original) this.#show({ original: picture.original, dots: null });
  }

  #keepOwn() {
    if (this.#picture.path || this.#picture === this.#own) return;
    this.#own = this.#picture;
    this.ownThumb.hidden = false;
    this.ownThumb.ariaLabel = this.#own.name;
    this.ownThumb.replaceChildren(thumbnailOf(this.#own));
  }

  #tellPicture() {
    for (const thumb of this.thumbs) thumb.setAttribute("aria-pressed", String(this.#picture?.path === samplePath(thumb.dataset.sample)));
    this.ownThumb.setAttribute("aria-pressed", String(this.#picture === this.#own));
  }

  #offerFields() {
    const isPlotted = this.plotter.isOn;
    this.fields.offer("dot", !isPlotted);
    const { color = "gray", dot } = this.fields.values();
    const isInMm = String(dot).endsWith("mm");
    this.fields.offer("width_mm", isInMm);
    this.fields.offer("palette", color === "palette");
    this.fields.offer("foreground", color === "gray");
    this.fields.offer("dots", color !== "palette");
    this.fields.offer("background", color !== "rgb");
    this.fields.offer("sites", this.plotter.minutes === undefined);
    const isInverted = this.fields.values().dots === "paper";
    this.fields.setStandard("foreground", isInverted ? "#ffffff" : "#000000");
    this.fields.setStandard("background", isInverted ? "#000000" : "#ffffff");
    this.moreFields.offer("width_mm", !isInMm && !isPlotted);
    this.moreFields.offer("style", !isPlotted);
    for (const name of ["width", "height"]) this.moreFields.offer(name, !isPlotted);
    const { width, height } = this.moreFields.values();
    this.moreFields.offer("fit", width !== undefined && height !== undefined);
    this.offerDownloads(capabilities.halftone.formats, "dots", Object.keys(this.#options()));
  }

  /** Sets the number of dots to auto when the pen is turned on. The user can still choose a number. */
  #penTurned(isOn) {
    if (isOn) this.fields.put("sites", "auto");
    this.refresh();
  }

  /**
   * Option `width` of a request with a radius in pixels; {} for other requests. The radius is in pixels of the output,
   * so the output must keep the width that it had when the user chose the radius.
   */
  get #heldWidth() {
    const { width, height, scale, width_mm: print } = this.moreFields.values();
    const isHeld = typeof this.fields.values().dot === "number" && [width, height, scale, print].every((one) => one === undefined);
    return isHeld ? this.#shownWidth : {};
  }

  /** Option `width` with the width of the last output that was not a draft; {} if there was none. */
  get #shownWidth() {
    const { original, scale } = this.#shown;
    return scale ? { width: Math.round(scale * original.width) } : {};
  }

  #options(format) {
    const options = { ...this.fields.values(), ...this.moreFields.values(), ...this.#heldWidth, ...(this.plotter.isOn && this.plotter.options(format)) };
    if (options.palette) delete options.color;
    // Dots of paper need grey pictures, and pens draw a layer of ink for each colour.
    if (options.color && (options.dots === "paper" || this.plotter.isOn)) options.dots = "ink";
    if (options.antialias !== isForPrint(options)) delete options.antialias;  // omit the default
    return options;
  }

  async ask(format, signal, onProgress = this.showJob) {
    if (!this.#picture) await this.#take(await sample(firstSample));
    const options = this.#options(format);
    const { drawn } = capabilities.halftone.formats.find(({ name }) => name === format);
    if (!drawn && isOfBothSides(options)) options.dots = "both";  // the default of drawings, but not of lists
    return this.#post({ ...options, ...this.#sizeOf(options, format, drawn), format }, signal, onProgress);
  }

  /**
   * Returns options with which a file has the shown size. Lists of dots get `scale` instead of a width, and TIFFs,
   * which are for print by default, a width.
   */
  #sizeOf(options, format, drawn) {
    const isSized = options.width !== undefined || options.height !== undefined;
    if (!drawn) return { width: undefined, height: undefined, fit: undefined, ...(isSized && { scale: this.#shown.scale?.toFixed(2) }) };
    return format === "tiff" && !isForPrint(options) && !isSized ? this.#shownWidth : {};
  }

  #post(options, signal, onProgress, blob = this.#picture.blob) {
    const given = Object.entries(options).filter(([, value]) => value !== undefined);
    return postPatiently(`/halftone?${new URLSearchParams(given)}`, blob, options,
      { signal, onProgress, type: "application/octet-stream" });
  }

  async #postDraft(options, signal) {
    const picture = this.#picture;
    if (!isLarge(picture.original)) return this.#post(draftOf(options, 1), signal, this.showJob);
    picture.reduced ??= reduced(picture.original);
    const { blob, factor } = await picture.reduced;
    return this.#post(draftOf(options, factor), signal, this.showJob, blob);
  }

  refresh(draft = false) {
    this.#isStale = false;
    this.#offerFields();
    this.#tellPreset();
    if (!this.#picture) return;
    const options = this.#options();
    this.snippets.showHalftone({ picture: this.#picture, options });
    this.plotter.wait();
    if (!draft) this.note();
    this.start(async (signal) => {
      const start = performance.now();
      const response = await (draft ? this.#postDraft(options, signal) : this.#post(shownOptions(options), signal, this.showJob));
      const dots = canvasOf(await createImageBitmap(await response.blob()));
      if (signal.aborted) return;
      const original = await shownPart(this.#picture.original, dots);
      this.#before = null;
      this.#keepOwn();
      this.#tellPicture();
      if (draft) return this.#show({ ...this.#shown, original, dots });
      this.#show({
        original, dots, scale: original && dots.width / original.width,
        status: `${describe(options, response)}, ${dots.width} \u00d7 ${dots.height} pixels, ${seconds(start)}`,
        warnings: warningsOf(response, this.plotter.minutes !== undefined),
      });
      await this.#plot(options, signal);
      this.status.textContent = this.#shown.status;  // the job of the drawing may have cleared the text
    }, draft);
  }

  async #plot(options, signal) {
    if (!this.plotter.isOn) return;
    const response = await this.#post({ ...options, format: "svg" }, signal, this.showJob);
    const svg = await response.text();
    this.plotter.showDrawing(svg);
    if (!isOfStrokes(options)) return;
    const { width, height } = this.#shown.dots;
    this.#show({ ...this.#shown, dots: await drawingOf(svg, width, height, options.background) });
  }

  /** Shows a result. Keeps position and zoom for the same picture, even if the scale of the output changes. */
  #show(shown) {
    const { original, dots, scale, status = "", warnings = "" } = shown;
    const { width, height } = original ?? dots;
    this.#shown = shown;
    this.status.textContent = status;
    this.find(".warnings").textContent = warnings;
    this.viewport.unit = dots && (scale ?? dots.width / width) / devicePixelRatio;
    this.viewport.content = { width, height };
  }

  /** Whether a problem means that the server cannot read the picture. Browsers show parts of some broken pictures. */
  #isUnreadable({ status, message }) {
    return status === 415 || (status === 422 && /^the image is (broken|of a kind)/.test(message));
  }

  show(problem) {
    const isUnreadable = problem && this.#isUnreadable(problem);
    if (isUnreadable) {
      const rest = problem.message.replace(/^this is not an image the server can read/, "");
      problem.message = `This file is not an image the server can read${rest === problem.message ? ": " : ""}${rest}`;
      problem.errors = [{ pointer: "image", detail: problem.message }];
    }
    super.show(problem);
    if (isUnreadable && this.#before?.shown.dots) this.#goBack();
    else if (problem) this.#before = null;
  }

  #goBack() {
    const { picture, shown } = this.#before;
    this.#picture = picture;
    this.#before = null;
    this.#tellPicture();
    this.#show(shown);
    this.snippets.showHalftone({ picture, options: this.#options() });
    this.note();
  }

  place(errors) {
    for (const part of [this.fields, this.moreFields, this.plotter]) part.show(errors);
    const aboutPicture = errors.filter(({ pointer }) => pointer === "image");
    this.find(".picture-error").textContent = aboutPicture.map(({ detail }) => detail).join("; ");
  }

  forget() {
    this.#shown = { original: this.#picture?.original ?? null, dots: null };
    this.find(".warnings").textContent = "";
    this.plotter.showDrawing(null);
    this.viewport.redraw();
  }

  #draw(context, view) {
    const { original, dots } = this.#shown;
    this.divider.hidden = !original || !dots;
    if (!original && !dots) return;
    const { width, height } = original ?? dots;
    const inPixels = (length) => Math.round(length * devicePixelRatio);
    const place = { x: inPixels(view.x), y: inPixels(view.y), width: inPixels(width * view.scale), height: inPixels(height * view.scale) };
    if (dots) this.#drawDots(context, place);
    if (original) this.#drawOriginal(context, view, place);
  }

  /** Draws the dots. Caches their scaled pixels, because they do not change while the divider moves. */
  #drawDots(context, place) {
    const { dots } = this.#shown;
    const { width, height } = context.canvas;
    const ground = getComputedStyle(context.canvas.parentElement).backgroundColor;
    const key = JSON.stringify([place, width, height, ground]);
    if (this.#scaled.dots !== dots || this.#scaled.key !== key)
      this.#scaled = { dots, key, pixels: scaledAsLight(dots, place, { width, height }, lightOfColour(ground)) };
    const { pixels } = this.#scaled;
    if (pixels) context.putImageData(pixels.image, pixels.x, pixels.y);
  }

  /** Draws the picture left of the divider, or the whole picture if there are no dots. */
  #drawOriginal(context, view, { x, y, width, height }) {
    const { original, dots } = this.#shown;
    const share = Number(this.divider.value) / 100;
    const end = dots ? thumbWidth / 2 + share * (view.size.width - thumbWidth) : view.size.width;
    context.save();
    context.beginPath();
    context.rect(0, 0, dots && share === 0 ? 0 : end, view.size.height);
    context.clip();
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.imageSmoothingQuality = "high";
    context.drawImage(original, x, y, width, height);
    context.restore();
  }

  #plan() {
    const { original } = this.#picture ?? {};
    if (!original) return null;
    const options = { ...this.fields.values(), ...this.moreFields.values() };
    const key = JSON.stringify([options.color, options.palette, options.dots, options.tone]);
    if (this.#planned?.original !== original || this.#planned.key !== key)
      this.#planned = { original, key, inks: inksOf(original, options) };
    return { sites: options.sites, inks: this.#planned.inks };
  }
}
