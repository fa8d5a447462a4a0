// SPDX-License-Identifier: GPL-3.0-or-later
// Panel that shows a picture in the pixels and colours of a device, such as electronic paper.

import { post } from "./api.js";
import { make, seconds } from "./dom.js";
import { fields, formats, moreFields, presets, types, viewFields } from "./device_options.js";
import { Fields } from "./fields.js";
import { FocusPad } from "./focus.js";
import { batchRetries, canvasOf, PicturePanel, warningsOf } from "./picture_panel.js";
import { Snippets } from "./snippets.js";

const margin = 16;  // CSS pixels around the preview

/** Formats that store the width in millimetres. */
const measuredFormats = ["png", "bmp"];

/** Returns a copy of pixels in which each colour that is sent to a device is replaced by the colour that is seen. */
function asSeen({ data, width, height }, { sent, seen }) {
  const bytesOf = (colour) => [1, 3, 5].map((start) => parseInt(colour.slice(start, start + 2), 16));
  const numberOf = (red, green, blue) => (red << 16) | (green << 8) | blue;
  const seenBySent = new Map(sent.map((colour, i) => [numberOf(...bytesOf(colour)), bytesOf(seen[i])]));
  const image = new ImageData(new Uint8ClampedArray(data), width, height);
  for (let i = 0; i < data.length; i += 4) image.data.set(seenBySent.get(numberOf(data[i], data[i + 1], data[i + 2])), i);
  return image;
}

/** Draws the left half of a picture as it lies in the answer to a request with these options. */
function drawLeftHalf(context, picture, { rotate = "0", fit, gravity = "0.5,0.5", background = "#ffffff" }) {
  const { width, height } = context.canvas;
  const sides = [picture.width, picture.height];
  const [across, down] = rotate % 180 === 0 ? sides : sides.toReversed();
  const scale = Math[fit === "cover" ? "max" : "min"](width / across, height / down);
  const middle = (frame, whole, share) => (frame < whole ? Math.min(Math.max(frame / 2 + (0.5 - share) * whole, frame - whole / 2), whole / 2) : frame / 2);
  const [x, y] = gravity.split(",");
  context.save();
  context.beginPath();
  context.rect(0, 0, width / 2, height);
  context.clip();
  context.fillStyle = background;
  context.fillRect(0, 0, width, height);
  context.translate(middle(width, scale * across, x), middle(height, scale * down, y));
  context.rotate((rotate * Math.PI) / 180);
  context.imageSmoothingQuality = "high";
  context.drawImage(picture, ...sides.map((side) => (-scale * side) / 2), ...sides.map((side) => scale * side));
  context.restore();
}

const isMeasured = ({ sent, seen }) => sent.some((colour, i) => colour !== seen[i]);

/** Creates a sample of each colour. The upper half is the colour that is sent, the lower half the one that is seen. */
function swatchesOf({ sent, seen }) {
  return sent.map((colour, i) => {
    const name = colour === seen[i] ? colour : `${colour}, seen as ${seen[i]}`;
    const swatch = make("span", { title: name, style: `--sent: ${colour}; --seen: ${seen[i]}`, attributes: { role: "img", "aria-label": name } });
    return make("li", {}, swatch);
  });
}

export class Devices extends PicturePanel {
  shown = {};  // {pixels, colours, original, options, status, warnings} after a request

