// SPDX-License-Identifier: GPL-3.0-or-later
// Makes the dots of <ccdt-halftone> in the browser, as drafts while they change. element.js loads this module.

import type { RequestOptions } from "./types.js";
import { bitmapOf, LocalClient } from "./wasm.js";

/** A picture, or an element of the page that shows one. */
type Source = Blob | HTMLVideoElement | HTMLCanvasElement | HTMLImageElement;

interface HalftoneElement extends HTMLElement {
  refresh(): void;
}

const draftOptions = { quality: "draft", iterations: "1", passes: "2" };
const measure = "ccdt-halftone";  // name of the entry with the duration of the last answer
const draftSide = 640;  // pixels; longest side of the pictures of drafts

const clients = new Map<string | null, LocalClient>();  // by the address of their server
const followers = new WeakSet<HalftoneElement>();  // elements that the next frame of a video will refresh

const nextFrameOf = (video: HTMLVideoElement) => new Promise((resume) => video.requestVideoFrameCallback(resume));

/** Returns the picture that a source shows now. Waits for the first frame of a video. */
async function imageOf(source: Source): Promise<ImageBitmap> {
  for (;;) {
    try {
      return await createImageBitmap(source);
    } catch (error) {
      if (!(source instanceof HTMLVideoElement)) throw error;
      await nextFrameOf(source);
    }
  }
}

/** Returns the pixels that a source shows now as BMP, reduced to a longest side of `maxSide`. */
async function pixelsOf(source: Source, maxSide: number): Promise<Blob> {
  const image = await imageOf(source);
  const scale = Math.min(maxSide / Math.max(image.width, image.height), 1);
  const [width, height] = [image.width, image.height].map((side) => Math.max(Math.round(scale * side), 1)) as [number, number];
  const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true })!;
  context.imageSmoothingQuality = "high";
  context.drawImage(image, 0, 0, width, height);
  image.close();
  return new Blob([bitmapOf(context.getImageData(0, 0, width, height))]);
}

/** Refreshes an element with the next frame of its video after the dots of this one are visible. */
function follow(element: HalftoneElement, video: HTMLVideoElement): void {
  if (followers.has(element)) return;
  followers.add(element);
  element.addEventListener("load", async () => {
    await nextFrameOf(video);
    followers.delete(element);
    if (element.isConnected) element.refresh();
  }, { once: true });
}

/**
 * Returns the client of an element. Its server, if it has one, answers what takes long.
 * @param isDraft  whether answers are for a moment only, because the picture or the options are changing
 */
export function clientOf(element: HalftoneElement, isDraft: boolean) {
  const server = element.getAttribute("server");
  const client = clients.get(server) ?? new LocalClient(server ? { server } : {});
  clients.set(server, client);
  return {
    /** Answers a request of the element as its Connection to a server does, but by SVG, or by BMP for a device. */
    async request(method: string, path: string, { body, ...options }: RequestOptions & { body: Source }): Promise<Response> {
      if (body instanceof HTMLVideoElement) follow(element, body);
      const query = new URLSearchParams(path.split("?")[1]);
      const isDevice = query.has("device");
      query.set("format", isDevice ? "bmp" : "svg");
      query.delete("antialias");  // browsers do so
      if (isDraft && !isDevice) for (const [name, value] of Object.entries(draftOptions)) query.set(name, value);
      const isReduced = isDraft && !query.has("scale");  // scales count pixels of the picture
      const picture = isReduced || !(body instanceof Blob) ? await pixelsOf(body, isReduced ? draftSide : Infinity) : body;
      const start = performance.now();
      const response = await client.request(method, `halftone?${query}`, { ...options, body: picture });
      performance.clearMeasures(measure);
      performance.measure(measure, { start });
      return response;
    },
  };
}
