// SPDX-License-Identifier: GPL-3.0-or-later
// Draws millions of dots within a frame. Paths of a canvas are too slow, and Chromium does not draw very long ones.

/**
 * Dots of one colour, computed pixel by pixel. Lengths are in pixels. The opacities of the pixels of a dot add up to its
 * area, and the opacities of several dots are added, so that dots smaller than a pixel have the right tone.
 */
export class DotLayer {
  #context = new OffscreenCanvas(1, 1).getContext("2d");
  #image = new ImageData(1, 1);
  #opacities = new Float32Array(9);  // of the pixels and of a border one pixel wide, row by row

  /** Removes all dots, and sets the size. */
  begin(width, height) {
    if (this.#image.width === width && this.#image.height === height) return this.#opacities.fill(0);
    Object.assign(this.#context.canvas, { width, height });
    this.#image = new ImageData(width, height);
    this.#opacities = new Float32Array((width + 2) * (height + 2));
  }

  /**
   * Adds dots.
   * @param places   coordinates x and y of each dot in turn, on a plane whose y axis points up
   * @param view     {x, y, scale}: position of the origin of the plane, and length of its unit
   * @param isShown  returns whether the dot with this index is added
   */
  add(places, { x, y, scale }, radius, isShown) {
    const opacities = this.#opacities;
    const width = this.#image.width + 2, height = this.#image.height + 2;
    const area = Math.PI * radius * radius, isTiny = area < 1;
    const reach = isTiny ? 0 : 0.5 + Math.sqrt(radius * radius - 1 / 12);  // where the border, one pixel wide, ends
    for (let i = 0; i < places.length / 2; ++i) {
      const left = x + scale * places[2 * i] + 0.5, top = y - scale * places[2 * i + 1] + 0.5;
      if (!(left >= -reach && top >= -reach && left < width - 1 + reach && top < height - 1 + reach) || !isShown(i)) continue;
      if (isTiny) {
        const column = Math.floor(left), row = Math.floor(top), at = row * width + column;
        const right = area * (left - column), low = top - row;
        opacities[at] += (area - right) * (1 - low);
        opacities[at + 1] += right * (1 - low);
        opacities[at + width] += (area - right) * low;
        opacities[at + width + 1] += right * low;
        continue;
      }
      const last = Math.min(Math.floor(left + reach), width - 1), lowest = Math.min(Math.floor(top + reach), height - 1);
      for (let row = Math.max(Math.ceil(top - reach), 0); row <= lowest; ++row) {
        for (let column = Math.max(Math.ceil(left - reach), 0); column <= last; ++column) {
          const inside = reach - Math.sqrt((column - left) ** 2 + (row - top) ** 2);
          if (inside > 0) opacities[row * width + column] += Math.min(inside, 1);
        }
      }
    }
  }

  /** Draws the dots on a canvas of the same size. */
  draw(context, colour) {
    const { data, width, height } = this.#image;
    for (let row = 0, to = 3; row < height; ++row) {
      for (let from = (row + 1) * (width + 2) + 1, end = from + width; from < end; ++from, to += 4) data[to] = 255 * this.#opacities[from];
    }
    this.#context.globalCompositeOperation = "source-in";
    this.#context.putImageData(this.#image, 0, 0);
    this.#context.fillStyle = colour;
    this.#context.fillRect(0, 0, width, height);
    context.save();
    context.resetTransform();
    context.drawImage(this.#context.canvas, 0, 0);
    context.restore();
  }
}