  constructor(element) {
    super(element, presets, "cat.jpg");
    this.canvas = this.find(".exact canvas");
    this.fields = new Fields(this.find(".fields"), fields, (draft) => this.refresh(draft));
    this.moreFields = new Fields(this.find(".more form"), moreFields, (draft) => this.refresh(draft));
    this.view = new Fields(this.find(".view"), viewFields, () => { this.note(); this.#draw(); });
    this.focus = new FocusPad(this.find("[data-name=gravity]"));
    this.swatches = make("ul", { className: "swatches", attributes: { "aria-label": "Colours of the device" } });
    this.swatchesHint = make("p", { className: "hint", textContent: "Above: in the file. Below: as measured on a panel." });
    this.find("[data-name=device]").append(this.swatches, this.swatchesHint);
    this.find(".download").append(this.downloadButton(async (signal) =>
      ({ response: await this.#post(this.#options, signal), name: this.#fileName })));
    this.addCopy((signal) => this.#postPixels(signal));
    this.snippets = new Snippets(this.find(".snippets"));
    addEventListener("resize", () => this.#fit());
    this.offerFields();
  }

  get parts() {
    return [this.fields, this.moreFields, this.view];
  }

  get #format() {
    return this.fields.values().format ?? "png";
  }

  get #fileName() {
    return `pixels.${formats.find(({ name }) => name === this.#format).extension}`;
  }

  /** Colours of the device: {sent, seen}. */
  get #colours() {
    const { device, palette } = this.fields.values();
    if (device !== "custom") return types.find(({ name }) => name === device);
    const colours = palette.split(",");
    return { sent: colours, seen: colours };
  }

  offerFields() {
    const { device, width, height } = this.fields.values();
    this.fields.offer("palette", device === "custom");
    this.fields.offer("fit", width !== undefined && height !== undefined);
    const { fit, rotate } = this.fields.values();
    this.fields.offer("gravity", fit === "cover");
    this.focus.show(this.picture?.original, Number(rotate ?? 0));
    const colours = this.#colours;
    this.fields.allow("format", "escpos", colours.sent.length === 2);
    this.moreFields.offer("spot", colours.sent.length === 2);
    for (const name of ["bit_order", "invert_bits"]) this.fields.offer(name, this.#format === "raw");
    this.moreFields.offer("width_mm", measuredFormats.includes(this.#format));
    this.view.offer("seen", isMeasured(colours));
    this.swatches.replaceChildren(...(device === "custom" ? [] : swatchesOf(colours)));
    this.swatchesHint.hidden = !isMeasured(colours);
  }

  get #options() {
    return { ...this.fields.values(), ...this.moreFields.values() };
  }

  #post(options, signal, { blob } = this.picture, retries) {
    return post(`/halftone?${new URLSearchParams(options)}`, blob, { signal, retries, type: "application/octet-stream" });
  }

  async resultFor(picture, signal) {
    return { response: await this.#post(this.#options, signal, picture, batchRetries), extension: this.#fileName.split(".").pop() };
  }

  showRequest() {
    this.snippets.showHalftone({ picture: this.picture, options: this.#options, file: this.#fileName });
  }

  /** Requests the pixels as a PNG. Files in all formats have the same pixels. */
  #postPixels(signal) {
    const { format, bit_order, invert_bits, width_mm, ...options } = this.#options;
    return this.#post(options, signal);
  }

  task() {
    const [colours, options] = [this.#colours, this.#options];
    return async (signal) => {
      const start = performance.now();
      const response = await this.#postPixels(signal);
      const canvas = await canvasOf(response);
      if (signal.aborted) return;
      const { width, height } = canvas;
      const warnings = warningsOf(response);
      if (response.headers.has("X-Partial")) warnings.push("the time limit of the server was reached before the search for the best pixels had ended");
      this.keepPicture();
      this.showResult({
        pixels: canvas.getContext("2d").getImageData(0, 0, width, height), colours, warnings,
        original: this.picture.original, options,
        status: `${width} \u00d7 ${height} pixels, ${colours.sent.length} colours, ${seconds(start)}`,
      });
    };
  }

  showResult(shown) {
    this.shown = shown;
    this.status.textContent = shown.status;
    this.showWarnings(shown.warnings);
    this.#draw();
  }

  forget() {
    this.shown = {};
    this.showWarnings([]);
    this.#draw();
  }

  #draw() {
    const { pixels, colours, original, options } = this.shown;
    this.canvas.hidden = !pixels;
    if (!pixels) return;
    Object.assign(this.canvas, { width: pixels.width, height: pixels.height });
    const { seen, compare } = this.view.values();
    const context = this.canvas.getContext("2d");
    context.putImageData(seen ? asSeen(pixels, colours) : pixels, 0, 0);
    if (compare && original) drawLeftHalf(context, original, options);
    this.#fit();
  }

  /** Gives each pixel of the preview one pixel of the screen, or a square of them: the largest that fits, or of a chosen size. */
  #fit() {
    const { width, height, style } = this.canvas;
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    const largest = Math.min((clientWidth - 2 * margin) / width, (clientHeight - 2 * margin) / height) * devicePixelRatio;
    const zoom = (this.view.values().zoom ?? Math.max(Math.floor(largest), 1)) / devicePixelRatio;
    style.width = `${zoom * width}px`;
    style.height = `${zoom * height}px`;
  }
}
