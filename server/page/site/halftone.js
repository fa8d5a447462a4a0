// SPDX-License-Identifier: GPL-3.0-or-later
// Panel that turns a picture into dots.

import { capabilities } from "./api.js";
import { Comparison } from "./comparison.js";
import { count, seconds } from "./dom.js";
import { DotsLayer, drawingOf, imageOf } from "./dots_layer.js";
import { Fields } from "./fields.js";
import { FocusPad } from "./focus.js";
import { fields, moreFields, presets } from "./halftone_options.js";
import { inksOf } from "./ink.js";
import { postPatiently } from "./jobs.js";
import { fileOf } from "./panel.js";
import { batchRetries, canvasOf, PicturePanel, warningsOf } from "./picture_panel.js";
import { Plotter } from "./plotter.js";
import { offerPrint, printFields, suited } from "./print_options.js";
import { isLarge, reduced } from "./reduced.js";
import { Snippets } from "./snippets.js";
import { Viewport } from "./viewport.js";

const draftOptions = { quality: "draft", iterations: 1, passes: 2 };
const draftScale = 2;  // largest scale of a draft of a reduced picture
const dividedAt = 10;  // per cent; first position of the divider
const thumbWidth = 32;  // CSS pixels; width of the handle of the divider
const toneTolerance = 0.05;

/** Returns the part of a picture that dots show, around the option `gravity`. */
async function shownPart(original, dots, gravity = "0.5,0.5") {
  if (!original) return null;
  const scale = Math.max(dots.width / original.width, dots.height / original.height);
  const [width, height] = [dots.width / scale, dots.height / scale].map(Math.round);
  // Dots of the whole picture have its aspect ratio, up to a rounding of one pixel.
  if (Math.max(original.width - width, original.height - height) * scale < 2) return original;
  const [x, y] = gravity.split(",");
  const start = (share, whole, part) => Math.min(Math.max(Math.floor(share * whole - part / 2), 0), whole - part);
  return createImageBitmap(original, start(x, original.width, width), start(y, original.height, height), width, height);
}

const isOfBothSides = ({ dots, tone, style = "fill", minutes }) =>
  !dots && tone !== "density" && style === "fill" && minutes === undefined;

/** Whether a pen draws more than a short stroke for each dot, so that the drawing differs from plain dots. */
const isOfStrokes = ({ style = "fill" }) => !["fill", "stroke"].includes(style);

/** Whether a drawing is for print. Drawings for print are not antialiased by default. */
const isForPrint = ({ scale, width_mm: print }) => scale !== undefined || print !== undefined;

/**
 * Returns the options of the request whose answer the panel shows. The panel scales in linear light, so the server need
 * not prepare edges for scaling. An explicit `antialias` turns this preparation off.
 */
const shownOptions = (options) => {
  const isSized = isForPrint(options) || options.width !== undefined || options.height !== undefined;
  return isSized ? options : { antialias: true, ...options };
};

const marks = { fill: "dots", stroke: "pen strokes", spiral: "spirals", circles: "dots of nested circles", path: "dots on one line" };

/**
 * Describes the marks by their number or, if the server has chosen it, by their radius in pixels of the picture. A line
 * has the width of its pen, whatever the radius.
 */
function describe({ sites, style = "fill", color, palette }, response) {
  if (sites !== undefined) return `${count(Number(sites))} ${marks[style]}`;
  if (style === "path") return `one line through the dots${color || palette ? " of each ink" : ""}`;
  return `${marks[style]} of radius ${Number(response.headers.get("X-Radius")).toPrecision(3)}`;
}

/**
 * Returns the options of a draft of a picture whose width was divided by `factor`. Scale and radius are adapted, so
 * that dots keep their size on the screen.
 */
function draftOf(options, factor) {
  const draft = { ...shownOptions(options), ...draftOptions };
  if (factor === 1 || options.scale === undefined) return draft;
  draft.scale = Math.min(options.scale * factor, draftScale);
  if (typeof options.dot === "number") draft.dot = (options.dot * draft.scale) / (options.scale * factor);
  return draft;
}

