// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of the user: the last one, or all that were chosen together. All panels offer them.

import { inMemory, make } from "./dom.js";
import { keep, kept } from "./kept.js";

const thumbSide = 128;  // pixels; side of a thumbnail

let pictures = [];
let last = null;  // the one of them that was shown last

/** Reads files that the user has chosen together: [{name, blob, together}]. */
export async function ownPicturesOf(files) {
  const together = await Promise.all(files.map(async (file) => ({ name: file.name, blob: await inMemory(file) })));
  for (const picture of together) picture.together = together;
  if (together.length > 1) pictures = together;
  return together;
}

/** Returns the last picture of the user, also if it was chosen before the page was loaded; undefined if there is none. */
export const lastOwn = async () => last ?? kept("picture");

/** Returns the last picture of the user since the page was loaded; null if there is none. */
export const lastOfVisit = () => last;

/** Remembers a picture of the user, because it can be read. */
export function rememberOwn(picture) {
  if (!pictures.includes(picture)) pictures = picture.together ?? [picture];
  if (last === picture) return;
  last = picture;
  keep("picture", { name: picture.name, blob: picture.blob });
}

/** Returns the middle square of a picture, or its name if the browser cannot decode it. */
async function thumbnailOf({ name, blob, original }) {
  const image = original ?? await createImageBitmap(blob, { resizeHeight: 2 * thumbSide, resizeQuality: "medium" }).catch(() => null);
  if (!image) return make("span", { textContent: name });
  const canvas = make("canvas", { width: thumbSide, height: thumbSide });
  const side = Math.min(image.width, image.height);
  const context = canvas.getContext("2d");
  context.imageSmoothingQuality = "high";
  context.drawImage(image, (image.width - side) / 2, (image.height - side) / 2, side, side, 0, 0, thumbSide, thumbSide);
  return canvas;
}

/** Thumbnails of the pictures of the user, in a panel. */
export class OwnThumbs {
  #offered = [];
  #buttons = [];

  /**
   * @param place   parent of the thumbnails
   * @param choose  called with the picture that the user has chosen
   */
  constructor(place, choose) {
    Object.assign(this, { place, choose });
  }

  /** Pictures that have thumbnails. */
  get pictures() {
    return this.#offered;
  }

  /** Shows thumbnails of the pictures that the user has chosen last, in this panel or in another one. */
  async offer() {
    if (this.#offered === pictures) return;
    const offered = this.#offered = pictures;
    for (const button of this.#buttons) button.remove();
    this.#buttons = offered.map((picture) => {
      const button = make("button", { type: "button", className: "thumb", ariaLabel: picture.name });
      button.addEventListener("click", () => this.choose(picture));
      return button;
    });
    this.place.prepend(...this.#buttons);
    const buttons = this.#buttons;
    for (const [i, button] of buttons.entries()) {  // one after another, because decoded photographs are large
      button.replaceChildren(await thumbnailOf(offered[i]));
    }
  }

  /** Marks the thumbnail of the current picture. */
  tell(picture) {
    this.#buttons.forEach((button, i) => button.setAttribute("aria-pressed", String(this.#offered[i] === picture)));
  }
}
