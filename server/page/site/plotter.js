// SPDX-License-Identifier: GPL-3.0-or-later
// Controls for a drawing by a plotter: paper, pen and time limit. Shows the length of the path and the duration.

import { element as shape } from "./chart.js";
import { count, make, metres } from "./dom.js";
import { Fields } from "./fields.js";
import { marksField, paperChoices, papers, suited } from "./print_options.js";

/** Styles in which the pen fills dots that are wider than the pen. */
const fillings = ["spiral", "circles"];

const fields = [
  { kind: "choice", name: "paper", label: "Paper", choices: [...paperChoices, ["none", "custom width"]] },
  { kind: "number", name: "margin_mm", label: "Minimum margin, mm", value: 10, min: 0, max: 50, step: 1 },
  marksField,
  { kind: "number", name: "width_mm", label: "Width, mm", value: 200, min: 20, max: 2000, step: 1, log: true },
  { kind: "number", name: "pen_mm", label: "Pen width, mm", value: 0.7, min: 0.1, max: 5, log: true,
    help: "The width of the lines that the pen draws. Strokes and circles make dots of this width. A wider pen needs fewer dots." },
  { kind: "choice", name: "style", label: "Dots are", choices: [["stroke", "short strokes"], ["fill", "circles"], ["spiral", "spirals"], ["circles", "nested circles"], ["path", "joined by a line"]],
    help: "For a short stroke, the pen goes down and up. Plotter software draws circles as outlines, or fills them. Spirals and nested circles fill dots that are wider than the pen. A line through all dots replaces the dots." },
  { kind: "check", name: "closed", label: "Closed tour", standard: false, help: "The line ends where it starts." },
  { kind: "number", name: "dot_mm", label: "Dot width, mm", value: 2, min: 0.2, max: 20, log: true,
    help: "The pen fills each dot with turns that are one pen width apart." },
  { kind: "number", name: "minutes", label: "Time limit, min", value: 45, min: 5, max: 600, step: 1, log: true, auto: true, free: "none",
    help: "The drawing gets as many dots as the pen can draw in this time. If these are too few, the drawing is too light. A wider pen corrects this." },
  { kind: "number", name: "speed", label: "Speed, mm/s", value: 100, min: 5, max: 500, step: 1, log: true },
  { kind: "number", name: "lift", label: "Pen lift, seconds", value: 0.15, min: 0.01, max: 2, log: true,
    help: "Time that the pen needs to go down and up again, for each stroke." },
  { kind: "number", name: "dwell", label: "Burning time of a dot, seconds", value: 0.075, min: 0, max: 2, step: 0.005 },
  { kind: "choice", name: "split", label: "Files", standard: "one", choices: [["one", "one"], ["ink", "one for each ink"], ["time", "parts of limited time"]],
    help: "Several files are saved in one ZIP file. They have the same page, so they fit together." },
  { kind: "number", name: "part_minutes", label: "Time per file, min", value: 30, min: 1, max: 600, step: 1, log: true },
  { kind: "choice", name: "machine", label: "G-code: machine", standard: "grbl", choices: [["grbl", "GRBL"], ["marlin", "Marlin"], ["laser", "laser of GRBL"]] },
  { kind: "choice", name: "dwell_unit", label: "G-code: dwell", standard: "auto", choices: [["auto", "as the machine"], ["s", "seconds"], ["ms", "milliseconds"]] },
  { kind: "text", name: "pen_down", label: "G-code: pen down",
    help: "Commands that lower the pen. Separate lines by |. Empty: those of the machine, M3 S1000 for GRBL. For a Z axis: G1 Z-1 F300." },
  { kind: "text", name: "pen_up", label: "G-code: pen up",
    help: "Commands that lift the pen. Separate lines by |. Empty: those of the machine, M5 for GRBL. For a Z axis: G0 Z2." },
];

/** Formats a duration in hours and minutes, in minutes, or in seconds. */
function duration(seconds) {
  const minutes = Math.round(seconds / 60);
  if (minutes >= 60) return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
  return seconds >= 60 ? `${minutes} min` : `${Math.round(seconds)} s`;
}

function fillLength(style, width, pen) {
  const reach = (width - pen) / 2;
  if (reach <= 0) return 0;
  if (style === "spiral") return Math.PI * reach * (Math.ceil(reach / pen) + 2);
  const inner = Math.min(reach, pen / 2);
  return Math.PI * (reach + inner) * (Math.ceil((reach - inner) / pen) + 1);
}

