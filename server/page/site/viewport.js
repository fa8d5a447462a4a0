// SPDX-License-Identifier: GPL-3.0-or-later
// A canvas whose content the user can move and zoom by mouse, touch, keys and buttons.

import { make } from "./dom.js";

const zoomStep = 1.25;
const step = 40;  // CSS pixels
/** Directions of the arrow keys on the screen, whose y axis points down. */
export const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** Creates a button for the bar of a view. */
export function barButton(text, label, act) {
  const element = make("button", { type: "button", textContent: text, attributes: { "aria-label": label } });
  element.addEventListener("click", act);
  return element;
}

export class Viewport {
  #canvas;
  #draw;
  #content = { width: 1, height: 1 };
  #fitted = true;
  #pointers = new Map();
  #scheduled = false;
  #fit = 1;
  scale = 1;
  x = 0;
  y = 0;

  /** Scale that is shown as 100 %; null: the scale at which the content fits. */
  unit = null;

  /**
   * @param canvas   canvas, in a parent element that determines its size
   * @param bar      parent of the buttons
   * @param draw     called with a drawing context, whose unit is a CSS pixel, and with this viewport
   * @param options  `margin` in CSS pixels, and `press(point)`. If `press` returns a function, the press does not move
   *                 the content; the function is called with the following points and finally with null. While
   *                 `swipes()` is true, a finger on content that fits scrolls the page
   */
  constructor(canvas, bar, draw, { margin = 16, press = () => null, swipes = () => true } = {}) {
    this.#canvas = canvas;
    this.#draw = draw;
    this.margin = margin;
    this.press = press;
    this.swipes = swipes;
    this.#addButtons(bar);
    this.#listen();
    this.#observe(new ResizeObserver(([entry]) => this.#resize(entry.devicePixelContentBoxSize?.[0])));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.redraw());
  }

  get size() {
    return { width: this.#canvas.clientWidth, height: this.#canvas.clientHeight };
  }

  /** Sets the size of the content, in its own units. */
  set content({ width, height }) {
    const same = width === this.#content.width && height === this.#content.height;
    this.#content = { width, height };
    if (same) this.redraw();
    else this.fit();
  }

  fit() {
    const { width, height } = this.size;
    if (width === 0) return;
    this.#fitted = true;
    const room = (side) => Math.max(side - 2 * this.margin, 1);
    this.#fit = Math.min(room(width) / this.#content.width, room(height) / this.#content.height);
    this.scale = this.#fit;
    this.x = (width - this.scale * this.#content.width) / 2;
    this.y = (height - this.scale * this.#content.height) / 2;
    this.redraw();
  }

  /** Shows a part of the content as large as possible. */
  frame({ x, y, width, height }) {
    this.#fitted = false;
    const room = (side) => Math.max(side - 2 * this.margin, 1);
    this.scale = Math.min(room(this.size.width) / width, room(this.size.height) / height);
    this.x = this.size.width / 2 - this.scale * (x + width / 2);
    this.y = this.size.height / 2 - this.scale * (y + height / 2);
    this.redraw();
  }

  zoom(factor, at = { x: this.size.width / 2, y: this.size.height / 2 }) {
    const scale = Math.min(Math.max(this.scale * factor, this.#fit / 4), this.#fit * 1000);
    this.x = at.x - ((at.x - this.x) * scale) / this.scale;
    this.y = at.y - ((at.y - this.y) * scale) / this.scale;
    this.scale = scale;
    this.#fitted = false;
    this.redraw();
  }

  move(x, y) {
    this.x += x;
    this.y += y;
    this.#fitted = false;
    this.redraw();
  }

  /** Restores the initial view. */
  reset() {
    this.fit();
  }

  /** Moves the view in the direction of an arrow key. */
  step(x, y) {
    this.move(-step * x, -step * y);
  }

  toContent({ x, y }) {
    return { x: (x - this.x) / this.scale, y: (y - this.y) / this.scale };
  }

  /** Whether one finger scrolls the page. Otherwise, users of phones could not scroll past the picture. */
  get #leavesSwipes() {
    return this.#fitted && this.swipes();
  }

  redraw() {
    if (this.#scheduled) return;
    this.#scheduled = true;
    requestAnimationFrame(() => {
      this.#scheduled = false;
      this.#canvas.style.touchAction = this.#leavesSwipes ? "pan-y" : "none";
      this.paint(this.#canvas);
      this.percent.textContent = `${Math.round(100 * this.scale / (this.unit ?? this.#fit))} %`;
    });
  }

  paint(canvas) {
    const context = canvas.getContext("2d");
    context.resetTransform();
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.scale(devicePixelRatio, devicePixelRatio);
    this.#draw(context, this);
  }

  /** Observes the size of the canvas, in device pixels except in Safari, which does not support this. */
  #observe(observer) {
    try {
      observer.observe(this.#canvas, { box: "device-pixel-content-box" });
    } catch {
      observer.observe(this.#canvas);
    }
  }

  /** Gives the canvas one pixel per device pixel, so that the browser does not scale it. */
  #resize(pixels) {
    const { width, height } = this.size;
    if (width === 0) return;
    // Browsers that emulate another device pixel ratio report physical pixels. Such sizes are ignored.
    const inPixels = (length, reported) => {
      const rounded = Math.round(length * devicePixelRatio);
      return Math.abs(reported - rounded) <= 1 ? reported : rounded;
    };
    this.#canvas.width = inPixels(width, pixels?.inlineSize);
    this.#canvas.height = inPixels(height, pixels?.blockSize);
    if (this.#fitted) this.fit();
    else this.redraw();
  }

  #addButtons(bar) {
    this.percent = make("output", { attributes: { "aria-label": "Zoom", "aria-live": "off" } });
    bar.append(barButton("\u2212", "Zoom out", () => this.zoom(1 / zoomStep)), this.percent,
      barButton("+", "Zoom in", () => this.zoom(zoomStep)), barButton("Fit", "Fit", () => this.reset()));
  }

  #listen() {
    const canvas = this.#canvas;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY * (event.deltaMode === 0 ? 0.002 : 0.06)), this.#place(event));
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#moved(event));
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => this.#up(event));
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  #place(event) {
    return { x: event.offsetX, y: event.offsetY };
  }

  #down(event) {
    if (event.button !== 0) return;
    this.#canvas.setPointerCapture(event.pointerId);
    const at = this.#place(event);
    this.taken = this.#pointers.size === 0 ? this.press(at) : null;
    this.#pointers.set(event.pointerId, at);
  }

  #moved(event) {
    const before = this.#pointers.get(event.pointerId);
    if (!before) return;
    const at = this.#place(event);
    this.#pointers.set(event.pointerId, at);
    if (this.taken) return this.taken(at);
    const other = [...this.#pointers].find(([id]) => id !== event.pointerId)?.[1];
    if (!other && this.#leavesSwipes && event.pointerType === "touch") return;
    if (!other) return this.move(at.x - before.x, at.y - before.y);
    const distance = (p) => Math.max(Math.hypot(p.x - other.x, p.y - other.y), 1);
    this.zoom(distance(at) / distance(before), { x: (at.x + other.x) / 2, y: (at.y + other.y) / 2 });
  }

  #up(event) {
    if (!this.#pointers.delete(event.pointerId)) return;
    this.taken?.(null);
    this.taken = null;
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "+" || event.key === "=") this.zoom(zoomStep);
    else if (event.key === "-") this.zoom(1 / zoomStep);
    else if (event.key === "0") this.reset();
    else if (arrows[event.key]) this.step(...arrows[event.key], event.shiftKey);
    else return;
    event.preventDefault();
  }
}
