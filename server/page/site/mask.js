// SPDX-License-Identifier: GPL-3.0-or-later
// Shows a mask of thresholds and its effect: the repeated mask, and a picture and a grey ramp dithered with it.

const minSide = 256;  // pixels; minimum side of the areas for the mask and the picture
const gap = 8;  // pixels between the parts
const picture = "/assets/samples/camera.jpg";  // a grey picture

/** Stretches an image to a size, and returns its grey values, row by row. */
function greysOf(image, width, height) {
  const context = new OffscreenCanvas(width, height).getContext("2d");
  context.drawImage(image, 0, 0, width, height);
  const { data } = context.getImageData(0, 0, width, height);
  return Uint8Array.from({ length: width * height }, (_, i) => data[4 * i]);
}

/**
 * Draws a mask and its effect.
 *
 * @param blob  a mask, as the server returns it
 * @returns     {width, height, canvas}: size of the mask in pixels, and the drawing, with the mask at the upper left
 */
export async function showing(blob) {
  const mask = await createImageBitmap(blob);
  const light = await createImageBitmap(await (await fetch(picture)).blob());
  const { width, height } = mask;
  const side = Math.max(minSide, width, height);
  const whole = 2 * side + gap;
  const band = Math.round(side / 8);
  const thresholds = greysOf(mask, width, height);
  const greys = greysOf(light, side, side);
  const threshold = (x, y) => thresholds[(y % height) * width + (x % width)];
  const dithered = (grey) => (x, y) => (grey(x, y) > threshold(x, y) ? 255 : 0);
  const parts = [
    { x: 0, y: 0, columns: side, rows: side, shade: threshold },
    { x: side + gap, y: 0, columns: side, rows: side, shade: dithered((x, y) => greys[y * side + x]) },
    { x: 0, y: side + gap, columns: whole, rows: band, shade: dithered((x) => (256 * x) / whole) },
  ];
  const canvas = new OffscreenCanvas(whole, side + gap + band);
  const context = canvas.getContext("2d");
  for (const { x, y, columns, rows, shade } of parts) {
    const image = new ImageData(columns, rows);
    const pixels = new Uint32Array(image.data.buffer);
    for (let i = 0; i < pixels.length; ++i) pixels[i] = 0xff000000 | (0x010101 * shade(i % columns, Math.floor(i / columns)));
    context.putImageData(image, x, y);
  }
  return { width, height, canvas };
}