/**
 * Measures the path of the pen through a layer of an SVG drawing.
 * @returns  {dots, strokes, path}: `path` is the length of all moves, in units of the drawing
 */
function pathOf(part, style) {
  let [strokes, corners, path, before, start] = [0, 0, 0, null, null];
  const go = (here) => {
    if (before) path += Math.hypot(here[0] - before[0], here[1] - before[1]);
    before = here;
  };
  for (const [text, command, x, y, cx = x, cy = y] of part.matchAll(/([ML])([-\d.e]+) ([-\d.e]+)|cx="([^"]+)" cy="([^"]+)"|Z"/g)) {
    go(text === 'Z"' ? start : [Number(cx), Number(cy)]);
    if (text === 'Z"') continue;  // the line is closed
    ++corners;
    if (command === "L") continue;
    start = before;
    ++strokes;
  }
  return { dots: style === "path" ? corners : strokes, strokes, path };
}

/** Returns the layers of a drawing: [{name, colour, dots, strokes, path}]. A drawing without layers is one layer. */
function layersOf(svg, style) {
  const parts = svg.split(/inkscape:groupmode="layer" inkscape:label="([^"]*)"/);
  const named = parts.length === 1 ? [["dots", svg]] : parts.slice(1).flatMap((name, i, all) => (i % 2 ? [] : [[name, all[i + 1]]]));
  return named.map(([name, part]) => ({ name, colour: part.match(/(?:stroke|fill)="(#[0-9a-f]+)"/)?.[1], ...pathOf(part, style) }));
}

export class Plotter {
  #shownOptions = null;  // options of the current drawing; null if there is none, or a new one was requested
  #layers = [];

