// SPDX-License-Identifier: GPL-3.0-or-later
// Reduces large pictures, so that drafts can be sent and decoded quickly.

const maxPixels = 300_000;

/** Whether a picture has more than `maxPixels` pixels. False for null, a picture that the browser cannot decode. */
export const isLarge = (bitmap) => bitmap !== null && bitmap.width * bitmap.height > maxPixels;

/**
 * Reduces a picture to at most 300,000 pixels.
 *
 * @param bitmap  a decoded large picture
 * @returns       {blob, factor}: the reduced picture as WebP, and original width / reduced width
 */
export async function reduced(bitmap) {
  const share = Math.sqrt(maxPixels / (bitmap.width * bitmap.height));
  const side = (length) => Math.max(1, Math.floor(share * length));
  const canvas = new OffscreenCanvas(side(bitmap.width), side(bitmap.height));
  const context = canvas.getContext("2d");
  context.imageSmoothingQuality = "high";
  context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  const blob = await canvas.convertToBlob({ type: "image/webp", quality: 0.9 });
  return { blob, factor: bitmap.width / canvas.width };
}
