// A shape becomes points.

import { capabilities } from "./api.js";
import { chart } from "./chart.js";
import { acceptDrops, colour, count, seconds } from "./dom.js";
import { Drawing } from "./drawing.js";
import { Fields } from "./fields.js";
import { postPatiently } from "./jobs.js";
import { Panel } from "./panel.js";
import { areaOf, boundsOf, firstPolygon, geometryOf, rectangle, ringsOf, unitTorus } from "./shape.js";
import { Snippets } from "./snippets.js";
import { Viewport } from "./viewport.js";

const mostFrames = 64;
const dotShare = 0.3;  // a dot's radius over the mean spacing

const { formats, methods } = capabilities.sample;
const [standard] = methods;
const methodNamed = (name = standard.name) => methods.find((method) => method.name === name);

const fields = [
  { kind: "number", name: "sites", label: "Points", value: 1000, min: 10, max: 50000, step: 1, log: true },
  { kind: "choice", name: "method", label: "Method", standard: standard.name, choices: methods.map(({ name, title }) => [name, title]) },
  { kind: "choice", name: "quality", label: "Quality", standard: "standard", choices: [["standard", "standard"], ["draft", "draft: without polish"], ["best", "best"]] },
  { kind: "number", name: "seed", label: "Seed", value: 0, min: 0, max: 100, step: 1, standard: 0 },
];

export class Sample extends Panel {
  #shapes = { polygon: structuredClone(firstPolygon), rectangle: { domain: rectangle }, torus: { domain: unitTorus } };
  #frames = new Map();
  #result = null;

