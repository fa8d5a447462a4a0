// SPDX-License-Identifier: GPL-3.0-or-later
// Estimates how many dots a picture needs, without the server.

import { linear, luminance } from "./light.js";

const side = 96;  // pixels; side of the reduced picture

/**
 * Returns the total area of the dots, divided by the area of the paper, for a coverage. Areas where dots overlap count
 * for each of them (core/halftone/inks/coverage_curve.h).
 */
const dotsFor = (covered) => covered + 0.6 * Math.max(0, (covered - 0.65) / 0.35) ** 8;

const lightness = (light) => (light > 0.008856 ? 1.16 * Math.cbrt(light) - 0.16 : 9.033 * light);

/** Returns a function from the linear light of red, green and blue to the coverage of each ink. */
function separationOf({ color, palette, dots, tone }) {
  if (color === "rgb") return (...light) => light;
  if (color === "cmyk" || palette) {
    const separate = (...light) => {
      const most = Math.max(...light, 1e-6);
      return [...light.map((one) => 1 - one / most), 1 - most];
    };
    if (!palette) return separate;
    const number = palette.split(",").length;
    return (...light) => Array(number).fill(Math.min(1, separate(...light).reduce((a, b) => a + b) / number));
  }
  const seen = tone === "perceptual" ? (...light) => lightness(luminance(...light)) : luminance;
  return dots === "paper" ? (...light) => [seen(...light)] : (...light) => [1 - seen(...light)];
}

/**
 * Estimates the area and the spread of the dots of each ink.
 *
 * @param picture  any image source of a canvas
 * @param options  options of /halftone
 * @returns        {share, spread} for each ink. `share` is the total area of the ink's dots, overlaps included, divided
 *                 by the area of the picture. `spread` is the mean of the square root of the density of dots, divided
 *                 by the square root of the mean density; the length of a path is proportional to `spread`
 */
export function inksOf(picture, options) {
  const context = new OffscreenCanvas(side, side).getContext("2d", { willReadFrequently: true });
  context.fillStyle = "#fff";
  context.fillRect(0, 0, side, side);
  context.imageSmoothingQuality = "high";
  context.drawImage(picture, 0, 0, side, side);
  const { data } = context.getImageData(0, 0, side, side);
  const separate = separationOf(options);
  const sums = [];
  for (let i = 0; i < data.length; i += 4) {
    separate(linear[data[i]], linear[data[i + 1]], linear[data[i + 2]]).forEach((covered, ink) => {
      sums[ink] ??= { dots: 0, roots: 0 };
      const dots = dotsFor(covered);
      sums[ink].dots += dots / side ** 2;
      sums[ink].roots += Math.sqrt(dots) / side ** 2;
    });
  }
  return sums.map(({ dots, roots }) => ({ share: dots, spread: dots > 0 ? roots / Math.sqrt(dots) : 0 }));
}
