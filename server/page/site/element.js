// SPDX-License-Identifier: GPL-3.0-or-later
// Custom element <ccdt-halftone>: shows a picture as dots, in pages of any origin.
//
// The dots come from a server, by default the one that this module was loaded from, or from an engine: a module that
// computes in the browser. Until they arrive, and after an error, the element draws a conventional halftone screen.

import { Connection } from "./connection.js";

const here = import.meta.url;  // bundlers replace `new URL` with import.meta.url

/** Attributes of the element that become options of /halftone. Flags need no value. */
const optionAttributes = ["device", "fit", "gravity", "sites", "color", "palette", "foreground", "background", "tone", "levels", "alpha", "detail", "dot",
  "scale", "quality", "seed", "iterations", "passes", "antialias", "dots", "invert"];
const flags = ["antialias", "invert"];

const maxJobs = 2;  // of all elements; each occupies one of six connections
const nearby = "300px";  // distance from the window at which loading=lazy requests dots
const resizeDelay = 250;  // ms without a change after which new dots are requested
const minPitch = 4;  // pixels; minimum distance of dots drawn in the browser

let jobs = 0;
const waiting = [];

async function inTurn(work) {
  if (jobs < maxJobs) ++jobs;
  else await new Promise((resume) => waiting.push(resume));
  try {
    return await work();
  } finally {
    if (waiting.length > 0) waiting.shift()();
    else --jobs;
  }
}

/** Returns the file at an address, or the element `#id` of the page. */
async function pictureAt(source, signal) {
  if (source.startsWith("#")) return document.querySelector(source);
  const response = await fetch(new URL(source, document.baseURI), { signal });
  if (!response.ok) throw new Error(`${response.url} was answered with status ${response.status}`);
  return response.blob();
}

const darkness = (...light) => 1 - Math.max(...light);
const share = (channel) => (...light) => (1 - darkness(...light) - light[channel]) / Math.max(1 - darkness(...light), 1e-6);
const luminance = (red, green, blue) => 0.2126 * red + 0.7152 * green + 0.0722 * blue;

/**
 * Returns the colour of the paper, the blending mode of the inks, and for each ink [colour, angle of its screen in
 * degrees, function from light to coverage].
 */
function screensOf(options) {
  if (options.get("color") === "cmyk") {
    return { paper: "#fff", mixing: "multiply",
      inks: [["#0ff", 15, share(0)], ["#f0f", 75, share(1)], ["#ff0", 0, share(2)], ["#000", 45, darkness]] };
  }
  if (options.get("color") === "rgb") {
    return { paper: "#000", mixing: "lighter",
      inks: [["#f00", 15, (red) => red], ["#0f0", 75, (_, green) => green], ["#00f", 0, (_, __, blue) => blue]] };
  }
  const light = options.has("invert") || options.get("dots") === "paper";
  const ink = options.get("foreground") ?? options.get("palette")?.split(",")[0] ?? (light ? "#fff" : "#000");
  return { paper: options.get("background") ?? (light ? "#000" : "#fff"), mixing: "source-over",
    inks: [[ink, 45, light ? luminance : (...rgb) => 1 - luminance(...rgb)]] };
}

const decoded = (value) => (value <= 10.31 ? value / 3294.6 : ((value / 255 + 0.055) / 1.055) ** 2.4);
const encoded = Uint8ClampedArray.from({ length: 256 }, (_, i) => (i === 0 ? 0 : 255 * (1.055 * (i / 255) ** (1 / 2.4) - 0.055)));

/** Returns a CSS colour whose components are linear light instead of sRGB values. */
function lightOfColour(context, colour) {
  context.fillStyle = colour;
  return `rgb(${[1, 3, 5].map((at) => 255 * decoded(parseInt(context.fillStyle.slice(at, at + 2), 16)))})`;
}

/**
 * Averages a picture, on white, over a grid of cells. Returns a function from a position (shares of the sides) to the
 * light of the cell there.
 */
function lightOf(bitmap, width, height) {
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  const context = canvas.getContext("2d");
  context.fillStyle = "#fff";
  context.fillRect(0, 0, width, height);
  context.imageSmoothingQuality = "high";
  context.drawImage(bitmap, 0, 0, width, height);
  const { data } = context.getImageData(0, 0, width, height);
  return (x, y) => {
    const [row, column] = [[y, height], [x, width]].map(([share, count]) => Math.min(Math.max(Math.floor(share * count), 0), count - 1));
    const at = 4 * (row * width + column);
    return [data[at], data[at + 1], data[at + 2]].map(decoded);
  };
}

