// A picture becomes dots.

import { capabilities } from "./api.js";
import { acceptDrops, count, seconds } from "./dom.js";
import { Fields } from "./fields.js";
import { fields, moreFields } from "./halftone_options.js";
import { postPatiently } from "./jobs.js";
import { Panel } from "./panel.js";
import { Plotter } from "./plotter.js";
import { isLarge, reduced } from "./reduced.js";
import { Snippets } from "./snippets.js";
import { Viewport } from "./viewport.js";

const draftOptions = { quality: "draft", iterations: 1, passes: 2 };
const draftScale = 2;  // of a draft of a reduced picture, at most
const thumbWidth = 32;
const toneTolerance = 0.05;
const firstSample = "astronaut.jpg";
const ownPicture = "own";  // in the address, which cannot hold it

const samplePath = (name) => `/assets/samples/${name}`;

/** A picture that comes with the page: {name, path, blob}; one's own has no path. */
const sample = async (name) => ({ name, path: samplePath(name), blob: await (await fetch(samplePath(name))).blob() });
const ownOf = (file) => ({ name: file.name, blob: file });

/** Tells whether pictures with such options have dots of ink and of paper. */
const isOfBothSides = ({ palette, dots, tone, style, background }) =>
  !palette && !dots && tone !== "density" && style !== "stroke" && background !== "transparent";

/** How many dots there are or, if the server has chosen that, how large: in pixels of the picture. */
function describe({ sites }, response) {
  if (sites !== undefined) return `${count(Number(sites))} dots`;
  return `dots of radius ${Number(response.headers.get("X-Radius")).toPrecision(3)}`;
}

/**
 * What a draft is asked for, of a picture that is `factor` times less wide than the whole one: what is seen stays as
 * large as it is.
 */
function draftOf(options, factor) {
  const draft = { ...options, ...draftOptions };
  if (factor === 1 || options.scale === undefined) return draft;
  draft.scale = Math.min(options.scale * factor, draftScale);
  if (typeof options.dot === "number") draft.dot = (options.dot * draft.scale) / (options.scale * factor);
  return draft;
}

/** What the server has to say of the picture, though it took it. */
function warningsOf(response) {
  const warnings = JSON.parse(response.headers.get("X-Warnings") ?? "[]").map(({ detail }) => detail);
  const tone = Number(response.headers.get("X-Tone") ?? 1);
  if (Math.abs(tone - 1) > toneTolerance) warnings.push(`dots cover ${Math.round(100 * tone)} % of what the tone of the picture wants: with dots on auto it is right`);
  if (response.headers.has("X-Partial")) warnings.push("the server's time ran out before all dots were even");
  return warnings.join("; ");
}

export class Halftone extends Panel {
  #picture = null;
  #own = null;
  #original = null;
  #dots = null;
  #scale = null;  // output pixels to one of the picture, when it was last made whole
  #isStale = true;