  constructor(element) {
    super(element);
    this.canvas = this.find("canvas");
    this.shapeChoice = this.find("#shape");
    this.corners = this.find("#corners");
    this.iteration = this.find("#iteration");
    this.mesh = this.find("#mesh");
    this.tiles = this.find("#tiles");
    this.viewport = new Viewport(this.canvas, this.find(".zoom"), (...args) => this.#draw(...args),
      { margin: 28, press: (at) => this.#press(at) });
    this.drawing = new Drawing({
      toScreen: (corner) => this.#toScreen(corner), toShape: (at) => this.#toShape(at),
      changed: (moving) => this.#shapeMoved(moving),
    });
    this.fields = new Fields(this.find("form"), fields, (draft) => this.refresh(draft));
    this.snippets = new Snippets(this.find(".snippets"));
    this.addDownloads(formats, "points", (format, signal) => this.#ask({ ...this.body(), format }, signal));
    this.#listen();
    this.#shapeChosen();
  }

  get shape() {
    return this.#shapes[this.shapeChoice.value] ?? null;
  }

  /** What was made last: {points, shape, method}; null if nothing was. */
  get result() {
    return this.#result;
  }

  #listen() {
    this.shapeChoice.addEventListener("change", () => { this.#shapeChosen(); this.refresh(); });
    this.find(".draw").addEventListener("click", () => this.#startDrawing(false));
    this.find(".hole").addEventListener("click", () => this.#startDrawing(true));
    this.canvas.addEventListener("keydown", (event) => this.#drawingKey(event));
    this.corners.addEventListener("change", () => this.#takeCorners());
    this.iteration.addEventListener("input", () => this.refresh(true));
    this.iteration.addEventListener("change", () => this.refresh());
    this.mesh.addEventListener("change", () => this.refresh());
    this.tiles.addEventListener("change", () => this.#refit());
    this.find(".file").addEventListener("change", ({ target }) => {
      if (target.files.length > 0) this.#takeFile(target.files[0]);
      target.value = "";
    });
    acceptDrops(this.find(".drop"), (file) => this.#takeFile(file));
  }

  #tellOfShape(text) {
    this.find("#shape-error").textContent = text;
  }

  async #takeFile(file) {
    this.element.dataset.state = "busy";
    const geometry = await file.text().then(JSON.parse).then(geometryOf).catch(() => null);
    if (!geometry) {
      this.element.dataset.state = "failed";
      return this.#tellOfShape(`${file.name} holds no GeoJSON Polygon or MultiPolygon`);
    }
    this.#shapes.geometry = { geometry };
    this.shapeChoice.value = "geometry";
    this.#shapeChosen();
    this.refresh();
  }

  #takeCorners() {
    try {
      const { polygon, holes } = JSON.parse(this.corners.value);
      this.#shapes.polygon = { polygon, ...(holes?.length > 0 && { holes }) };
      boundsOf(ringsOf(this.#shapes.polygon));
    } catch {
      return this.#tellOfShape('the corners must be JSON: {"polygon": [[x, y], ...], "holes": [[[x, y], ...], ...]}');
    }
    this.#shapeChosen();
    this.refresh();
  }

  #shapeChosen() {
    const kind = this.shapeChoice.value;
    this.find(".polygon-tools").hidden = this.find(".corners").hidden = kind !== "polygon";
    this.tiles.disabled = kind !== "torus";
    if (kind !== "torus") this.tiles.checked = false;
    this.corners.value = JSON.stringify(this.#shapes.polygon);
    this.#stopDrawing();
    this.#tellOfShape(this.shape ? "" : "choose or drop a GeoJSON file");
    if (this.shape) this.#refit();
  }

  /** What is shown: the shape, with the sheet's rest when one is drawn. */
  #refit() {
    const bounds = boundsOf(ringsOf(this.shape));
    const [width, height] = [bounds.maxX - bounds.minX, bounds.maxY - bounds.minY];
    const around = this.tiles.checked ? 1 : 0;
    this.view = { minX: bounds.minX - around * width, maxY: bounds.maxY + around * height };
    this.viewport.content = { width: width * (1 + 2 * around), height: height * (1 + 2 * around) };
  }

  #toScreen([x, y]) {
    const { scale, x: left, y: top } = this.viewport;
    return { x: left + (x - this.view.minX) * scale, y: top + (this.view.maxY - y) * scale };
  }

  /** Rounded to a tenth of a pixel or so, for requests that are short to read. */
  #toShape(at) {
    const { x, y } = this.viewport.toContent(at);
    const digits = Math.max(0, Math.ceil(Math.log10(this.viewport.scale)));
    return [x + this.view.minX, this.view.maxY - y].map((value) => Number(value.toFixed(digits)));
  }

  #startDrawing(hole) {
    this.drawing.start((ring) => {
      const { polygon, holes = [] } = this.#shapes.polygon;
      this.#shapes.polygon = hole ? { polygon, holes: [...holes, ring] } : { polygon: ring };
      this.#shapeChosen();
      this.refresh();
    });
    if (!hole) this.#result = null;
    const hint = this.find(".drawing-hint");
    hint.hidden = false;
    hint.textContent = "Press for corners, the first one to close. Enter closes, Backspace undoes, Escape ends.";
    this.canvas.classList.add("drawing");
    this.canvas.focus();
    this.viewport.redraw();
  }

  #stopDrawing() {
    this.drawing.cancel();
    this.find(".drawing-hint").hidden = true;
    this.canvas.classList.remove("drawing");
  }

  #drawingKey({ key }) {
    if (!this.drawing.ring) return;
    if (key === "Enter") this.drawing.close();
    if (key === "Backspace") this.drawing.undo();
    if (key === "Escape") {
      this.#stopDrawing();
      this.refresh();
    }
    this.viewport.redraw();
  }

  #press(at) {
    return this.shapeChoice.value === "polygon" ? this.drawing.press(at, ringsOf(this.shape)) : null;
  }

  #shapeMoved(moving) {
    this.viewport.redraw();
    if (this.drawing.ring) return;
    this.corners.value = JSON.stringify(this.#shapes.polygon);
    this.refresh(moving);
  }

  get #lastIteration() {
    return Number(this.iteration.max);
  }

  /** The request of what is shown. Only the last frame is polished: the others are steps on the way there. */
  body(iteration = Number(this.iteration.value)) {
    const body = { ...this.fields.values(), ...this.shape };
    const { options } = methodNamed(body.method);
    if (!options.includes("quality")) delete body.quality;
    else if (iteration < this.#lastIteration) body.quality = "draft";
    if (options.includes("iterations")) body.iterations = iteration;
    if (this.mesh.checked) body.mesh = true;
    return body;
  }

  #ask(body, signal, told = this.tell) {
    return postPatiently("/sample", JSON.stringify(body), body, { type: "application/json", signal, told });
  }

  /** Answers are the same each time, so one is enough. */
  async #frame(body, signal, told) {
    const key = JSON.stringify(body);
    if (!this.#frames.has(key)) {
      const frame = await (await this.#ask(body, signal, told)).json();
      if (this.#frames.size >= mostFrames) this.#frames.delete(this.#frames.keys().next().value);
      this.#frames.set(key, frame);
    }
    return this.#frames.get(key);
  }

  /** What is to be made now: as `result`. A draft is not polished, unless it has been already. */
  async fetch(signal, { draft = false, told } = {}) {
    const shape = structuredClone(this.shape);
    const body = this.body();
    if (draft && methodNamed(body.method).options.includes("quality") && !this.#frames.has(JSON.stringify(body))) body.quality = "draft";
    return { ...(await this.#frame(body, signal, told)), shape };
  }

  refresh(draft = false) {
    this.find("output[for=iteration]").textContent = this.iteration.value;
    if (!this.shape || this.drawing.ring) return;
    const body = this.body();
    const { options } = methodNamed(body.method);
    this.iteration.disabled = !options.includes("iterations");
    this.fields.enable("quality", options.includes("quality"));
    this.snippets.showSample({ body });
    this.wish(async (signal) => {
      const start = performance.now();
      const frame = await this.fetch(signal, { draft });
      if (signal.aborted) return;
      this.#result = frame;
      this.viewport.redraw();
      if (!draft) this.status.textContent = `${count(frame.sites)} points, variation ${frame.variation.toFixed(3)}, ${seconds(start)}`;
      if (!draft || this.#frames.has(JSON.stringify(this.body(this.#lastIteration)))) await this.#showTrace(signal);
    }, draft);
  }

  async #showTrace(signal) {
    const place = this.find(".trace");
    place.hidden = !methodNamed(this.body().method).options.includes("iterations");
    if (place.hidden) return;
    const { trace } = await this.#frame(this.body(this.#lastIteration), signal);
    const points = trace.map(({ iteration, variation }) => [iteration, variation]);
    const at = points.find(([iteration]) => iteration === Number(this.iteration.value)) ?? points.at(-1);
    place.querySelector("svg")?.remove();
    place.append(chart({
      label: `Variation from ${points[0][1].toFixed(2)} to ${points.at(-1)[1].toFixed(3)}; ${at[1].toFixed(3)} after iteration ${at[0]}`,
      size: { width: Math.max(place.clientWidth, 300), height: 130 },
      x: { min: 0, max: this.#lastIteration, ticks: points.map(([iteration]) => iteration) },
      y: { min: 0.01, max: 1, ticks: [0.01, 0.1, 1], log: true },
      curves: [{ points, mark: at }],
    }));
  }

  place(errors) {
    const left = this.fields.show(errors);
    const aboutShape = left.filter(({ pointer }) => /^\/?(polygon|holes|geometry|domain)/.test(pointer));
    this.#tellOfShape(aboutShape.map(({ detail }) => detail).join("; "));
    return left.filter((error) => !aboutShape.includes(error));
  }

  #draw(context) {
    if (!this.shape) return;
    this.#drawOutline(context);
    const result = this.#result;
    if (result) {
      for (const offset of this.#tileOffsets()) this.#drawResult(context, result, offset);
    }
    if (this.shapeChoice.value === "polygon") this.#drawCorners(context);
  }

  #tileOffsets() {
    if (!this.tiles.checked) return [[0, 0]];
    const { width, height } = this.shape.domain;
    return [-1, 0, 1].flatMap((row) => [-1, 0, 1].map((column) => [column * width, row * height]));
  }

  #path(context, ring) {
    ring.forEach((corner, i) => {
      const { x, y } = this.#toScreen(corner);
      if (i === 0) context.moveTo(x, y);
      else context.lineTo(x, y);
    });
  }

  #drawOutline(context) {
    const rings = this.drawing.ring && !this.#result ? [] : ringsOf(this.shape);
    for (const [dx, dy] of this.#tileOffsets()) {
      context.beginPath();
      for (const ring of rings) {
        this.#path(context, ring.map(([x, y]) => [x + dx, y + dy]));
        context.closePath();
      }
      context.fillStyle = colour("--panel");
      context.fill("evenodd");
      context.strokeStyle = colour("--line");
      context.stroke();
    }
  }

  #drawResult(context, result, [dx, dy]) {
    const rings = ringsOf(result.shape);
    const radius = Math.max(dotShare * Math.sqrt(areaOf(rings) / result.points.length) * this.viewport.scale, 0.7);
    if (result.triangles && this.mesh.checked) this.#drawMesh(context, result, [dx, dy]);
    context.fillStyle = colour(dx === 0 && dy === 0 ? "--ink" : "--quiet");
    context.beginPath();
    for (const [px, py] of result.points) {
      const { x, y } = this.#toScreen([px + dx, py + dy]);
      context.moveTo(x + radius, y);
      context.arc(x, y, radius, 0, 2 * Math.PI);
    }
    context.fill();
  }

  /** On a torus an edge goes to the nearest copy of its other end. */
  #drawMesh(context, { vertices, triangles, shape }, [dx, dy]) {
    const period = shape.domain?.type === "torus" ? shape.domain : null;
    const near = (from, to, side) => (period ? to - side * Math.round((to - from) / side) : to);
    context.beginPath();
    for (const triangle of triangles) {
      const [ax, ay] = vertices[triangle[0]];
      this.#path(context, triangle.map((index) => vertices[index]).map(([x, y]) =>
        [near(ax, x, period?.width) + dx, near(ay, y, period?.height) + dy]));
      context.closePath();
    }
    context.strokeStyle = colour("--accent");
    context.lineWidth = 0.7;
    context.stroke();
    context.lineWidth = 1;
  }

  #drawCorners(context) {
    const drawn = this.drawing.ring;
    if (drawn) {
      context.beginPath();
      this.#path(context, drawn);
      context.strokeStyle = colour("--accent");
      context.stroke();
    }
    context.fillStyle = colour("--accent");
    const rings = drawn ? [drawn] : ringsOf(this.shape);
    for (const corner of rings.flat()) {
      const { x, y } = this.#toScreen(corner);
      context.fillRect(x - 4, y - 4, 8, 8);
    }
  }
}