/** Returns the radius, in pitches, of dots with a given coverage on a square grid. */
function radiusOf(covered) {
  const alone = Math.PI / 4;
  if (covered < alone) return Math.sqrt(covered / Math.PI);
  return Math.SQRT1_2 - (Math.SQRT1_2 - 0.5) * Math.sqrt((1 - covered) / (1 - alone));
}

function drawScreen(context, { width, height }, pitch, light, [colour, angle, shareOf]) {
  const [cos, sin] = [Math.cos, Math.sin].map((turn) => pitch * turn((angle * Math.PI) / 180));
  const reach = Math.ceil(Math.hypot(width, height) / pitch / 2) + 1;
  context.fillStyle = lightOfColour(context, colour);
  context.beginPath();
  for (let i = -reach; i <= reach; ++i) {
    for (let j = -reach; j <= reach; ++j) {
      const x = width / 2 + i * cos - j * sin;
      const y = height / 2 + i * sin + j * cos;
      if (x < -pitch || y < -pitch || x > width + pitch || y > height + pitch) continue;
      const radius = pitch * radiusOf(shareOf(...light(x / width, y / height)));
      context.moveTo(x + radius, y);
      context.arc(x, y, radius, 0, 2 * Math.PI);
    }
  }
  context.fill();
}

/** Draws the screens of all inks in linear light, and converts to sRGB. */
function draw(canvas, width, bitmap, options) {
  canvas.width = width;
  canvas.height = Math.max(Math.round((width * bitmap.height) / bitmap.width), 1);
  const { paper, mixing, inks } = screensOf(options);
  const sites = Number(options.get("sites")) || 20000;
  const pitch = Math.max(minPitch, Math.sqrt((canvas.width * canvas.height * inks.length) / sites));
  const light = lightOf(bitmap, Math.ceil(canvas.width / pitch), Math.ceil(canvas.height / pitch));
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (paper !== "transparent") {
    context.fillStyle = lightOfColour(context, paper);
    context.fillRect(0, 0, canvas.width, canvas.height);
  }
  context.globalCompositeOperation = mixing;
  for (const ink of inks) drawScreen(context, canvas, pitch, light, ink);
  const image = context.getImageData(0, 0, canvas.width, canvas.height);
  for (let i = 0; i < image.data.length; ++i) if (i % 4 < 3) image.data[i] = encoded[image.data[i]];
  context.putImageData(image, 0, 0);
}

const looks = `
:host { display: inline-block; position: relative; max-width: 100%; vertical-align: bottom; }
:host([hidden]), [hidden] { display: none; }
img, canvas { display: block; width: 100%; }
p { position: absolute; inset: auto 0 0; margin: 0; padding: .3em .6em; font: 14px/1.4 sans-serif; background: #fff; color: #a8261c; overflow-wrap: anywhere; }
progress { position: absolute; inset: auto 0 0; width: 100%; height: 4px; }`;

// Node.js, which has no HTMLElement, may import this module to render pages.
const Base = globalThis.HTMLElement ?? Object;

export class HalftoneElement extends Base {
  static observedAttributes = ["src", "alt", "server", "engine", "width", "height", "loading", ...optionAttributes];

  /** Loads the engine, if there is one. */
  static loadEngine = (engine) => engine && import(new URL(engine, document.baseURI));

  #picture = Object.assign(new Image(), { hidden: true });
  #drawing = Object.assign(document.createElement("canvas"), { hidden: true });
  #progress = Object.assign(document.createElement("progress"), { hidden: true, ariaLabel: "Dots" });
  #message = Object.assign(document.createElement("p"), { hidden: true });
  #size = new CSSStyleSheet();  // from the attributes width and height
  #width = new CSSStyleSheet();
  #fit = new CSSStyleSheet();  // shows one pixel of the picture on one device pixel
  #observer = new ResizeObserver(() => this.#resized());
  #approach = new IntersectionObserver(([{ isIntersecting }]) => this.#approached(isIntersecting), { rootMargin: nearby });
  #timer = null;
  #loaded = {};  // {source, picture}: the last loaded picture
  #isMissing = false;  // whether the picture could not be loaded, for any width
  #isNear = false;  // whether a lazy element has been near the window
  #pixels = 0;  // width of the last request, in device pixels
  #run = null;
  #isDraft = false;  // of the engine: requested or shown
  #requested = null;  // attributes of the requested or shown dots
  #drawn = null;  // source of the picture drawn in the browser