  constructor(element) {
    super(element);
    this.divider = this.find(".divider");
    this.viewport = new Viewport(this.find("canvas"), this.find(".zoom"), (...args) => this.#draw(...args));
    this.fields = new Fields(this.find(".fields"), fields, (draft) => this.refresh(draft));
    this.moreFields = new Fields(this.find(".more form"), moreFields, (draft) => this.refresh(draft));
    this.plotter = new Plotter(this.find(".plotter"), {
      size: () => this.#original ?? this.#dots ?? { width: 1, height: 1 },
      changed: (draft) => this.refresh(draft),
      dot: (radius) => `${Number(radius.toPrecision(6))}mm`,
      turned: (isOn) => this.#penTurned(isOn),
      noted: () => this.note(),
    });
    this.#offerFields();
    this.snippets = new Snippets(this.find(".snippets"));
    this.divider.addEventListener("input", () => { this.#tellDivider(); this.viewport.redraw(); });
    this.#tellDivider();
    this.addDownloads(capabilities.halftone.formats, "dots", (format, signal) => this.ask(format, signal));
    this.#listenForPictures();
  }

  #tellDivider() {
    this.divider.setAttribute("aria-valuetext", `${Math.round(this.divider.value)} % picture`);
  }

  state() {
    const { path, name } = this.#picture ?? { path: "", name: firstSample };
    const picture = path === undefined ? ownPicture : name;
    return {
      ...(picture !== firstSample && { picture }),
      ...this.fields.state(), ...this.moreFields.state(), ...this.#heldScale, ...this.plotter.state(),
    };
  }

  async restore(state) {
    this.#isStale = true;
    this.element.dataset.state = "busy";
    for (const part of [this.fields, this.moreFields, this.plotter]) part.restore(state);
    this.#offerFields();
    if (state.picture === ownPicture && this.#own) return this.#take(this.#own);
    const isOffered = this.thumbs.some(({ dataset }) => dataset.sample === state.picture);
    const name = isOffered ? state.picture : firstSample;
    if (this.#picture?.path !== samplePath(name)) await this.#take(await sample(name));
  }

  look() {
    if (this.#isStale) this.#lookAnew();
  }

  async #lookAnew() {
    if (!this.#picture) await this.#take(await sample(firstSample));
    this.refresh();
  }

  #listenForPictures() {
    this.thumbs = [...this.element.querySelectorAll(".thumb")];
    for (const thumb of this.thumbs) thumb.addEventListener("click", () => this.#chooseSample(thumb.dataset.sample));
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

  async #chooseSample(name) {
    this.element.dataset.state = "busy";
    await this.#choose(await sample(name));
  }

  /** A picture of one's own, or a sample: a step that one may go back from. */
  async #choose(picture) {
    if (!picture.path) this.#own = picture;
    await this.#take(picture);
    if (picture !== this.#picture) return;
    this.note(true);
    this.refresh();
  }

  /** A picture that the browser cannot draw, such as a TIFF, still has its dots drawn by the server. */
  async #take(picture) {
    this.element.dataset.state = "busy";
    this.newest.abandon();
    this.#picture = picture;
    this.#dots = this.#scale = null;
    for (const thumb of this.thumbs) thumb.setAttribute("aria-pressed", String(picture.path === samplePath(thumb.dataset.sample)));
    const original = await createImageBitmap(picture.blob).catch(() => null);
    if (picture !== this.#picture) return;
    this.#original = original;
    if (original) this.viewport.content = { width: original.width, height: original.height };
    this.viewport.redraw();
  }

  /** What makes no sense with the inks, the unit or the pen that are chosen is not there to be asked for. */
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
    this.moreFields.offer("width_mm", !isInMm && !isPlotted);
    this.moreFields.offer("style", !isPlotted);
  }

  /** A pen that is taken up makes as many dots as the tone wants; one may still say how many. */
  #penTurned(isOn) {
    if (isOn) this.fields.put("sites", "auto");
    this.refresh();
  }

  /** A radius in pixels is one of the output, whose scale then must stay what it was when the radius was seen: that. */
  get #heldScale() {
    const isHeld = typeof this.fields.values().dot === "number" && this.moreFields.values().scale === undefined;
    return isHeld && this.#scale ? { scale: Math.round(100 * this.#scale) / 100 } : {};
  }

  #options() {
    const options = { ...this.fields.values(), ...this.moreFields.values(), ...this.#heldScale, ...(this.plotter.isOn && this.plotter.options()) };
    if (options.palette) delete options.color;
    if (options.color && options.dots === "paper") options.dots = "ink";  // paper alone is of grey
    return options;
  }

  /** What the panel shows, in a format. */
  async ask(format, signal, told = this.tell) {
    if (!this.#picture) await this.#take(await sample(firstSample));
    const options = this.#options();
    if (isOfBothSides(options)) options.dots = "both";  // also of lists, whose default is ink
    return this.#post({ ...options, format }, signal, told);
  }

  #post(options, signal, told, blob = this.#picture.blob) {
    return postPatiently(`/halftone?${new URLSearchParams(options)}`, blob, options,
      { signal, told, type: "application/octet-stream" });
  }

  /** Large pictures are reduced for drafts, once. */
  async #postDraft(options, signal) {
    const picture = this.#picture;
    if (!isLarge(this.#original)) return this.#post(draftOf(options, 1), signal, this.tell);
    picture.reduced ??= reduced(this.#original);
    const { blob, factor } = await picture.reduced;
    return this.#post(draftOf(options, factor), signal, this.tell, blob);
  }

  refresh(draft = false) {
    this.#isStale = false;
    this.#offerFields();
    if (!this.#picture) return;
    const options = this.#options();
    this.snippets.showHalftone({ picture: this.#picture, options });
    this.plotter.wait();
    if (!draft) this.note();
    this.wish(async (signal) => {
      const start = performance.now();
      const response = await (draft ? this.#postDraft(options, signal) : this.#post(options, signal, this.tell));
      const dots = await createImageBitmap(await response.blob());
      if (signal.aborted) return;
      if (draft) return this.#show(dots);
      this.#scale = this.#original && dots.width / this.#original.width;
      this.#show(dots);
      this.status.textContent = `${describe(options, response)}, ${dots.width} \u00d7 ${dots.height} pixels, ${seconds(start)}`;
      this.find(".warnings").textContent = warningsOf(response);
      await this.#plot(options, signal);
    }, draft);
  }

  /** Tells how a plotter would draw what is shown. */
  async #plot(options, signal) {
    if (!this.plotter.isOn) return;
    const response = await this.#post({ ...options, format: "svg" }, signal, this.tell);
    this.plotter.tell(await response.text());
  }

  /** Place and zoom stay while the picture does, though the scale of its output may change. */
  #show(dots) {
    this.#dots = dots;
    const { width, height } = this.#original ?? dots;
    this.viewport.unit = (this.#scale ?? dots.width / width) / devicePixelRatio;
    this.viewport.content = { width, height };
  }

  place(errors) {
    for (const part of [this.fields, this.moreFields, this.plotter]) part.show(errors);
    const aboutPicture = errors.filter(({ pointer }) => pointer === "image");
    this.find(".picture-error").textContent = aboutPicture.map(({ detail }) => detail).join("; ");
  }

  /** The picture is left. */
  forget() {
    this.#dots = null;
    this.find(".warnings").textContent = "";
    this.plotter.tell(null);
    this.viewport.redraw();
  }

  #draw(context, view) {
    this.divider.hidden = !this.#original || !this.#dots;
    if (!this.#original && !this.#dots) return;
    const { width, height } = this.#original ?? this.#dots;
    const place = [view.x, view.y, width * view.scale, height * view.scale];
    if (this.#dots) this.#drawDots(context, place);
    if (this.#original) this.#drawOriginal(context, view, place);
  }

  #drawDots(context, place) {
    context.imageSmoothingEnabled = place[2] * devicePixelRatio < this.#dots.width;
    context.imageSmoothingQuality = "high";
    context.drawImage(this.#dots, ...place);
  }

  /** All of it as long as there are no dots. */
  #drawOriginal(context, view, place) {
    const share = Number(this.divider.value) / 100;
    const end = this.#dots ? thumbWidth / 2 + share * (view.size.width - thumbWidth) : view.size.width;
    context.save();
    context.beginPath();
    context.rect(0, 0, this.#dots && share === 0 ? 0 : end, view.size.height);
    context.clip();
    context.imageSmoothingEnabled = true;
    context.drawImage(this.#original, ...place);
    context.restore();
  }
}
