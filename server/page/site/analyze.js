// SPDX-License-Identifier: GPL-3.0-or-later
// Panel that measures the spectrum and the distances of points, and compares them with the points of each method.

import { capabilities, postJson } from "./api.js";
import { chart } from "./chart.js";
import { count, make } from "./dom.js";
import { postPatiently } from "./jobs.js";
import { Panel } from "./panel.js";
import { largestSquare, unitTorus } from "./shape.js";

const methods = capabilities.sample.methods.toReversed();  // CCDT comes last
const maxInSpectrum = 131072;  // points; their spectrum has 8 million values
const digits = 11;  // significant digits of the largest coordinates, so that two million points take less than 64 MiB
const maxToCompare = 1024;  // points; CCVT takes a second for this number
const maxCentres = 300;  // points in a mesh that may be the centre of the measured cube
const minInCube = 20;  // points of a measured cube
const crease = 30;  // degrees; with creases, the surface has the sharp edges of the mesh
const whitest = 2.5;  // power at and above which pixels are white

/**
 * Returns the points in the largest cube around one of them that meets no bounding box of a triangle of the surface,
 * and the cube.
 */
function cubeInside(points, { vertices, triangles }) {
  const boxes = triangles.map((triangle) => [0, 1, 2].map((axis) => {
    const [a, b, c] = triangle.map((vertex) => vertices[vertex][axis]);
    return [Math.min(a, b, c), Math.max(a, b, c)];
  }));
  const distance = (p, box) => box.reduce((most, [low, high], axis) => Math.max(most, low - p[axis], p[axis] - high), 0);
  const step = Math.ceil(points.length / maxCentres);
  const { half, centre } = points.filter((_, i) => i % step === 0)
    .map((centre) => ({ centre, half: boxes.reduce((least, box) => Math.min(least, distance(centre, box)), Infinity) }))
    .reduce((best, each) => (each.half > best.half ? each : best));
  const reach = half * (1 - 1e-9);  // so that points are inside also after rounding
  const inside = points.filter((point) => point.every((value, axis) => Math.abs(value - centre[axis]) < reach));
  if (inside.length < minInCube) throw new Error(`A cube inside the mesh has only ${count(inside.length)} of the points, too few to be measured`);
  const side = 2 * half;
  return {
    points: inside.map((point) => point.map((value, axis) => value - centre[axis] + half)),
    domain: { type: "box", width: side, height: side, depth: side },
  };
}

/**
 * Returns the points to measure and their domain: for a rectangle or a torus, all points; for other shapes, the
 * projected points in the largest square inside the shape, relative to its lower left corner. For points on a surface,
 * returns the file of the mesh instead of a domain.
 */
function windowOf({ points, shape, surface, outline, places }) {
  if (shape.domain) return { points, domain: shape.domain };
  if (surface) return { points, mesh: shape.file.mesh };
  const { x, y, side } = largestSquare(outline.rings);
  const inside = points.map((_, i) => [places[2 * i] - x, places[2 * i + 1] - y])
    .filter(([px, py]) => px >= 0 && py >= 0 && px <= side && py <= side);
  return { points: inside, domain: { type: "rectangle", width: side, height: side } };
}

/** Returns the request for points in a domain, as JSON. */
function bodyOf(points, domain) {
  const places = Math.max(0, digits - Math.ceil(Math.log10(Math.max(domain.width, domain.height, domain.depth ?? 0))));
  const rounded = points.map((point) => point.map((value) => Number(value.toFixed(places))));
  return JSON.stringify({ points: rounded, domain, spectrum: points.length <= maxInSpectrum });
}

/** Returns the request for points on the surface of a mesh, as a form. */
function formOf(points, mesh) {
  const form = new FormData();
  form.set("mesh", new Blob([mesh]), mesh.name);  // without the media type, which browsers often get wrong
  form.set("points", JSON.stringify(points));
  return form;
}

const notes = {
  torus: "The points tile the plane and are measured on the torus.",
  rectangle: "The rectangle is treated as a window on a larger pattern.",
  map: "The points in the largest square inside the map are measured. Differences in density are part of the spectrum: they add power at low frequencies, near the middle and on the left.",
  polygon: "The points in the largest square inside the shape are measured. The square is treated as a window on a larger pattern.",
  space: "The points are measured in space. The picture is a slice of their spectrum.",
  solid: "The points in the largest cube inside the mesh are measured. The cube is treated as a window on a larger pattern. The picture is a slice of their spectrum.",
  surface: "The points are measured on the surface, by its lowest Laplace-Beltrami modes instead of a spectrum.",
  halftone: "The light and dark areas of the picture are part of the spectrum: they add power at low frequencies, near the middle and on the left. The dots of all inks are measured together.",
};

export class Analyze extends Panel {
  constructor(element, { halftone, sample }) {
    super(element);
    Object.assign(this, { halftone, sample });
    this.source = this.find("#source");
    this.source.addEventListener("change", () => { this.note(true); this.refresh(); });
    this.find(".again").addEventListener("click", () => this.refresh());
  }