  constructor() {
    super();
    const root = this.attachShadow({ mode: "open" });
    const sheet = new CSSStyleSheet();
    sheet.replaceSync(looks);
    root.adoptedStyleSheets = [sheet, this.#width, this.#fit, this.#size];
    this.#picture.part = "picture";
    this.#drawing.part = "drawing";
    this.#progress.part = "progress";
    this.#message.part = "message";
    root.append(this.#picture, this.#drawing, this.#progress, this.#message);
  }

  connectedCallback() {
    queueMicrotask(() => this.#refresh());
    try {
      this.#observer.observe(this, { box: "device-pixel-content-box" });  // also reports changes of devicePixelRatio
    } catch {
      this.#observer.observe(this);
    }
  }
  attributeChangedCallback() { queueMicrotask(() => this.#refresh()); }
  disconnectedCallback() { queueMicrotask(() => this.#leave()); }

  /** Requests dots of a changed canvas or video. */
  refresh() {
    this.#requested = null;
    this.#refresh();
  }

  /** Cancels the running request and its job on the server. Keeps the shown picture. */
  abort() {
    if (!this.#run) return;
    this.#cancel();
    this.dispatchEvent(new Event("abort"));
  }

  #cancel() {
    this.#run?.abort();
    this.#run = null;
    this.#progress.hidden = this.#message.hidden = true;
  }

  #approached(isNear) {
    this.#isNear ||= isNear;
    if (isNear) this.#refresh();
  }

  /** Cancels the request of a removed element, but not of a moved one. */
  #leave() {
    if (this.isConnected) return;
    clearTimeout(this.#timer);
    if (!this.#run) return;
    this.#requested = null;
    this.abort();
  }

  #options() {
    const options = new URLSearchParams();
    for (const name of optionAttributes.filter((one) => this.hasAttribute(one)))
      options.set(name, this.getAttribute(name) || (flags.includes(name) ? "true" : ""));
    return options;
  }

  /** Attributes width and height, in CSS pixels. */
  get #given() {
    return ["width", "height"].map((name) => Number(this.getAttribute(name)));
  }

  /** Reserves the size that the attributes give, as for an image. */
  #reserve() {
    const [width, height] = this.#given;
    const fit = width && height ? `aspect-ratio: ${width} / ${height}; } img, canvas { height: 100%; object-fit: ${this.getAttribute("fit") ?? "contain"};` : "";
    if (width) this.#size.replaceSync(`:host { width: ${width}px; ${fit} }`);
    else this.#size.replaceSync(height ? `:host { width: auto; } img, canvas { width: auto; height: ${height}px; }` : "");
  }

  get #pixelsNow() {
    return Math.round(this.getBoundingClientRect().width * devicePixelRatio);
  }

  #resized() {
    if (!this.#requested || this.#isMissing || this.hasAttribute("scale") || [0, this.#pixels].includes(this.#pixelsNow)) return;
    this.#fit.replaceSync("");
    this.#settle();
  }

  /** Requests dots for a new size, or after a draft. */
  #settle() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      if (!this.isConnected || (!this.#isDraft && [0, this.#pixels].includes(this.#pixelsNow))) return;
      this.#cancel();
      this.#make(this.getAttribute("src"), this.#options(), true);
    }, resizeDelay);
  }

