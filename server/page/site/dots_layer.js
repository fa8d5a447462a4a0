// SPDX-License-Identifier: GPL-3.0-or-later
// Draws the dots of a halftone at any scale.

import { lightOfColour, scaledAsLight } from "./light.js";

const restDelay = 150;  // ms without movement after which enlarged dots are drawn as dots
const finePixels = 2;  // columns and rows of a drawing per pixel of the screen, whose light is averaged

export async function imageOf(svg) {
  const image = new Image();
  image.src = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  await image.decode();
  URL.revokeObjectURL(image.src);
  return image;
}

/** Draws an image at a place on a canvas that is filled with `paper`. */
export function drawingOf(image, { x = 0, y = 0, width, height }, size, paper = "#ffffff") {
  const canvas = new OffscreenCanvas(size.width, size.height);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.fillStyle = paper;
  context.fillRect(0, 0, size.width, size.height);
  context.drawImage(image, x, y, width, height);
  return canvas;
}

export class DotsLayer {
  #shown = null;  // what was drawn last
  #scaled = {};  // scaled dots that were drawn last
  #fine = {};  // enlarged drawing that was drawn last
  #rest = null;  // timer that draws it again

  /** @param redraw  called when there is more detail to draw */
  constructor(redraw) {
    this.redraw = redraw;
  }

  /**
   * Draws dots. Their scaled pixels are kept, because they stay the same while the divider moves.
   * @param shown  {dots, drawing}: pixels, and a function that returns the SVG or a promise of it, if there is one
   * @param place  {x, y, width, height} in pixels of the canvas
   * @param end    only columns of pixels left of `end` are drawn
   */
  draw(shown, context, place, end = context.canvas.width) {
    this.#shown = shown;
    const { dots, drawing } = shown;
    const { width, height } = context.canvas;
    const ground = getComputedStyle(context.canvas.parentElement).backgroundColor;
    const key = JSON.stringify([place, width, height, ground]);
    if (this.#scaled.dots !== dots || this.#scaled.key !== key)
      this.#scaled = { dots, key, pixels: scaledAsLight(dots, place, { width, height }, lightOfColour(ground)) };
    const put = (image, x, y) => context.putImageData(image, x, y, 0, 0, end - x, image.height);
    const { pixels } = this.#scaled;
    if (pixels && pixels.x < end) put(pixels.image, pixels.x, pixels.y);
    const fine = this.#fine;
    const [x, y] = [place.x - fine.place?.x, place.y - fine.place?.y];
    if (fine.dots === dots && fine.place.width === place.width && x < end) put(fine.image, x, y);
    clearTimeout(this.#rest);
    if (fine.dots === dots && fine.key === key) return;
    if (drawing && place.width > dots.width) this.#rest = setTimeout(() => this.#drawFine(place, { width, height }, ground, key), restDelay);
  }

  /** Stops waiting to draw more detail, because the dots are no longer shown. */
  rest() {
    clearTimeout(this.#rest);
  }

  /** Draws enlarged dots as dots instead of pixels, once the view is at rest. Without an answer, the pixels stay. */
  async #drawFine(place, size, ground, key) {
    const shown = this.#shown;
    if (!shown.drawing) return;
    shown.image ??= Promise.resolve(shown.drawing()).then(imageOf);
    const image = await shown.image.catch(({ name }) => {
      if (name === "AbortError") shown.image = undefined;  // can be requested again
      return null;
    });
    if (!image || this.#shown !== shown || this.#scaled.key !== key) return;
    const enlarged = (lengths) => Object.fromEntries(Object.entries(lengths).map(([name, length]) => [name, finePixels * length]));
    const drawing = drawingOf(image, enlarged(place), enlarged(size), ground);
    const scaled = scaledAsLight(drawing, { x: 0, y: 0, ...size }, size, lightOfColour(ground));
    this.#fine = { dots: shown.dots, place, key, image: scaled.image };
    this.redraw();
  }
}
