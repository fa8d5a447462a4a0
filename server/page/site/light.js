// SPDX-License-Identifier: GPL-3.0-or-later
// Scales pictures in linear light. Means of sRGB values would make patterns of black and white dots far too dark.

/** Linear light, from 0 to 1, of each sRGB value from 0 to 255. */
export const linear = Float32Array.from({ length: 256 }, (_, value) => {
  const share = value / 255;
  return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
});
const steps = 1 << 14;
const encoded = Uint8ClampedArray.from({ length: steps + 2 }, (_, step) => {
  const light = step / steps;
  return 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055);
});

/** Returns the linear light of a computed CSS colour, `rgb(r, g, b)`: three numbers from 0 to 1. */
export const lightOfColour = (text) => text.match(/[\d.]+/g).slice(0, 3).map((value) => linear[Math.round(value)]);

/** Returns the luminance of linear light. */
export const luminance = (red, green, blue) => 0.2126 * red + 0.7152 * green + 0.0722 * blue;

/** Returns the luminance, from 0 to 1, of a colour of the form #rrggbb. */
export const luminanceOf = (colour) => luminance(...[1, 3, 5].map((at) => linear[parseInt(colour.slice(at, at + 2), 16)]));

/**
 * Returns the opacities, from 0 to 255, with which a browser mixes sRGB values so that the light of a colour is mixed with
 * that of the ground: for shares of the colour in equal steps from 0 to 1, given both luminances.
 */
export function sharesAsLight(light, ground) {
  const valueOf = (share) => encoded[Math.round(steps * (share * light + (1 - share) * ground))];
  const [none, whole] = [valueOf(0), valueOf(1)];
  return Uint8ClampedArray.from({ length: 256 }, (_, i) => (whole === none ? i : (255 * (valueOf(i / 255) - none)) / (whole - none)));
}

/**
 * Computes the source cells, with weights, whose mean is each target cell when a row or column of cells is scaled.
 * @param length  number of source cells
 * @param start   position of the scaled line in the target; may be negative
 * @param size    length of the scaled line in target cells
 * @param most    number of visible target cells
 * @returns       {first, count, starts, offsets, weights}. Only the `count` visible target cells from `first` on are
 *                listed. The i-th of them averages the source cells from starts[i] on, with weights[offsets[i]] to
 *                weights[offsets[i + 1] - 1]
 */
function cellsOf(length, start, size, most) {
  const first = Math.max(start, 0);
  const count = Math.max(Math.min(start + size, most) - first, 0);
  const starts = new Int32Array(count);
  const offsets = new Int32Array(count + 1);
  const weights = [];
  for (let i = 0; i < count; ++i) {
    const [left, right] = [0, 1].map((end) => ((first + i + end - start) * length) / size);
    starts[i] = Math.floor(left);
    for (let cell = starts[i]; cell < right && cell < length; ++cell)
      weights.push((Math.min(right, cell + 1) - Math.max(left, cell)) / (right - left));
    offsets[i + 1] = weights.length;
  }
  return { first, count, starts, offsets, weights: Float32Array.from(weights) };
}

/**
 * Adds `weight` times the light of a row of pixels to `sums`, which has three numbers per pixel.
 * @param start   index in `data` of the first pixel
 * @param ground  light behind transparent pixels
 */
function addRow(data, start, weight, ground, sums) {
  for (let from = start, to = 0; to < sums.length; from += 4, to += 3) {
    const alpha = data[from + 3];
    if (alpha === 255) {
      sums[to] += weight * linear[data[from]];
      sums[to + 1] += weight * linear[data[from + 1]];
      sums[to + 2] += weight * linear[data[from + 2]];
    } else {
      for (let channel = 0; channel < 3; ++channel)
        sums[to + channel] += weight * ((alpha / 255) * linear[data[from + channel]] + (1 - alpha / 255) * ground[channel]);
    }
  }
}

/**
 * Scales a picture. Each target pixel gets the mean light of the area that it covers.
 *
 * @param picture  a canvas
 * @param place    {x, y, width, height} of the scaled picture, in whole pixels of a target canvas; parts may be outside
 * @param seen     {width, height} of the target canvas
 * @param ground   light behind transparent pixels
 * @returns        {image, x, y}: the visible pixels and their position; null if there are none
 */
export function scaledAsLight(picture, { x, y, width, height }, seen, ground) {
  const columns = cellsOf(picture.width, x, width, seen.width);
  const rows = cellsOf(picture.height, y, height, seen.height);
  if (columns.count === 0 || rows.count === 0) return null;
  const end = ({ count, starts, offsets }) => starts[count - 1] + offsets[count] - offsets[count - 1];
  const [left, top] = [columns.starts[0], rows.starts[0]];
  const wide = end(columns) - left;
  const { data } = picture.getContext("2d").getImageData(left, top, wide, end(rows) - top);
  const image = new ImageData(columns.count, rows.count);
  const sums = new Float32Array(3 * wide);
  for (let row = 0, to = 0; row < rows.count; ++row) {
    sums.fill(0);
    for (let i = rows.offsets[row], cell = rows.starts[row] - top; i < rows.offsets[row + 1]; ++i, ++cell)
      addRow(data, 4 * wide * cell, rows.weights[i], ground, sums);
    for (let column = 0; column < columns.count; ++column, to += 4) {
      let [red, green, blue] = [0, 0, 0];
      for (let i = columns.offsets[column], from = 3 * (columns.starts[column] - left); i < columns.offsets[column + 1]; ++i, from += 3) {
        red += columns.weights[i] * sums[from];
        green += columns.weights[i] * sums[from + 1];
        blue += columns.weights[i] * sums[from + 2];
      }
      image.data[to] = encoded[Math.round(steps * red)];
      image.data[to + 1] = encoded[Math.round(steps * green)];
      image.data[to + 2] = encoded[Math.round(steps * blue)];
      image.data[to + 3] = 255;
    }
  }
  return { image, x: columns.first, y: rows.first };
}
