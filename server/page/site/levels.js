// SPDX-License-Identifier: GPL-3.0-or-later
// Chooses levels for a picture. The page loads this module when the user asks for them.

const side = 256;  // pixels to which the picture is reduced
const cut = 0.005;  // share of the values of pixels beyond each point

/**
 * Returns levels, as a text for the option `levels`: the points beyond which only few values of red, green and blue lie.
 * They lie so far apart that an almost uniform picture is not changed much.
 */
export function levelsOf(picture) {
  const context = new OffscreenCanvas(side, side).getContext("2d");
  context.fillStyle = "#fff";
  context.fillRect(0, 0, side, side);
  context.drawImage(picture, 0, 0, side, side);
  const values = context.getImageData(0, 0, side, side).data.filter((_, i) => i % 4 < 3).sort();
  const [black, white] = [cut, 1 - cut].map((share) => values[Math.floor(share * (values.length - 1))] / 255);
  const middle = Math.min(Math.max((black + white) / 2, 0.05), 0.95);
  return [Math.min(black, middle - 0.05), Math.max(white, middle + 0.05), 1].map((value) => Number(value.toFixed(2))).join(",");
}