/** Returns the warnings of an answer. The tone is not right if a time limit determines the number of dots. */
function allWarningsOf(response, isTimed) {
  const warnings = warningsOf(response);
  const tone = Number(response.headers.get("X-Tone") ?? 1);
  if (Math.abs(tone - 1) > toneTolerance && !isTimed) warnings.push(`the dots cover ${Math.round(100 * tone)} % of the area that the tone of the picture needs; with Dots on auto, the tone is right`);
  if (response.headers.has("X-Partial")) warnings.push("the time limit of the server was reached before all dots were spread evenly");
  return warnings;
}

export class Halftone extends PicturePanel {
  // Includes `scale` (output pixels per pixel of the picture), `status` and `warnings` after a request that is no
  // draft. `drawing()` then requests the dots as SVG.
  shown = { original: null, dots: null };
  #layer = new DotsLayer(() => this.viewport.redraw());
  #keptLayer = new DotsLayer(() => this.viewport.redraw());
  #stop = new AbortController();  // cancels the request for a drawing
  #planned = null;  // estimate of the dots in each ink

  constructor(element) {
    super(element, presets);
    this.divider = this.find(".divider");
    this.viewport = new Viewport(this.find("canvas"), this.find(".zoom"), (...args) => this.#draw(...args));
    this.fields = new Fields(this.find(".fields"), fields, (draft) => this.refresh(draft));
    this.moreFields = new Fields(this.find(".more form"), moreFields, (draft) => this.refresh(draft));
    this.printFields = new Fields(this.find(".more .of-print"), printFields, (draft) => this.refresh(draft));
    this.focus = new FocusPad(this.find("[data-name=gravity]"));
    this.plotter = new Plotter(this.find(".plotter"), {
      size: () => this.picture?.original ?? this.shown.dots ?? { width: 1, height: 1 },
      plan: () => this.#plan(),
      isTimed: true,
      changed: (draft) => this.refresh(draft),
      dot: (radius) => `${Number(radius.toPrecision(6))}mm`,
      turned: (isOn) => this.#penTurned(isOn),
      noted: () => this.note(),
    });
    this.comparison = new Comparison(this.find(".comparison"), {
      keep: () => ({ picture: this.picture, shown: this.shown, settings: this.settings, words: this.#settingsInWords }),
      restore: ({ settings }) => this.applySettings(settings),
      turned: (isTurned) => this.#comparisonTurned(isTurned),
    });
    this.addDownload((format, signal) => this.ask(format, signal));
    this.addCopy((signal) => this.ask("png", signal));
    this.offerFields();
    this.snippets = new Snippets(this.find(".snippets"));
    this.divider.addEventListener("input", () => { this.#tellDivider(); this.viewport.redraw(); });
    this.#tellDivider();
  }

  #tellDivider() {
    const side = this.comparison.kept ? "A" : "picture";
    this.divider.setAttribute("aria-valuetext", `${Math.round(this.divider.value)} % ${side}`);
  }

  get #settingsInWords() {
    return this.parts.flatMap((part, i) => part.inWords().map((one) => ({ ...one, key: `${i} ${one.label}` })));
  }

  #comparisonTurned(isTurned) {
    const isOn = this.comparison.kept !== null;
    this.find(".canvas-frame").classList.toggle("compared", isOn);
    this.divider.ariaLabel = isOn ? "Divider between A and B" : "Divider between picture and dots";
    if (isTurned) this.divider.value = isOn ? 50 : dividedAt;
    this.#tellDivider();
    this.#compare();
    this.viewport.redraw();
  }

  /** Lists in what the settings differ from those that were kept. Another picture ends the comparison. */
  #compare() {
    const { kept } = this.comparison;
    if (kept && kept.picture !== this.picture) return this.comparison.end();
    this.comparison.tell(this.#settingsInWords);
  }

  state() {
    return { ...super.state(), ...this.#heldWidth };
  }

  get parts() {
    return [this.fields, this.moreFields, this.printFields, this.plotter];
  }

  offerFields() {
    const isPlotted = this.plotter.isOn;
    this.fields.offer("dot", !isPlotted);
    const { color = "gray", dot } = this.fields.values();
    const isInMm = String(dot).endsWith("mm");
    this.fields.offer("width_mm", isInMm);
    this.fields.offer("palette", color === "palette");
    this.fields.offer("foreground", color === "gray");
    this.fields.offer("background", color !== "rgb");
    const options = this.#options();
    const isSized = options.dot !== undefined && isOfBothSides(options);  // the radius then replaces the number
    this.fields.offer("sites", this.plotter.minutes === undefined && !isSized);
    const isInverted = this.fields.values().dots === "paper";
    this.fields.setStandard("foreground", isInverted ? "#ffffff" : "#000000");
    this.fields.setStandard("background", isInverted ? "#000000" : "#ffffff");
    this.printFields.offer("width_mm", !isInMm && !isPlotted);
    offerPrint(this.printFields, { hasWidth: isInMm || this.printFields.values().width_mm !== undefined, isPlotted });
    this.moreFields.offer("style", !isPlotted);
    for (const name of ["width", "height"]) this.moreFields.offer(name, !isPlotted);
    const { width, height } = this.moreFields.values();
    this.moreFields.offer("fit", width !== undefined && height !== undefined);
    this.moreFields.offer("gravity", this.moreFields.values().fit === "cover");
    this.focus.show(this.picture?.original);
    this.offerDownloads(capabilities.halftone.formats, "dots", Object.keys(this.#options("svg")));
  }

  /** Sets the number of dots to auto when the pen is turned on. The user can still choose a number. */
  #penTurned(isOn) {
    if (isOn) this.fields.put("sites", "auto");
    this.refresh();
  }

  /**
   * Option `width` to send if the radius is given in pixels; {} otherwise. Such a radius counts pixels of the output,
   * so the output must keep the width that it had when the radius was chosen.
   */
  get #heldWidth() {
    const { width, height, scale } = this.moreFields.values();
    const { width_mm: print } = this.printFields.values();
    const isHeld = typeof this.fields.values().dot === "number" && [width, height, scale, print].every((one) => one === undefined);
    return isHeld ? this.#shownWidth : {};
  }

  /** Option `width` that gives the width of the last full output; {} if there was none. */
  get #shownWidth() {
    const { original, scale } = this.shown;
    return scale ? { width: Math.round(scale * original.width) } : {};
  }

  /** Returns the options of a request for a format; that for the drawing that the panel shows is PNG. */
  #options(format = "png") {
    const options = suited({ ...this.fields.values(), ...this.moreFields.values(), ...this.printFields.values(), ...this.#heldWidth, ...(this.plotter.isOn && this.plotter.options(format)) }, format);
    // Dots of paper need grey, and pens can only add ink.
    if (options.dots === "paper" ? options.color : this.plotter.isOn) options.dots = "ink";
    if (options.palette) delete options.color;
    if (options.antialias !== isForPrint(options)) delete options.antialias;  // it is the default
    return options;
  }

  async ask(format, signal, { onProgress = this.showJob, picture = this.picture, retries } = {}) {
    await this.takeFirst();
    const options = this.#options(format);
    const { drawn } = capabilities.halftone.formats.find(({ name }) => name === format);
    if (!drawn && isOfBothSides(options)) options.dots = "both";  // which is the default of drawings
    return this.#post({ ...options, ...this.#sizeOf(options, format, drawn), format }, signal, { onProgress, blob: (picture ?? this.picture).blob, retries });
  }

  async resultFor(picture, signal) {
    const { value, selectedOptions: [{ dataset }] } = this.format;
    const response = await this.ask(value, signal, { onProgress: () => {}, picture, retries: batchRetries });
    return { response, extension: fileOf(response, dataset.file).split(".").pop() };
  }

  /**
   * Returns options that give a file the shown size. Lists of dots have no width, and TIFFs are for print by default.
   */
  #sizeOf(options, format, drawn) {
    const isSized = options.width !== undefined || options.height !== undefined;
    if (!drawn) return { width: undefined, height: undefined, fit: undefined, gravity: undefined, ...(isSized && { scale: this.shown.scale?.toFixed(2) }) };
    return format === "tiff" && !isForPrint(options) && !isSized ? this.#shownWidth : {};
  }

  #post(options, signal, { onProgress = this.showJob, blob = this.picture.blob, retries } = {}) {
    const given = Object.entries(options).filter(([, value]) => value !== undefined);
    return postPatiently(`/halftone?${new URLSearchParams(given)}`, blob, options,
      { signal, onProgress, retries, type: "application/octet-stream" });
  }

  async #postDraft(options, signal) {
    const picture = this.picture;
    if (!isLarge(picture.original)) return this.#post(draftOf(options, 1), signal);
    picture.reduced ??= reduced(picture.original);
    const { blob, factor } = await picture.reduced;
    return this.#post(draftOf(options, factor), signal, { blob });
  }

