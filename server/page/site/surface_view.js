// SPDX-License-Identifier: GPL-3.0-or-later
// A surface with points on it, or points in space, which the user can turn, move and zoom by mouse, touch, keys and
// buttons. The page loads this module only when it shows one of them.

import { colour } from "./dom.js";
import { CanvasPainter } from "./surface_canvas.js";
import { sceneOf } from "./surface_scene.js";
import { WebglPainter } from "./surface_webgl.js";
import { arrows, barButton, Viewport } from "./viewport.js";

export { sampleMesh, sceneOf } from "./surface_scene.js";

const dotShare = 0.3;  // radius of a disc, in mean distances of points
const minRadius = 0.9;  // CSS pixels; minimum radius of a disc
const lineWidth = 1;  // CSS pixels; width of the edges of a triangulation
const turnPerPixel = 0.01;  // radians per CSS pixel
const turnPerStep = Math.PI / 12;  // radians per key press
const light = [0.35, 0.45, 0.82];
const movePerStep = 40;  // CSS pixels per key press with Shift
const symbols = { ArrowLeft: ["\u2190", "left"], ArrowRight: ["\u2192", "right"], ArrowUp: ["\u2191", "up"], ArrowDown: ["\u2193", "down"] };

const nothing = sceneOf({ vertices: [], triangles: [] }, { points: [], normals: [] });

/** Returns the product of two rotations, each as nine numbers in columns. */
const product = (a, b) => b.map((_, i) => [0, 1, 2].reduce((sum, k) => sum + a[3 * k + (i % 3)] * b[3 * Math.floor(i / 3) + k], 0));

/** Returns the rotation by an angle around the horizontal axis of the screen, then around the vertical one. */
function rotation(horizontal, vertical) {
  const [c, s, d, t] = [Math.cos(horizontal), Math.sin(horizontal), Math.cos(vertical), Math.sin(vertical)];
  return product([d, 0, -t, 0, 1, 0, t, 0, d], [1, 0, 0, 0, c, s, 0, -s, c]);
}

/** Reads a colour of the style sheet, in the form #rrggbb, as numbers from 0 to 1. */
const numbersOf = (name) => colour(name).match(/[0-9a-f]{2}/g).map((pair) => parseInt(pair, 16) / 255);

export class SurfaceView extends Viewport {
  #painter;
  #turn = [1, 0, 0, 0, 1, 0, 0, 0, 1];
  #start = this.#turn;
  #scene = nothing;
  #first = 0;
  #hasEdges = false;

  constructor(canvas, bar) {
    super(canvas, bar, () => {}, { swipes: () => false });
    const gl = canvas.getContext("webgl2", { antialias: true });
    this.#painter = gl ? new WebglPainter(gl) : new CanvasPainter(canvas.getContext("2d"));
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { this.#painter.restore(); this.redraw(); });
    bar.append(...Object.entries(symbols).map(([key, [text, direction]]) =>
      barButton(text, `Turn ${direction}`, () => this.step(...arrows[key]))));
  }

  /**
   * Shows a scene. Keeps the rotation if the object is the same as before.
   *
   * @param scene      result of `sceneOf` or `volumeSceneOf`
   * @param object     file or domain that is shown
   * @param isUpright  whether the y axis points up, instead of the z axis
   * @param hasEdges   whether to draw the edges of the mesh
   */
  show(scene, { object, isUpright, hasEdges }) {
    this.#scene = scene;
    this.#hasEdges = hasEdges;
    if (this.object !== object) {
      this.object = object;
      this.#start = product(rotation(0.35, 0), product(rotation(0, -0.5), rotation(isUpright ? 0 : -Math.PI / 2, 0)));
      this.reset();
    }
    this.redraw();
  }

  /** Sets the number of points to show, in the sequence of their ranks. */
  showFirst(first) {
    this.#first = first;
    this.redraw();
  }

  clear() {
    this.#scene = nothing;
    this.redraw();
  }

  reset() {
    this.#turn = this.#start;
    this.fit();
  }

  #turnBy(x, y) {
    this.#turn = product(rotation(y, x), this.#turn);
    this.redraw();
  }

  /** Turns the surface like a ball that the pointer drags. */
  move(x, y) {
    this.#turnBy(turnPerPixel * x, turnPerPixel * y);
  }

  step(x, y, isShifted) {
    if (isShifted) super.move(movePerStep * x, movePerStep * y);
    else this.#turnBy(turnPerStep * x, turnPerStep * y);
  }

  paint(canvas) {
    const { width, height } = this.size;
    if (width === 0) return;
    const { scale } = this;
    this.#painter.draw(this.#scene, {
      turn: this.#turn, x: this.x + scale / 2, y: this.y + scale / 2, scale, width, height, ratio: devicePixelRatio,
      radius: Math.max(dotShare * this.#scene.pitch, minRadius / scale), first: Math.min(this.#first, this.#scene.points.length / 3), light, lineWidth: this.#hasEdges ? lineWidth : 0,
      colours: { surface: numbersOf("--surface"), ink: numbersOf("--ink"), line: numbersOf("--accent"), paper: numbersOf("--panel") },
    });
  }
}
