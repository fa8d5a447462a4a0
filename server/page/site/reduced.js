// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures made smaller, so that drafts of large ones are quick to send and to read.

const mostPixels = 300_000;

/** Whether a picture has more pixels than drafts need; one that the browser cannot draw (null) is taken as it is. */
export const isLarge = (bitmap) => bitmap !== null && bitmap.width * bitmap.height > mostPixels;

/**
 * @param bitmap  a large picture as it is seen
 * @returns  {blob, factor}: it with at most 300,000 pixels, and how many times wider the whole one is
 */
export async function reduced(bitmap) {
  const share = Math.sqrt(mostPixels / (bitmap.width * bitmap.height));
  const side = (length) => Math.max(1, Math.floor(share * length));
  const canvas = new OffscreenCanvas(side(bitmap.width), side(bitmap.height));
  const context = canvas.getContext("2d");
  context.imageSmoothingQuality = "high";
  context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  const blob = await canvas.convertToBlob({ type: "image/webp", quality: 0.9 });
  return { blob, factor: bitmap.width / canvas.width };
}