  refresh(draft) {
    super.refresh(draft);
    if (this.picture) this.plotter.wait();
    this.#compare();
  }

  showRequest() {
    const options = this.#options();
    this.snippets.showHalftone({ picture: this.picture, options, file: "dots.png" });
  }

  task(draft) {
    const options = this.#options();
    const settings = JSON.stringify(this.settings);
    return async (signal) => {
      const start = performance.now();
      const response = await (draft ? this.#postDraft(options, signal) : this.#post(shownOptions(options), signal));
      const dots = await canvasOf(response);
      if (signal.aborted) return;
      const original = await shownPart(this.picture.original, dots, options.gravity);
      this.keepPicture();
      const { factor } = (draft && await this.picture.reduced) || { factor: 1 };
      this.#tellChosen(response, dots, factor);
      if (draft) return this.showResult({ ...this.shown, original, dots, drawing: undefined });
      this.showResult({
        original, dots, scale: original && dots.width / original.width,
        drawing: this.plotter.isOn ? undefined : async () => (await this.#post({ ...shownOptions(suited(options)), format: "svg" }, this.#stop.signal, { onProgress: () => {} })).text(),
        status: `${describe(options, response)}, ${dots.width} \u00d7 ${dots.height} pixels, ${seconds(start)}`,
        warnings: allWarningsOf(response, this.plotter.minutes !== undefined),
      });
      await this.#plot(options, signal);
      const { kept } = this.comparison;
      if (kept && JSON.stringify(kept.settings) === settings) kept.shown = this.shown;  // it may have been a draft
      this.status.textContent = this.shown.status;  // the job of the plot may have cleared it
    };
  }

  /**
   * Shows the numbers that the server has chosen. The radius counts pixels of the sent picture there, and of the output
   * here.
   * @param factor  width of the picture / width of the sent picture
   */
  #tellChosen({ headers }, { width, height }, factor) {
    const { original } = this.picture;
    const scale = original ? width / original.width : 1;
    const rounded = (number, digits = 3) => (number > 0 ? Number(number.toPrecision(digits)) : undefined);
    this.fields.tell("dot", rounded(factor * scale * headers.get("X-Radius")));
    for (const [name, number] of Object.entries({ width, height, scale: rounded(scale) })) this.moreFields.tell(name, number);
  }

  async #plot(options, signal) {
    if (!this.plotter.isOn) return;
    const response = await this.#post({ ...suited(options), format: "svg" }, signal);
    const svg = await response.text();
    this.plotter.showDrawing(svg);
    const drawing = () => svg;
    if (!isOfStrokes(options)) return this.showResult({ ...this.shown, drawing });
    const { dots } = this.shown;
    this.showResult({ ...this.shown, drawing, dots: drawingOf(await imageOf(svg), dots, dots, options.background) });
  }