  get #made() {
    return this.source.value === "halftone" ? this.halftone : this.sample;
  }

  /** Returns the settings, including those of the panel whose points are analyzed. */
  state() {
    const source = this.source.value;
    return { ...(source === "sample" ? { shape: this.sample.shapeName } : { source }), ...this.#made.state() };
  }

  async restore(state) {
    this.source.value = state.source === "halftone" ? "halftone" : "sample";
    await this.#made.restore(this.source.value === "sample" ? { shape: "polygon", ...state } : state);
  }

  activate() {
    this.refresh();
  }

  /**
   * Requests the points of the panel that is analyzed.
   * @returns  {points, domain, note}, or {points, mesh, note} for points on a surface
   */
  async #pointsMade(signal) {
    if (this.source.value === "halftone") {
      const { points, inks, width, height } = await (await this.halftone.ask("json", signal, { onProgress: this.showJob })).json();
      return { points: points ?? inks.flatMap((each) => each.points), domain: { type: "rectangle", width, height }, note: notes.halftone };
    }
    const { shape } = this.sample;
    if (!shape || this.sample.isMask) throw new Error("There are no points yet. Make some in the tab Sample");
    const result = this.sample.result ?? (await this.sample.fetch(signal, { onProgress: this.showJob }));
    if (this.sample.isMesh && !result.surface) {
      return { ...cubeInside(result.points, await this.sample.surface(signal, this.showJob, { crease })), note: notes.solid };
    }
    return { ...windowOf(result), note: notes[result.shape.domain?.depth ? "space" : result.shape.domain?.type ?? (result.surface ? "surface" : result.features ? "map" : "polygon")] };
  }

  refresh() {
    if (this.element.hidden) return;
    this.start(async (signal) => {
      this.results = [];
      this.#show();
      const { points, domain, mesh, note } = await this.#pointsMade(signal);
      if (points.length < 2) throw new Error("There are too few points in the part of the shape that is measured");
      this.find(".note").textContent = points.length > maxInSpectrum ? `${note} The picture of the spectrum is left out because there are too many points.` : note;
      await this.#measure("These points", mesh ? formOf(points, mesh) : bodyOf(points, domain), points.length, signal);
      const sites = Math.min(points.length, maxToCompare);
      if (domain?.depth) return;  // the other methods work only in the plane
      for (const { name, title } of methods) {
        const other = await postJson("/sample", { sites, method: name, domain: unitTorus, seed: 1 }, signal);
        await this.#measure(title, bodyOf(other.points, unitTorus), sites, signal);
      }
      this.status.textContent = `Compared with ${count(sites)} points of each method on a torus`;
    });
  }

  /** Measures points. `body` is JSON or a form. */
  async #measure(name, body, number, signal) {
    const type = typeof body === "string" ? "application/json" : undefined;
    const response = await postPatiently("/analyze", body, { sites: number }, { type, signal, onProgress: this.showJob });
    this.results.push({ name, number, ...await response.json() });
    this.#show();
  }

  #show() {
    this.find(".spectra").replaceChildren(...this.results.map((result, i) => spectrumFigure(result, i)));
    this.find("tbody").replaceChildren(...this.results.map(row));
    const place = this.find(".power");
    place.querySelector("svg")?.remove();
    if (this.results.length === 0) return;
    place.append(chart({
      label: "Power by frequency; the table below has the figures",
      size: { width: Math.max(place.clientWidth, 320), height: place.clientWidth < 600 ? 240 : 320 },
      x: { min: 0, max: 4, ticks: [0, 1, 2, 3, 4] },
      y: { min: 0.00001, max: 10, ticks: [0.00001, 0.0001, 0.001, 0.01, 0.1, 1, 10], log: true },
      curves: this.results.map(({ frequency, power }, i) => ({
        points: frequency.map((f, j) => [f, power[j]]), name: `curve-${i}`,
      })).reverse(),
    }));
  }
}

const figure = (value) => (value === null ? "\u2013" : value < 0.01 ? value.toExponential(1) : value.toFixed(3));

function row(result) {
  const cells = [count(result.number), figure(result.min_distance), figure(result.mean_distance), figure(result.low_frequency_power)];
  return make("tr", {}, make("th", { scope: "row", textContent: result.name }), ...cells.map((textContent) => make("td", { textContent })));
}

/**
 * Returns a figure of a spectrum, with frequency 0 in the middle. Power 0 is black, `whitest` and above is white.
 * Without a spectrum, returns only the caption, which is the legend of the curve.
 */
function spectrumFigure({ name, spectrum }, index) {
  const caption = make("figcaption", { textContent: name });
  if (!spectrum) return make("figure", { className: `curve-${index}` }, caption);
  const { width, height, values } = spectrum;
  const image = new ImageData(width, height);
  values.forEach((power, i) => {
    const grey = 255 * Math.sqrt(Math.min(power / whitest, 1));
    image.data.set([grey, grey, grey, 255], 4 * i);
  });
  const canvas = make("canvas", { width, height, attributes: { role: "img", "aria-label": `Spectrum: ${name}` } });
  canvas.getContext("2d").putImageData(image, 0, 0);
  return make("figure", { className: `curve-${index}` }, canvas, caption);
}