  /** Returns the options of a request, with width and `dot` in device pixels unless they contain `scale`. */
  #sized(options) {
    const query = new URLSearchParams(options);
    this.#pixels = this.#pixelsNow;
    if (query.has("scale") || this.#pixels === 0) return query;
    const [width, height] = this.#given;
    query.set("width", this.#pixels);
    if (width && height) query.set("height", Math.round((this.#pixels * height) / width));
    const dot = query.get("dot");
    if (dot && Number.isFinite(Number(dot))) query.set("dot", Number(dot) * devicePixelRatio);
    return query;
  }

  /** Requests dots, unless these are already shown or requested. */
  #refresh() {
    const alt = this.getAttribute("alt");
    this.#picture.alt = alt ?? "";
    Object.assign(this.#drawing, alt ? { role: "img", ariaLabel: alt, ariaHidden: null } : { role: null, ariaHidden: "true" });
    const source = this.getAttribute("src");
    const options = this.#options();
    const requested = `${source} ${this.getAttribute("server")} ${this.getAttribute("engine")} ${this.#given} ${options}`;
    this.#reserve();
    if (!this.isConnected || requested === this.#requested) return;
    if (this.getAttribute("loading") === "lazy" && !this.#isNear) return this.#approach.observe(this);
    if (this.#run && this.#isDraft) return;  // the end of the draft calls this again
    this.#cancel();
    this.#requested = requested;
    if (source) this.#make(source, options);
  }

  async #make(source, options, isFinal) {
    clearTimeout(this.#timer);
    const run = new AbortController();
    const { signal } = run;
    this.#run = run;
    this.#isDraft = false;
    try {
      const engine = await HalftoneElement.loadEngine(this.getAttribute("engine"), this.getAttribute("server"));
      signal.throwIfAborted();
      this.#isMissing = this.#loaded.source !== source;
      this.#isDraft = engine && !isFinal && !this.#isMissing && !this.#picture.hidden;
      if (this.#isMissing) this.#loaded = { source, picture: await pictureAt(source, signal) };
      this.#isMissing = false;
      const { picture } = this.#loaded;
      if (!this.#isDraft) await this.#draw(picture, source, options, signal);
      const query = this.#sized(options);
      await this.#show(await inTurn(() => this.#askForDots(picture, query, run, engine)), signal);
      this.dispatchEvent(new Event("load"));
    } catch (error) {
      if (signal.aborted) return;
      this.#isDraft = false;
      this.#fall(source);
      this.#message.hidden = !error.errors?.length;
      this.#message.textContent = error.message;
      this.dispatchEvent(new ErrorEvent("error", { error, message: error.message }));
    } finally {
      if (this.#run === run) {
        this.#run = null;
        this.#progress.hidden = true;
        if (!this.#isDraft) return;
        this.#settle();
        this.#refresh();
      }
    }
  }

  /** Returns dots from the engine or the server. */
  async #askForDots(body, query, run, engine) {
    const client = engine?.clientOf(this, this.#isDraft) ?? new Connection(this.getAttribute("server") || new URL("/", here));
    const onProgress = ({ progress }) => this.#reportProgress(run, progress);
    const response = await client.request("POST", `halftone?${query}`, { body, signal: run.signal, onProgress });
    return response.blob();
  }

  /** Draws dots in the browser, and shows them unless dots of the same picture are already visible. */
  async #draw(picture, source, options, signal) {
    const bitmap = await createImageBitmap(picture).catch(() => null);
    signal.throwIfAborted();
    if (this.#drawn !== source) {
      this.#picture.hidden = true;
      this.#drawing.hidden = !bitmap;
    }
    this.#drawn = bitmap && source;
    if (!bitmap) return;
    this.#width.replaceSync(`:host { width: ${bitmap.width}px; }`);
    draw(this.#drawing, this.#pixelsNow || bitmap.width, bitmap, options);
    bitmap.close();
  }

  #reportProgress(run, part) {
    if (this.#run !== run) return;
    this.#progress.value = part;
    this.#progress.hidden = false;
    this.dispatchEvent(new ProgressEvent("progress", { lengthComputable: true, loaded: Math.round(100 * part), total: 100 }));
  }

  async #show(dots, signal) {
    const picture = new Image();
    picture.src = URL.createObjectURL(dots);
    try {
      await picture.decode();
      signal.throwIfAborted();
    } catch (error) {
      URL.revokeObjectURL(picture.src);
      throw error;
    }
    const { naturalWidth: width } = picture;
    if (!this.#drawn) this.#width.replaceSync(`:host { width: ${width}px; }`);
    if (width === this.#pixels && width === this.#pixelsNow) this.#fit.replaceSync(`img { width: ${width / devicePixelRatio}px; image-rendering: pixelated; }`);
    URL.revokeObjectURL(this.#picture.src);
    this.#picture.src = picture.src;
    this.#picture.hidden = false;
    this.#drawing.hidden = true;
  }

  /** Shows the drawing or, if the browser could not decode the picture, the picture itself. */
  #fall(source) {
    const isDrawn = this.#drawn === source;
    this.#drawing.hidden = !isDrawn;
    this.#picture.hidden = isDrawn;
    if (isDrawn) return;
    this.#fit.replaceSync("");
    this.#drawn = null;
    URL.revokeObjectURL(this.#picture.src);
    this.#picture.src = source;
  }
}

globalThis.customElements?.define("ccdt-halftone", HalftoneElement);