  showPicture() {
    this.showResult({ original: this.picture.original, dots: null });
  }

  /** Shows a result. Position and zoom stay as long as the picture does, even if the output has another scale. */
  showResult(shown) {
    const { original, dots, scale, status = "", warnings = [] } = shown;
    const { width, height } = original ?? dots;
    this.shown = shown;
    this.#stop.abort();
    this.#stop = new AbortController();
    this.status.textContent = status;
    this.showWarnings(warnings);
    this.viewport.unit = dots && (scale ?? dots.width / width) / devicePixelRatio;
    this.viewport.content = { width, height };
  }

  forget() {
    this.shown = { original: this.picture?.original ?? null, dots: null };
    this.showWarnings([]);
    this.plotter.showDrawing(null);
    this.viewport.redraw();
  }

  #draw(context, view) {
    const { original, dots } = this.shown;
    const kept = dots && this.comparison.kept?.shown;
    const left = kept?.dots ? kept : original;
    this.divider.hidden = !left || !dots;
    if (!original && !dots) return this.#layer.rest();
    const { width, height } = original ?? dots;
    const inPixels = (length) => Math.round(length * devicePixelRatio);
    const place = { x: inPixels(view.x), y: inPixels(view.y), width: inPixels(width * view.scale), height: inPixels(height * view.scale) };
    if (dots) this.#layer.draw(this.shown, context, place);
    else this.#layer.rest();
    const end = dots ? inPixels(this.#placeDivider(view, place)) : context.canvas.width;
    if (!left || end === 0) return;
    context.resetTransform();
    context.clearRect(0, 0, end, context.canvas.height);
    if (left === kept) this.#keptLayer.draw(kept, context, this.#keptPlace(kept, view, place), end);
    else this.#drawOriginal(context, place, end);
  }