  /**
   * @param place    parent of the form
   * @param size     returns the width and height of the drawing, in its own units
   * @param plan     returns {sites, inks} for estimates: `sites` is the number of dots, if fixed; `inks` is a result of
   *                 `inksOf`. Returns null if unknown
   * @param isTimed  whether a time limit may determine the number of dots
   * @param dot      returns the option `dot` for a radius and the width of the drawing, both in mm
   * @param changed  called when options of a request change; the argument tells whether the change is a draft
   * @param turned   called with true when the pen is turned on, with false when it is turned off
   * @param noted    called when a setting that does not affect requests changes
   */
  constructor(place, { size, plan, isTimed = false, dot, changed, turned, noted }) {
    Object.assign(this, { size, plan, isTimed, dot, changed, noted });
    const form = make("form", { noValidate: true });
    this.box = make("input", { type: "checkbox" });
    this.figures = make("div", { className: "figures", role: "status" });
    this.body = make("div", { className: "plot" }, form, this.figures,
      make("p", { className: "hint", textContent: "Download saves the drawing on this paper as SVG, PDF, EPS, HPGL, G-code or DXF." }));
    place.append(make("label", {}, this.box, " Draw with a pen"), this.body);
    this.fields = new Fields(form, fields, (draft) => this.#fieldChanged(draft));
    this.box.addEventListener("change", () => { this.#settle(); turned(this.isOn); });
    this.#settle();
  }

  get isOn() {
    return this.box.checked;
  }

  state() {
    return this.isOn ? { plotter: "on", ...this.fields.state() } : {};
  }

  /** Returns the settings in words, like `Fields`. */
  inWords() {
    const turned = { label: "Draw with a pen", text: this.isOn ? "yes" : "no", first: "no" };
    return [turned, ...(this.isOn ? this.fields.inWords() : [])];
  }

  restore(state) {
    this.box.checked = state.plotter === "on";
    this.fields.restore(state);
    this.#settle();
  }

  get style() {
    return this.fields.values().style;
  }

  /** Width of a dot in mm; undefined if dots are not drawn. */
  get #dotWidth() {
    const { pen_mm: pen, dot_mm: dot, style } = this.fields.values();
    if (style === "path") return undefined;
    return fillings.includes(style) ? dot : pen;
  }

  /**
   * Returns the options of a drawing: width, dots, pen and, if there is one, the time limit. Adds the paper and the
   * files for a format that has these, and the machine if its time matters.
   */
  options(format) {
    const { pen_mm: pen, style, closed, speed, machine, dwell_unit, pen_down, pen_up, ...values } = this.fields.values();
    const { width, paper } = this.#page();
    const { minutes } = this;
    const files = suited({
      ...(paper && { paper: values.paper, margin: values.margin_mm, ...(values.marks && { marks: true }) }),
      ...(values.split && { split: values.part_minutes ?? values.split }),
    }, format);
    const isTimed = minutes !== undefined || typeof files.split === "number" || format === "gcode";
    return {
      width_mm: width,
      ...(style !== "path" && { dot: this.dot(this.#dotWidth / 2, width) }),
      ...(style !== "fill" && { style }),
      ...((style === "path" || fillings.includes(style)) && { pen }),
      ...(minutes !== undefined && { minutes }),
      ...(closed && { closed }),
      ...files,
      ...(isTimed && { speed, ...(this.#dwell !== undefined && { dwell: this.#dwell }), ...(machine && { machine }) }),
      ...(format === "gcode" && dwell_unit !== undefined && { dwell_unit }),
      ...(format === "gcode" && pen_down !== undefined && { pen_down }),
      ...(format === "gcode" && pen_up !== undefined && { pen_up }),
    };
  }

  /** Time of a dwell in seconds; undefined for the line of a laser, which has none. */
  get #dwell() {
    const { lift, dwell } = this.fields.values();
    return lift === undefined ? dwell : lift / 2;
  }

  /** Time in seconds that each stroke takes in addition to its length. */
  get #strokeTime() {
    return this.fields.values().lift ?? this.#dwell ?? 0;
  }

  /** Time limit of the drawing in minutes; undefined if there is none. */
  get minutes() {
    return this.isOn ? this.fields.values().minutes : undefined;
  }

  /**
   * Estimates the size and the duration of a drawing; null if unknown.
   * @returns  {dots, strokes, path, wanted, whole}: `dots` is the number of dots within the time limit, `path` the
   *           length of the path in mm, `wanted` the number of dots without a time limit, and `whole` the width of
   *           dots, in mm, at which `dots` dots would give the full tone
   */
  #estimate() {
    const plan = this.plan();
    if (!plan) return null;
    const { pen_mm: pen, style, minutes, speed } = this.fields.values();
    const { width, height } = this.#page();
    const area = width * height;
    const share = plan.inks.reduce((sum, ink) => sum + ink.share, 0);
    if (share === 0) return null;  // a white picture has no dots
    const dot = this.#dotWidth;
    const full = (share * area) / (Math.PI * (dot / 2) ** 2);
    const wanted = Math.round(plan.sites ?? full);
    // A path through n evenly spread dots is about the square root of n times their area long.
    const step = Math.sqrt(area) * plan.inks.reduce((sum, ink) => sum + ink.spread * Math.sqrt(ink.share / share), 0);
    const filling = fillings.includes(style) ? fillLength(style, dot, pen) : 0;
    const each = style === "path" ? 0 : this.#strokeTime + filling / speed;
    const half = step / speed / 2;
    const root = (60 * minutes) / (half + Math.sqrt(half ** 2 + 60 * minutes * each));
    const dots = minutes > 0 ? Math.max(Math.min(wanted, Math.floor(root ** 2)), 1) : wanted;
    if (!Number.isFinite(dots)) return null;
    return { dots, strokes: style === "path" ? 1 : dots, path: step * Math.sqrt(dots) + dots * filling, wanted, whole: dot * Math.sqrt(full / dots) };
  }

  showDrawing(svg) {
    this.#shownOptions = svg === null ? null : this.#drawingOptions;
    this.#layers = svg === null ? [] : layersOf(svg, this.style);
    this.#tellFigures();
  }

  /** Shows estimates until the next drawing arrives. */
  wait() {
    this.#shownOptions = null;
    this.#layers = [];
    if (this.isOn) this.#tellFigures();
  }

  /** Shows the errors of the server beside the fields. Translates the names of options to those of the fields. */
  show(errors) {
    const ownNames = { dot: fillings.includes(this.style) ? "dot_mm" : "pen_mm", pen: "pen_mm", margin: "margin_mm", ...(this.fields.values().dwell === undefined && { dwell: "lift" }) };
    this.fields.show(errors.map((error) => ({ ...error, pointer: ownNames[error.pointer.replace(/^\//, "")] ?? error.pointer })));
  }

  get #drawingOptions() {
    return JSON.stringify(this.options());
  }

  /**
   * Requests a new drawing only if a change of a field changes its options. For example, the speed of the pen matters
   * only with a time limit.
   */
  #fieldChanged(draft) {
    this.#settle();
    if (this.#drawingOptions !== this.#shownOptions) return this.changed(draft);
    this.#tellFigures();
    if (!draft) this.noted();
  }

  #tellFigures() {
    this.figures.replaceChildren(...(this.#layers.length === 0 ? this.#foretell() : this.#describe(this.#layers)));
  }

  #settle() {
    this.body.hidden = !this.isOn;
    const { paper, machine, split } = this.fields.values();
    const isFree = paper === "none";
    const isLine = this.style === "path";
    this.fields.offer("width_mm", isFree);
    for (const name of ["margin_mm", "marks"]) this.fields.offer(name, !isFree);
    this.fields.offer("minutes", this.isTimed);
    this.fields.offer("dot_mm", fillings.includes(this.style));
    this.fields.offer("closed", isLine);
    this.fields.offer("lift", machine !== "laser");
    this.fields.offer("dwell", machine === "laser" && !isLine);
    this.fields.offer("part_minutes", split === "time");
  }

  /**
   * Returns the width and height of the drawing and the size of its paper, in mm. The drawing is centred on the paper.
   * The paper is upright or across, whichever makes the drawing larger.
   */
  #page() {
    const { paper, margin_mm: margin, width_mm: chosenWidth } = this.fields.values();
    const { width, height } = this.size();
    const sheet = papers[paper];
    if (!sheet) return { width: chosenWidth, height: (chosenWidth * height) / width };
    const fit = ([w, h]) => ({ paper: [w, h], scale: Math.min((w - 2 * margin) / width, (h - 2 * margin) / height) });
    const [upright, across] = [fit(sheet), fit(sheet.toReversed())];
    const best = across.scale > upright.scale ? across : upright;
    const fitted = Math.max(Math.floor(10 * best.scale * width) / 10, 1);
    return { width: fitted, height: (fitted * height) / width, paper: best.paper };
  }

  #time({ strokes, path }) {
    return path / this.fields.values().speed + strokes * this.#strokeTime;
  }

  #foretell() {
    const estimate = this.isOn ? this.#estimate() : null;
    if (!estimate) return [];
    return [
      drawPage(this.#page()),
      make("p", { textContent: `Estimate: ${count(estimate.dots)} dots, about ${duration(this.#time(estimate))}.` }),
      ...this.#advice(estimate),
    ];
  }

  /** Returns a note, in a list, if the time limit makes the drawing lighter than the picture; otherwise []. */
  #advice({ dots, wanted, whole }) {
    if (!(dots < wanted && whole > 0)) return [];
    const wider = fillings.includes(this.style) ? "dots" : "a pen";
    return [make("p", { className: "note", textContent: `The drawing is lighter than the picture. The right tone needs about ${count(wanted)} dots, or ${wider} ${Number(whole.toPrecision(2))} mm wide.` })];
  }

  #describe(layers) {
    const page = this.#page();
    const estimate = this.#estimate();
    const round = (value) => Number(value.toFixed(1));
    const time = (layer) => this.#time(layer);
    const sumOf = (name) => layers.reduce((sum, layer) => sum + layer[name], 0);
    const sum = { dots: sumOf("dots"), strokes: sumOf("strokes"), path: sumOf("path") };
    const line = ({ name, colour, ...layer }) => make("li", { style: `--class: ${colour}` },
      `${name}: ${count(layer.dots)}, ${metres(layer.path / 1000)}, ${duration(time(layer))}`);
    return [
      drawPage(page),
      make("p", { textContent: `${round(page.width)} \u00d7 ${round(page.height)} mm. ${count(sum.dots)} dots in ${count(layers.length)} ${layers.length === 1 ? "layer" : "layers"}, a path of ${metres(sum.path / 1000)}: about ${duration(time(sum))}.` }),
      ...(layers.length > 1 ? [make("ul", { className: "legend", attributes: { "aria-label": "Layers" } }, ...layers.map(line))] : []),
      ...(estimate ? this.#advice(estimate) : []),
    ];
  }
}

function drawPage({ width, height, paper = [width, height] }) {
  const box = (x, y, w, h, name) => shape("rect", { class: name, x, y, width: w, height: h });
  return shape("svg", { viewBox: `-4 -4 ${paper[0] + 8} ${paper[1] + 8}`, class: "sheet", "aria-hidden": "true" },
    box(0, 0, ...paper, "paper"), box((paper[0] - width) / 2, (paper[1] - height) / 2, width, height, "drawing"));
}
