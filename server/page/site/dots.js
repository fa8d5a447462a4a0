// SPDX-License-Identifier: GPL-3.0-or-later
// Draws millions of dots and lines within a frame. Paths of a canvas are too slow, and Chromium does not draw very long ones.

import { luminanceOf, sharesAsLight } from "./light.js";

/**
 * Dots and lines of one colour, computed pixel by pixel. Lengths are in pixels. The opacities of the pixels of a dot add up to its
 * area, and the opacities of several dots are added, so that dots smaller than a pixel have the right tone. So do those of
 * lines.
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

  /**
   * Adds straight lines.
   * @param ends  coordinates x and y of both ends of each line in turn; see `add` for the plane and `view`
   */
  addLines(ends, { x, y, scale }, lineWidth) {
    const opacities = this.#opacities;
    const size = [this.#image.width + 2, this.#image.height + 2], strides = [1, size[0]];
    for (let i = 0; i < ends.length; i += 4) {
      const from = [x + scale * ends[i] + 1, y - scale * ends[i + 1] + 1];
      const step = [scale * (ends[i + 2] - ends[i]), scale * (ends[i + 1] - ends[i + 3])];
      const along = Math.abs(step[0]) < Math.abs(step[1]) ? 1 : 0, across = 1 - along;
      const start = step[along] < 0 ? from[along] + step[along] : from[along], end = start + Math.abs(step[along]);
      if (!(end > 0 && start < size[along])) continue;
      const slope = step[across] / step[along] || 0;
      const half = (lineWidth / 2) * Math.hypot(1, slope);  // of the line, measured across
      const last = Math.min(Math.floor(end), size[along] - 1);
      for (let cell = Math.max(Math.floor(start), 0); cell <= last; ++cell) {
        const [left, right] = [Math.max(start, cell), Math.min(end, cell + 1)];
        const middle = from[across] + slope * ((left + right) / 2 - from[along]);
        const lowest = Math.max(Math.floor(middle - half), 0), highest = Math.min(Math.floor(middle + half), size[across] - 1);
        for (let other = lowest; other <= highest; ++other)
          opacities[cell * strides[along] + other * strides[across]] += (right - left) * (Math.min(middle + half, other + 1) - Math.max(middle - half, other));
      }
    }
  }

  /**
   * Draws the dots and lines on a canvas of the same size. Opacities mix light, so that a dot between pixels is as bright as
   * one within a pixel. The colours have the form #rrggbb; `ground` is that of the canvas below.
   */
  draw(context, colour, ground) {
    const { data, width, height } = this.#image;
    const shares = sharesAsLight(luminanceOf(colour), luminanceOf(ground));
    const most = shares.length - 1;
    for (let row = 0, to = 3; row < height; ++row) {
      for (let from = (row + 1) * (width + 2) + 1, end = from + width; from < end; ++from, to += 4) data[to] = shares[Math.round(most * Math.min(this.#opacities[from], 1))];
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