  /** Keeps the divider within the picture. Returns the position of its line in CSS pixels; 0 at its left end. */
  #placeDivider(view, { x, width }) {
    const share = Number(this.divider.value) / 100;
    const [left, right] = [x, x + width].map((side) => Math.min(Math.max(side / devicePixelRatio, 0), view.size.width));
    const room = Math.max(right - left, thumbWidth);
    Object.assign(this.divider.style, { left: `${left}px`, width: `${room}px` });
    return share === 0 ? 0 : left + thumbWidth / 2 + share * (room - thumbWidth);
  }

  /** Returns the place of dots that were kept. If they show another part of the picture, it has the same middle. */
  #keptPlace({ original, dots }, view, place) {
    const whole = this.shown.original ?? this.shown.dots;
    const own = original ?? { width: whole.width, height: (whole.width * dots.height) / dots.width };
    const [width, height] = [own.width, own.height].map((side) => Math.round(side * view.scale * devicePixelRatio));
    return { x: place.x + Math.round((place.width - width) / 2), y: place.y + Math.round((place.height - height) / 2), width, height };
  }

  /** Draws the picture left of `end`. */
  #drawOriginal(context, { x, y, width, height }, end) {
    context.save();
    context.beginPath();
    context.rect(0, 0, end, context.canvas.height);
    context.clip();
    context.imageSmoothingQuality = "high";
    context.drawImage(this.shown.original, x, y, width, height);
    context.restore();
  }

  #plan() {
    const { original } = this.picture ?? {};
    if (!original) return null;
    const options = { ...this.fields.values(), ...this.moreFields.values() };
    const key = JSON.stringify([options.color, options.palette, options.dots, options.tone]);
    if (this.#planned?.original !== original || this.#planned.key !== key)
      this.#planned = { original, key, inks: inksOf(original, options) };
    return { sites: options.sites, inks: this.#planned.inks };
  }
}
