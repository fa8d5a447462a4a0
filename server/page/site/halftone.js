// A picture becomes dots.

import { capabilities } from "./api.js";
import { acceptDrops, count, seconds } from "./dom.js";
import { Fields } from "./fields.js";
import { postPatiently } from "./jobs.js";
import { Panel } from "./panel.js";
import { Snippets } from "./snippets.js";
import { Viewport } from "./viewport.js";

const draftOptions = { quality: "draft", iterations: 1, passes: 2 };
const thumbWidth = 32;

const fields = [
  { kind: "number", name: "sites", label: "Dots", value: 20000, min: 200, max: 200000, step: 1, log: true, auto: false },
  { kind: "number", name: "dot", label: "Radius", value: 3, min: 0.1, max: 12, log: true, auto: true, units: [["", "pixels"], ["mm", "mm"]] },
  { kind: "number", name: "width_mm", label: "Picture's width, mm", value: 200, min: 20, max: 2000, step: 1, log: true },
  { kind: "choice", name: "tone", label: "Tone", standard: "linear", choices: [["linear", "linear"], ["perceptual", "perceptual: lighter"]] },
  { kind: "number", name: "detail", label: "Detail", value: 0.7, min: 0, max: 1, step: 0.05, standard: 0.7 },
  { kind: "numbers", name: "levels", label: "Levels", standard: "0,1,1", numbers: [
    { label: "black point", value: 0, min: 0, max: 1, step: 0.05 }, { label: "white point", value: 1, min: 0, max: 1, step: 0.05 },
    { label: "gamma", value: 1, min: 0.1, max: 10, step: 0.1 }] },
  { kind: "check", name: "invert", label: "Invert", standard: false },
  { kind: "check", name: "antialias", label: "Soft rims", checked: true, standard: false },
  { kind: "choice", name: "color", label: "Inks", standard: "gray", choices: [["gray", "one"], ["cmyk", "CMYK: four"], ["rgb", "RGB: light on black"], ["palette", "a palette"]] },
  { kind: "palette", name: "palette", label: "Palette", number: 4, colours: ["#0078bf", "#ff48b0", "#ffe800", "#000000", "#00a95c", "#ff6c2f"] },
  { kind: "colour", name: "foreground", label: "Dots' colour", value: "#000000", standard: "#000000" },
  { kind: "colour", name: "background", label: "Paper", value: "#ffffff", standard: "#ffffff", transparent: true },
  { kind: "choice", name: "quality", label: "Quality", standard: "standard", choices: [["standard", "standard"], ["draft", "draft: faster"], ["best", "best: slower"]] },
  { kind: "number", name: "seed", label: "Seed", value: 0, min: 0, max: 100, step: 1, standard: 0 },
];

/** How many dots there are or, if the server has chosen that, how large: in pixels of the picture. */
function describe({ sites }, response) {
  if (sites !== undefined) return `${count(Number(sites))} dots`;
  return `dots of radius ${Number(response.headers.get("X-Radius")).toPrecision(3)}`;
}

export class Halftone extends Panel {
  #picture = null;
  #original = null;
  #dots = null;

  constructor(element) {
    super(element);
    this.divider = this.find(".divider");
    this.viewport = new Viewport(this.find("canvas"), this.find(".zoom"), (...args) => this.#draw(...args));
    this.fields = new Fields(this.find("form"), fields, (draft) => this.refresh(draft));
    this.#offerFields();
    this.snippets = new Snippets(this.find(".snippets"));
    this.divider.addEventListener("input", () => this.viewport.redraw());
    this.addDownloads(capabilities.halftone.formats, "dots", (format, signal) => this.ask(format, signal));
    this.#listenForPictures();
  }

  #listenForPictures() {
    this.thumbs = [...this.element.querySelectorAll(".thumb")];
    for (const thumb of this.thumbs) thumb.addEventListener("click", () => this.chooseSample(thumb.dataset.sample));
    this.find(".file").addEventListener("change", ({ target }) => {
      if (target.files.length > 0) this.#choose(target.files[0], { name: target.files[0].name });
      target.value = "";
    });
    acceptDrops(this.find(".drop"), (file) => this.#choose(file, { name: file.name }));
    document.addEventListener("paste", (event) => {
      const [file] = event.clipboardData.files;
      if (file && !this.element.hidden) this.#choose(file, { name: file.name });
    });
  }

  async chooseSample(name) {
    const path = `/assets/samples/${name}`;
    this.element.dataset.state = "busy";
    await this.#choose(await (await fetch(path)).blob(), { name, path });
  }

  /** A picture that the browser cannot draw, such as a TIFF, still has its dots drawn by the server. */
  async #choose(blob, { name, path }) {
    this.element.dataset.state = "busy";
    this.#picture = { blob, name, path };
    this.#dots = null;
    for (const thumb of this.thumbs) thumb.setAttribute("aria-pressed", String(path?.endsWith(thumb.dataset.sample) ?? false));
    const picture = this.#picture;
    const original = await createImageBitmap(blob).catch(() => null);
    if (picture !== this.#picture) return;
    this.#original = original;
    if (original) this.viewport.content = { width: original.width, height: original.height };
    this.viewport.redraw();
    this.refresh(false);
  }

  /** What makes no sense with the inks, or the unit, that are chosen is not there to be asked for. */
  #offerFields() {
    const { color = "gray", dot } = this.fields.values();
    this.fields.offer("width_mm", String(dot).endsWith("mm"));
    this.fields.offer("palette", color === "palette");
    this.fields.offer("foreground", color === "gray");
    this.fields.offer("invert", color === "gray");
    this.fields.offer("background", color !== "rgb");
  }

  /** A radius in pixels is one of the output, whose scale then must stay what it was when the radius was seen. */
  #options() {
    const options = this.fields.values();
    if (options.palette) delete options.color;
    if (typeof options.dot === "number" && this.#original && this.#dots)
      options.scale = Math.round((100 * this.#dots.width) / this.#original.width) / 100;
    return options;
  }

  /** What the panel shows, in a format. */
  ask(format, signal, told = this.tell) {
    return this.#post({ ...this.#options(), format }, signal, told);
  }

  #post(options, signal, told) {
    if (!this.#picture) throw new Error("choose a picture first");
    return postPatiently(`/halftone?${new URLSearchParams(options)}`, this.#picture.blob, options,
      { signal, told, type: "application/octet-stream" });
  }

  refresh(draft = false) {
    this.#offerFields();
    if (!this.#picture) return;
    const options = this.#options();
    this.snippets.showHalftone({ picture: this.#picture, options });
    this.wish(async (signal) => {
      const start = performance.now();
      const response = await this.#post({ ...options, ...(draft ? draftOptions : {}) }, signal, this.tell);
      const dots = await createImageBitmap(await response.blob());
      if (signal.aborted) return;
      this.#show(dots);
      if (!draft) this.status.textContent = `${describe(options, response)}, ${dots.width} \u00d7 ${dots.height} pixels, ${seconds(start)}`;
    }, draft);
  }

  /** Place and zoom stay while the picture does, though the scale of its output may change. */
  #show(dots) {
    this.#dots = dots;
    const { width, height } = this.#original ?? dots;
    this.viewport.unit = dots.width / width / devicePixelRatio;
    this.viewport.content = { width, height };
  }

  place(errors) {
    this.fields.show(errors);
    const aboutPicture = errors.filter(({ pointer }) => pointer === "image");
    this.find(".picture-error").textContent = aboutPicture.map(({ detail }) => detail).join("; ");
  }

  /** The picture is left. */
  forget() {
    this.#dots = null;
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
