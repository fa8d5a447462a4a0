// SPDX-License-Identifier: GPL-3.0-or-later
// Lets the user drag the point of a picture that stays visible when the picture is cut.

import { make } from "./dom.js";

const longest = 170;  // CSS pixels; maximum side of the small picture

export class FocusPad {
  /** @param field  element of a field of two numbers: the point, in shares of the width and the height */
  constructor(field) {
    this.inputs = [...field.querySelectorAll("input")];
    this.canvas = make("canvas");
    this.mark = make("span");
    this.place = make("div", { className: "focus", hidden: true }, this.canvas, this.mark);
    field.append(this.place);
    this.place.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      this.place.setPointerCapture(event.pointerId);
      this.#move(event);
    });
    this.place.addEventListener("pointermove", (event) => {
      if (this.place.hasPointerCapture(event.pointerId)) this.#move(event);
    });
    this.place.addEventListener("pointerup", () => this.inputs[0].dispatchEvent(new Event("change")));
    for (const input of this.inputs) input.addEventListener("input", () => this.#settle());
  }

  #move({ clientX, clientY }) {
    const { left, top, width, height } = this.place.getBoundingClientRect();
    [(clientX - left) / width, (clientY - top) / height].forEach((share, i) => {
      this.inputs[i].value = Math.min(Math.max(share, 0), 1).toFixed(2);
    });
    this.#settle();
  }

  #settle() {
    const [left, top] = this.inputs.map(({ value }) => `${100 * value}%`);
    Object.assign(this.mark.style, { left, top });
  }

  /** Shows a picture, turned clockwise; hides the pad if the browser cannot decode it. */
  show(picture, degrees = 0) {
    this.place.hidden = !picture;
    if (!picture) return;
    const scale = longest / Math.max(picture.width, picture.height);
    const [width, height] = [scale * picture.width, scale * picture.height];
    const isAcross = degrees % 180 !== 0;
    Object.assign(this.canvas, { width: isAcross ? height : width, height: isAcross ? width : height });
    const context = this.canvas.getContext("2d");
    context.imageSmoothingQuality = "high";
    context.translate(this.canvas.width / 2, this.canvas.height / 2);
    context.rotate((degrees * Math.PI) / 180);
    context.drawImage(picture, -width / 2, -height / 2, width, height);
    this.#settle();
  }
}
