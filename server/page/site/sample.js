// SPDX-License-Identifier: GPL-3.0-or-later
// Panel that places points in a shape.

import { ask, post } from "./api.js";
import { chart } from "./chart.js";
import { CcdtError } from "./connection.js";
import { colour, count, inMemory, make, metres, save, seconds } from "./dom.js";
import { DotLayer } from "./dots.js";
import { Drawing } from "./drawing.js";
import { explain, Fields } from "./fields.js";
import { isPartOfShapefile, isPicture } from "./file_kind.js";
import { countsOf, isGeojson, mayBeDegrees, polygonsOf } from "./geojson.js";
import { postPatiently } from "./jobs.js";
import { keep, kept } from "./kept.js";
import { Panel } from "./panel.js";
import { Plotter } from "./plotter.js";
import { offerPrint, suited } from "./print_options.js";
import { drawingFields, fields, fileFields, formats, masks, methodNamed, moreFields, maxPoints, shapeFields, surfaceFields, surfaces, volumes } from "./sample_options.js";
import { areaOf, boundsOf, firstPolygon, outlineOf, polygonOf, polygonsOfMesh, rectangle, unitTorus } from "./shape.js";
import { Snippets } from "./snippets.js";
import { Viewport } from "./viewport.js";

const maxFrames = 64;
const maxFramePoints = 5_000_000;  // maximum number of points in all cached answers
const minRadius = 0.9;  // CSS pixels; minimum radius of a dot, unless dots are crowded
const crowdedShare = 0.4;  // minimum radius of crowded dots, in mean spacings; they cover half of the area
const dotShare = 0.3;  // radius of a dot, in mean spacings
const mapShare = 0.15;  // the same for dot maps, which have much denser parts
/** Minimum initial number of dots of a map. Rounding the units per dot allows up to 2.5 times this number. */
const initialMapDots = Math.min(5000, Math.floor(maxPoints / 2.5));
const maxCounts = 24;  // maximum number of properties offered
const listsProperties = ["geojson", "ndjson", "geojsonseq", "csv"];
const maxRepairs = 20;  // maximum number of repairs shown
const maxParts = 30;  // maximum number of parts offered
const maxPast = 100;  // maximum number of polygons kept for undo
const maxInAddress = 2000;  // maximum number of characters for corners
const edgeWidth = 0.7;  // CSS pixels; width of the edges of a triangulation
const minScale = 4;  // CSS pixels per threshold below which the mask is smoothed
const map = { name: "texas.geojson", counted: ["employed", "unemployed"] };
const knotName = "knot.obj";
/** Number of vertices of the shown surface, unless the user selects the triangulation of the points. */
const shownVertices = Math.min(10_000, maxPoints);
const ownShape = "own";  // name in the address for a file of the user, which is not part of the address

let filesTaken = 0;

const bodyMembers = ["density", "exclude", "avoid", "fixed"];  // options that cannot be query parameters

/**
 * Whether a file is sent as the body of a request. A mesh always is, because it cannot be part of JSON. With other files,
 * options in `bodyMembers` need a JSON body instead.
 */
const isDocument = ({ file }, options) => Boolean(file) && (Boolean(file.mesh) || !bodyMembers.some((name) => name in options));

/** Returns options as query parameters. Lists are JSON. */
const queryOf = (options) => new URLSearchParams(Object.entries(options).map(([name, value]) => [name, typeof value === "object" ? JSON.stringify(value) : value]));

/**
 * Returns the request for a shape. If the body is a file, the options are query parameters. Otherwise, shape and
 * options are members of a JSON body.
 */
function requestOf({ file, json, ...shape }, options) {
  const { type: domain, ...sides } = shape.domain ?? {};
  if (isDocument({ file }, options)) return { path: `/sample?${queryOf({ ...options, ...(domain && { domain, ...sides }) })}`, body: file.mesh ?? file.archive ?? file.text, type: file.type ?? "application/geo+json", file, options: { ...options, ...(domain && { domain: shape.domain }) } };
  const members = file ? { ...options, geometry: json } : { ...options, ...shape };
  return { path: "/sample", body: JSON.stringify(members), type: "application/json", options: members };
}

/** Returns whether a file is a mesh, according to its name or its first bytes. Only the server reads meshes. */
async function isMesh(file) {
  const ending = file.name.split(".").pop().toLowerCase();
  return surfaces.inputs.some(({ extension }) => extension === ending) || /^(glTF|ply\s|solid\s|OFF\s)/.test(await file.slice(0, 6).text());
}

const isArchive = async (file) => (await file.slice(0, 4).text()) === "PK\u0003\u0004";

/** Returns the first of several files or, if it is a part of a shapefile, an archive of all parts. */
async function wholeOf(files) {
  const [file] = files;
  if (!isPartOfShapefile(file)) return file;
  if (files.length === 1) throw new Error(`${file.name} is a part of a shapefile. Choose its .shp, .shx, .dbf and .prj files together`, { cause: file });
  const { zipOf } = await import("./zip.js");
  const parts = files.filter(isPartOfShapefile).map((part) => ({ name: part.name, blob: part }));
  return new File([await zipOf(parts)], file.name.replace(/\.[^.]*$/, ".zip"), { type: "application/zip" });
}

/**
 * Reads a file. Returns {name, text}, with `archive` and its `type` for a zipped shapefile, or {name, mesh, type} for a
 * mesh, also with the sides of the array as `voxels` for an NPY file. Only the server can read shapefiles, so their
 * outline is the boundary of a triangulation from the server.
 */
async function documentOf(file) {
  const head = await file.slice(0, 200).text();
  const voxels = head.includes("NUMPY") && head.match(/\((\d+), (\d+), (\d+)\)/);
  if (voxels) return { name: file.name, mesh: file, type: "application/x-npy", voxels: voxels.slice(1).reverse().join(",") };
  if (await isMesh(file)) return { name: file.name, mesh: file, type: "application/octet-stream" };
  if (!(await isArchive(file))) return { name: file.name, text: await file.text() };
  const mesh = await (await post("/sample?sites=1&iterations=0&mesh=true", file, { type: "application/zip" })).json();
  const json = { type: "MultiPolygon", coordinates: polygonsOfMesh(mesh) };
  return { name: file.name, text: JSON.stringify(json), archive: file, type: "application/zip" };
}

/** Loads the sample map of the page: {name, text, path}. */
async function loadMap() {
  const path = `/assets/samples/${map.name}`;
  return { name: map.name, text: await (await ask("GET", path)).text(), path };
}

/** Loads the shape of the user that was stored last; undefined if there is none. */
async function keptShape() {
  const shape = await kept("shape");
  return shape && { ...shape, file: { ...shape.file, number: ++filesTaken } };
}

/** Makes the sample mesh of the page. Returns the result of `documentOf` with `isSample`. */
async function loadKnot() {
  const { sampleMesh } = await import("./surface_view.js");
  return { ...await documentOf(new File([sampleMesh()], knotName)), isSample: true };
}

/** Returns the largest number of the form 1, 2 or 5 times a power of ten that is at most `sum / number`. */
function roundShare(sum, number) {
  const power = 10 ** Math.floor(Math.log10(sum / number));
  return power * ([5, 2].find((factor) => sum / number >= factor * power) ?? 1);
}

function countFields(counts, checked) {
  const sums = counts.filter(({ name }) => checked.length === 0 || checked.includes(name)).map(({ sum }) => sum);
  const whole = checked.length === 0 ? Math.max(...sums) : sums.reduce((a, b) => a + b, 0);
  const per = roundShare(whole, initialMapDots);
  return [
    { kind: "several", name: "counted", label: "Points stand for", checked, choices: counts.slice(0, maxCounts).map(({ name, sum }) => [name, `${name}: ${count(sum)}`]) },
    { kind: "number", name: "per", label: "Number per point", value: per, min: per / 10, max: per * 100, log: true },
  ];
}

/**
 * Returns the projected ends of the edges of a triangulation: x and y of both ends in turn. On a torus, each edge runs to
 * the nearest copy of its other end.
 */
function edgesOf({ vertices, triangles, boundary = [], shape, outline }) {
  const period = shape.domain?.type === "torus" ? shape.domain : null;
  const near = (from, to, side) => (period ? to - side * Math.round((to - from) / side) : to);
  const places = vertices.map(outline.project);
  const edges = [];
  const add = (from, to) => {
    const [[ax, ay], [bx, by]] = [places[from], places[to]];
    edges.push(ax, ay, near(ax, bx, period?.width), near(ay, by, period?.height));
  };
  // An inner edge is part of two triangles, in opposite directions.
  for (const triangle of triangles) triangle.forEach((from, i) => { if (from < triangle[(i + 1) % 3]) add(from, triangle[(i + 1) % 3]); });
  for (const ring of boundary) ring.forEach((from, i) => { if (from > ring[(i + 1) % ring.length]) add(from, ring[(i + 1) % ring.length]); });
  return Float64Array.from(edges);
}

/** Reads a polygon from JSON; null if the text contains none. */
function readCorners(text) {
  try {
    return polygonOf(JSON.parse(text));
  } catch {
    return null;
  }
}

export class Sample extends Panel {
  #shapes = { polygon: structuredClone(firstPolygon), rectangle: { domain: rectangle }, torus: { domain: unitTorus }, box: { domain: { ...unitTorus, type: "box", depth: 1 } }, space: { domain: { ...unitTorus, depth: 1 } }, mask: { domain: { ...unitTorus, width: 64, height: 64 } } };
  #frames = new Map();
  #result = null;
  #kept = null;
  #past = [];
  #counts = [];
  #checked = [];  // names of the counts that were checked at first
  #own = null;
  #before = null;  // what was shown before a file of the user that the server has not accepted yet
  #refusal = null;  // error of a file that was not accepted
  #surfaceView = null;
  #mask = null;
  #isStale = true;
  #isBegun = false;  // false until a shape is restored or requested
  #isLost = false;  // whether the address names a shape of the user that is not stored
  #dots = new DotLayer();

  constructor(element) {
    super(element);
    this.canvas = this.find("canvas");
    this.shapeChoice = this.find("#shape");
    this.corners = this.find("#corners");
    this.iteration = this.find("#iteration");
    this.first = this.find("#first");
    this.mesh = this.find("#mesh");
    this.tiles = this.find("#tiles");
    this.viewport = new Viewport(this.canvas, this.find(".zoom"), (...args) => this.#draw(...args),
      { margin: 28, press: (at) => this.#press(at), swipes: () => this.shapeChoice.value !== "polygon" });
    this.drawing = new Drawing({
      toScreen: (corner) => this.#toScreen(corner), toShape: (at) => this.#toShape(at),
      grasped: () => this.#remember(), changed: (moving) => this.#shapeMoved(moving),
    });
    this.shapeFields = new Fields(this.find(".shape-fields"), shapeFields, () => this.#sidesChanged());
    this.surfaceFields = new Fields(this.find("form.of-surfaces"), surfaceFields, (draft) => this.refresh(draft));
    this.fields = new Fields(this.find(".fields"), fields, (draft) => this.refresh(draft));
    this.moreFields = new Fields(this.find(".more .of-points"), moreFields, (draft) => this.refresh(draft));
    const noted = (draft) => { this.#offerFields(); if (!draft) this.note(); };
    this.fileFields = new Fields(this.find(".more .of-files"), fileFields, noted);
    this.drawingFields = new Fields(this.find(".more .of-drawings"), drawingFields, noted);
    this.plotter = new Plotter(this.find(".plotter"), {
      size: () => this.#given,
      plan: () => ({ sites: this.#sites(this.options()), inks: [{ share: 1, spread: 1 }] }),
      dot: (radius, width) => Number(((radius * this.#given.width) / width).toPrecision(6)),
      changed: (draft) => { if (!draft) this.refresh(); },
      turned: () => this.refresh(),
      noted: () => this.note(),
    });
    explain(this.find(".trace figcaption"), "The standard deviation of the capacities of triangles, divided by their mean. It is 0 if the area is divided equally among the points. Independent random points have about 1.");
    this.snippets = new Snippets(this.find(".snippets"));
    this.addDownload((format, signal) => this.#ask({ ...this.options(), ...this.#fileOptions(format), format }, signal));
    this.#listen();
    this.#shapeChosen();
  }

  state() {
    if (!this.#isBegun) return {};
    const kind = this.shapeChoice.value;
    const corners = kind === "polygon" ? JSON.stringify(this.shape) : "";
    const isDrawn = corners !== "" && corners !== JSON.stringify(firstPolygon) && corners.length <= maxInAddress;
    const parts = [this.shapeFields, this.fields, this.surfaceFields, ...(kind === "file" && this.countFields ? [this.countFields] : []), this.moreFields, this.fileFields, this.drawingFields, this.plotter];
    const others = {
      ...(isDrawn && { corners }),
      ...Object.assign({}, ...parts.map((part) => part.state())),
      ...(this.iteration.value !== this.iteration.max && { iteration: this.iteration.value }),
      ...(this.first.value !== this.first.max && { first: this.first.value }),
      ...(this.mesh.checked && { mesh: "on" }), ...(this.tiles.checked && { tiles: "on" }),
    };
    const isFirst = this.shapeName === map.name && Object.keys(others).length === 0;
    return isFirst ? {} : { shape: this.shapeName, ...others };
  }

  get shapeName() {
    const kind = this.shapeChoice.value;
    if (kind !== "file" && kind !== "surface") return kind;
    const { path, isSample } = this.shape?.file ?? {};
    return path ? map.name : isSample ? knotName : ownShape;
  }

  async restore(state) {
    this.#isStale = this.#isBegun = true;
    this.element.dataset.state = "busy";
    for (const part of [this.shapeFields, this.fields, this.surfaceFields, this.moreFields, this.fileFields, this.drawingFields, this.plotter]) part.restore(state);
    this.iteration.value = state.iteration ?? this.iteration.max;
    this.first.value = state.first ?? this.first.max;
    this.mesh.checked = state.mesh === "on";
    if (!(await this.#restoreShape(state))) return;
    this.#takeSides();
    this.countFields?.restore(state);
    this.tiles.checked = state.tiles === "on" && this.shapeChoice.value === "torus";
    this.#refit();
  }

  /**
   * Restores the shape. If there are no settings, the shape is the sample map; if settings do not name a shape, it is
   * the polygon. Returns false if a sample could not be loaded, or if the user has made another choice in the meantime.
   */
  async #restoreShape({ corners = "", ...state }) {
    const { shape = corners || Object.keys(state).length > 0 ? "polygon" : map.name } = state;
    if (shape === map.name) return this.#takeMap();
    if (shape === knotName) return this.#takeKnot();
    const own = shape === ownShape ? this.#own ?? await this.loadNewest(keptShape()) : undefined;
    if (own === null) return false;
    if (own) {
      this.#takeShape(own, []);
      return true;
    }
    this.shapeChoice.value = ["rectangle", "torus", "box", "space", "mask"].includes(shape) ? shape : "polygon";
    this.#shapes.polygon = readCorners(corners) ?? structuredClone(firstPolygon);
    this.#shapeChosen();
    this.#isLost = shape === ownShape;
    return true;
  }

  activate() {
    if (this.#isStale) this.#lookAnew();
  }

  async #lookAnew() {
    if (!this.#isBegun) await this.restore({});
    this.refresh();
  }

  get shape() {
    return this.#shapes[this.shapeChoice.value] ?? null;
  }

  get isMask() {
    return this.shapeChoice.value === "mask";
  }

  get isMesh() {
    return this.shapeChoice.value === "surface";
  }

  get isSurface() {
    return this.isMesh && !this.surfaceFields.values().domain;
  }

  get #hasDepth() {
    return Boolean(this.shape?.domain?.depth);
  }

  get isVolume() {
    return this.#hasDepth || (this.isMesh && !this.isSurface);
  }

  get #isSpatial() {
    return this.isSurface || this.isVolume;
  }

  get #onGlobe() {
    return this.shapeChoice.value === "file" && this.shapeFields.values().coordinates === "lonlat";
  }

  get #outline() {
    const [shape, onGlobe] = [this.shape, this.#onGlobe];
    if (this.#kept?.shape !== shape || this.#kept.onGlobe !== onGlobe) this.#kept = { shape, onGlobe, ...outlineOf(shape, onGlobe) };
    return this.#kept;
  }

  /** Width and height of the shape, in units of its coordinates. */
  get #given() {
    const bounds = boundsOf(outlineOf(this.shape, false).rings);
    return { width: bounds.maxX - bounds.minX, height: bounds.maxY - bounds.minY };
  }

  /**
   * Last result: the members of the server's answer, `shape`, `outline`, the coordinates of the projected points as
   * `places` (x and y of each in turn) and, for points on a surface, the shown surface {vertices, triangles}.
   */
  get result() {
    return this.#result;
  }

  #listen() {
    this.shapeChoice.addEventListener("change", () => this.#chosen());
    this.find(".draw").addEventListener("click", () => this.#startDrawing(false));
    this.find(".hole").addEventListener("click", () => this.#startDrawing(true));
    this.find(".map").addEventListener("click", () => this.#chooseSample(this.#takeMap()));
    this.find(".knot").addEventListener("click", () => this.#chooseSample(this.#takeKnot()));
    this.find(".keep").addEventListener("click", () => save(this.shape.file.mesh, knotName));
    this.find(".undo").addEventListener("click", () => this.#undo());
    this.find(".close").addEventListener("click", () => this.drawing.close());
    this.find(".clear").addEventListener("click", () => { this.drawing.clear(); this.viewport.redraw(); });
    this.find(".part").addEventListener("change", () => this.#showPart());
    this.canvas.addEventListener("keydown", (event) => this.#drawingKey(event));
    this.corners.addEventListener("change", () => this.#takeCorners());
    this.iteration.addEventListener("input", () => this.refresh(true));
    this.iteration.addEventListener("change", () => this.refresh());
    this.first.addEventListener("input", () => this.#showFirst());
    this.first.addEventListener("change", () => this.note());
    this.mesh.addEventListener("change", () => this.refresh());
    this.tiles.addEventListener("change", () => { this.#refit(); this.note(); });
    this.find(".file").addEventListener("change", ({ target }) => {
      if (target.files.length > 0) this.take([...target.files]);
      target.value = "";
    });
  }

  #tellOfShape(text) {
    this.find("#shape-error").textContent = text;
  }

  async take(files) {
    const [file] = files;
    if (isPicture(file)) return this.offerElsewhere(files, "picture", { name: "halftone", title: "Halftone" });
    try {
      const document = await this.loadNewest(wholeOf(files).then(inMemory).then(documentOf));
      if (document) this.#takeOwn(document);
    } catch (error) {
      const { message, cause } = error;
      if (error instanceof CcdtError) this.showProblem({ message: `${file.name} cannot be read as a shapefile: ${message}` });
      else this.showProblem(cause ? error : { message: `${file.name} contains no GeoJSON polygons` });
    }
  }

  async #chooseSample(taken) {
    if (await taken) this.#chosen();
  }

  /** Shows employed and unemployed people on the sample map; see `#takeSample`. */
  #takeMap() {
    return this.#takeSample(loadMap());
  }

  #takeKnot() {
    return this.#takeSample(loadKnot());
  }

  /** Shows a sample of the page. Returns false if it was not loaded or is not wanted now. */
  async #takeSample(loading) {
    try {
      const document = await this.loadNewest(loading);
      if (document) this.#takeDocument(document, document.path ? map.counted : []);
      return document !== null;
    } catch (problem) {
      this.showProblem(problem);
      return false;
    }
  }

  /** Shows a file of the user. If the server refuses it, the panel returns to the shape and settings before. */
  #takeOwn(document) {
    const kind = this.shapeChoice.value;
    const before = this.#before ?? ((this.#result || this.#mask) && {
      kind, shape: this.shape, own: this.#own, counts: this.#counts, checked: this.#checked, counting: this.countFields?.state(),
      texts: ["coordinates", "volume"].map((name) => [name, this.shapeFields.text(name)]),
    });
    this.#takeDocument(document);
    this.#chosen();
    this.#before = before;
  }

  #goBack({ message }) {
    const { kind, shape, own, counts, checked, counting, texts } = this.#before;
    const { name } = this.shape.file;
    this.shapeChoice.value = kind;
    this.#shapes[kind] = shape;
    for (const [field, text] of texts) this.shapeFields.put(field, text);
    this.#own = own;
    keep("shape", own ?? undefined);
    this.#offerCounts(counts, checked);
    this.countFields?.restore(counting);
    this.#shapeChosen();
    this.refresh();
    this.#refusal = { message: `${name} cannot be used: ${message.replace(/; accepted are .*$/, "")}` };
  }

  /** Whether the server has refused the file in a request, and not an option. */
  #isOfFile({ status, errors = [] }) {
    return [400, 415, 422].includes(status) && this.shape?.file && errors.every((error) => this.#isAboutShape(error));
  }

  show(problem) {
    if (problem && this.#before && this.#isOfFile(problem)) return this.#goBack(problem);
    super.show(problem);
    if (this.#refusal && !problem) this.showProblem(this.#refusal);
  }

  /**
   * Shows a GeoJSON document or a mesh, or takes voxels as the density in a box. Throws if a document contains no polygons.
   *
   * @param file     result of `documentOf`; also `path` for a file of the server, and `isSample` for a mesh of the page
   * @param counted  names of the properties that points count
   */
  #takeDocument(file, counted = []) {
    const number = ++filesTaken;
    if (file.voxels) {
      if (!this.#hasDepth) this.shapeChoice.value = "box";
      this.shapeFields.put("volume", file.voxels);
      this.#takeSides();
      this.shape.file = { ...file, number };
      return;
    }
    if (file.mesh) return this.#takeShape({ file: { ...file, number } }, []);
    const json = JSON.parse(file.text);
    const bounds = boundsOf(polygonsOf(json).flat());
    if (!(bounds.minX <= bounds.maxX)) throw new Error("there are no polygons");
    this.shapeFields.put("coordinates", "lonlat");
    this.#takeShape({ file: { ...file, number }, json, mayBeDegrees: mayBeDegrees(bounds) }, counted);
  }

  #takeShape(shape, counted) {
    const { path, isSample, mesh } = shape.file;
    if (!path && !isSample) {
      this.#own = shape;
      keep("shape", shape);
    }
    this.shapeChoice.value = mesh ? "surface" : "file";
    this.#shapes[this.shapeChoice.value] = shape;
    if (!mesh) this.#offerCounts(countsOf(shape.json), counted);
    this.#shapeChosen();
  }

  #offerCounts(counts, checked) {
    this.#counts = counts;
    this.#checked = checked;
    const form = this.find(".counts");
    form.replaceChildren();
    this.countFields = counts.length > 0 ? new Fields(form, countFields(counts, checked), (draft) => this.refresh(draft)) : null;
  }

  /**
   * Returns {counted, per}: the names of the properties that points count, and the number of units per point. `counted`
   * is empty for shapes that are not files.
   */
  #counting() {
    return (this.shapeChoice.value === "file" && this.countFields?.values()) || { counted: [] };
  }

  #takeCorners() {
    try {
      const json = JSON.parse(this.corners.value);
      if (isGeojson(json)) {
        return this.#takeOwn({ name: "shape.geojson", text: this.corners.value });
      }
      const polygon = polygonOf(json);
      if (!polygon) throw new Error("these are no corners");
      this.#remember();
      this.#shapes.polygon = polygon;
    } catch {
      return this.#tellOfShape('The corners must be JSON: [[x, y], ...], {"polygon": [[x, y], ...], "holes": [[[x, y], ...], ...]}, or GeoJSON with polygons');
    }
    this.#chosen();
  }

  #chosen() {
    if (this.isMesh && !this.shape) return this.#chooseSample(this.#takeKnot());
    this.#isBegun = true;
    this.#shapeChosen();
    this.note(true);
    this.refresh();
  }

  /** Sets the sides of rectangle, torus and mask. The server rejects sides that are not positive. */
  #takeSides() {
    for (const [kind, name] of Object.entries({ rectangle: "rectangle", torus: "torus", box: "volume", space: "volume", mask: "tile" })) {
      const [width, height, depth] = this.shapeFields.text(name).split(",").map(Number);
      const { domain, ...others } = this.#shapes[kind];
      this.#shapes[kind] = { ...others, domain: { ...domain, width, height, ...(depth !== undefined && { depth }) } };
    }
  }

  #sidesChanged() {
    this.#takeSides();
    this.#refit();
    this.refresh();
  }

  #remember() {
    this.#past.push(structuredClone(this.#shapes.polygon));
    if (this.#past.length > maxPast) this.#past.shift();
    this.#offerTools();
  }

  /** Removes the last corner of the ring being drawn or, if there is none, reverts the last change of the polygon. */
  #undo() {
    if (this.drawing.ring?.length > 0) {
      this.drawing.undo();
      this.viewport.redraw();
    } else if (this.#past.length > 0) {
      this.#shapes.polygon = this.#past.pop();
      this.#shapeChosen();
      this.refresh();
    }
  }

  #offerTools() {
    const isDrawing = Boolean(this.drawing.ring);
    this.find(".close").hidden = this.find(".clear").hidden = !isDrawing;
    this.find(".draw").hidden = this.find(".hole").hidden = isDrawing;
    this.find(".undo").disabled = !isDrawing && this.#past.length === 0;
  }

  #shapeChosen() {
    this.abandonLoads();
    this.#isLost = false;
    this.#before = null;
    const kind = this.shapeChoice.value;
    this.find(".polygon-tools").hidden = this.find(".corners").hidden = kind !== "polygon";
    this.tiles.disabled = kind !== "torus";
    if (kind !== "torus") this.tiles.checked = false;
    this.corners.value = JSON.stringify(this.#shapes.polygon);
    this.#result = this.#mask = null;
    this.element.classList.toggle("of-mask", this.isMask);
    this.element.classList.toggle("of-surface", this.#isSpatial);
    this.#surfaceView?.clear();
    this.find(".keep").hidden = !this.shape?.file?.isSample;
    this.#tellOfAnswer({});
    this.find(".counts").hidden = kind !== "file";
    this.shapeFields.offer("coordinates", kind === "file" && this.shape?.mayBeDegrees);
    for (const [name, shape] of [["rectangle", "rectangle"], ["torus", "torus"], ["tile", "mask"], ["format", "mask"]]) this.shapeFields.offer(name, kind === shape);
    this.shapeFields.offer("volume", this.#hasDepth);
    this.#stopDrawing();
    this.#tellOfShape(this.shape ? "" : "Choose or drop a GeoJSON file or a shapefile");
    if (this.shape) this.#refit();
    this.viewport.redraw();
  }

  /** Fits the view to the shape and, if tiles are shown, to its neighbouring copies. */
  #refit() {
    if (this.isMask) return;
    const bounds = boundsOf(this.#outline.rings);
    const [width, height] = [bounds.maxX - bounds.minX, bounds.maxY - bounds.minY];
    const around = this.tiles.checked ? 1 : 0;
    this.view = { minX: bounds.minX - around * width, maxY: bounds.maxY + around * height };
    this.viewport.content = { width: width * (1 + 2 * around), height: height * (1 + 2 * around) };
    this.#offerParts();
  }

  /** Fills the menu of parts that can be shown alone, because distant islands would make all parts small. */
  #offerParts() {
    const { parts } = this.#outline;
    this.partsBySize = parts.map((part) => ({ part, area: areaOf([part]) })).sort((a, b) => b.area - a.area);
    const whole = this.partsBySize.reduce((sum, { area }) => sum + area, 0);
    const named = this.partsBySize.slice(0, maxParts).map(({ area }, i) =>
      new Option(`part ${i + 1}: ${Number((100 * area / whole).toPrecision(2))} %`, i));
    this.find(".part").replaceChildren(new Option("all parts", ""), ...named);
    this.find(".part").hidden = parts.length < 2;
  }

  #showPart() {
    const { value } = this.find(".part");
    if (value === "") return this.viewport.fit();
    const { minX, maxX, minY, maxY } = boundsOf(this.partsBySize[value].part);
    this.viewport.frame({ x: minX - this.view.minX, y: this.view.maxY - maxY, width: maxX - minX, height: maxY - minY });
  }

  #toScreen([x, y]) {
    const { scale, x: left, y: top } = this.viewport;
    return { x: left + (x - this.view.minX) * scale, y: top + (this.view.maxY - y) * scale };
  }

  /** Returns the position in the shape at a point of the canvas, rounded to a fraction of a pixel. */
  #toShape(at) {
    const { x, y } = this.viewport.toContent(at);
    const digits = Math.max(0, Math.ceil(Math.log10(this.viewport.scale)));
    return [x + this.view.minX, this.view.maxY - y].map((value) => Number(value.toFixed(digits)));
  }

  #startDrawing(hole) {
    this.drawing.start((ring) => {
      this.#remember();
      const { polygon, holes = [] } = this.#shapes.polygon;
      this.#shapes.polygon = hole ? { polygon, holes: [...holes, ring] } : { polygon: ring };
      this.#chosen();
    });
    if (!hole) this.#result = null;
    const hint = this.find(".drawing-hint");
    hint.hidden = false;
    hint.textContent = "Click to add corners. Click the first corner or press Enter to close. Backspace removes a corner, Escape cancels.";
    this.#offerTools();
    this.canvas.classList.add("drawing");
    this.canvas.focus();
    this.viewport.redraw();
  }

  #stopDrawing() {
    this.drawing.cancel();
    this.find(".drawing-hint").hidden = true;
    this.canvas.classList.remove("drawing");
    this.#offerTools();
  }

  #drawingKey(event) {
    const { key } = event;
    if ((event.ctrlKey || event.metaKey) && key === "z" && this.shapeChoice.value === "polygon") {
      event.preventDefault();
      return this.#undo();
    }
    if (!this.drawing.ring) return;
    if (key === "Enter") this.drawing.close();
    if (key === "Backspace") this.#undo();
    if (key === "Escape") {
      this.#stopDrawing();
      this.refresh();
    }
    this.viewport.redraw();
  }

  #press(at) {
    return this.shapeChoice.value === "polygon" ? this.drawing.press(at, this.#outline.rings) : null;
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

  /** Returns the options of the request for an iteration. Only the last iteration is polished. */
  options(iteration = Number(this.iteration.value)) {
    const { coordinates, format } = this.shapeFields.values();
    if (this.isMask) return { format, ...this.fields.values() };
    const request = { ...this.fields.values(), ...(coordinates && { coordinates }), ...this.surfaceFields.values(), ...this.moreFields.values() };
    const { options } = methodNamed(request.method);
    if (!options.includes("quality")) delete request.quality;
    else if (iteration < this.#lastIteration) request.quality = "draft";
    if (options.includes("iterations") && !this.isVolume) request.iterations = iteration;
    if (this.mesh.checked && !this.mesh.disabled) request.mesh = true;
    const { counted, per } = this.#counting();
    if (counted.length === 0) return request;
    const { sites, method, ...others } = request;
    return counted.length === 1 ? { sites: counted[0], per, ...others } : { classes: counted.join(","), per, ...others };
  }

  #fileOptions(format) {
    if (this.isMask || this.#isSpatial) return {};
    if (formats.find(({ name }) => name === format).drawn) return suited(this.#drawingOptions(format), format);
    const { properties, multipoint, ...tiles } = this.fileFields.values();
    return {
      ...(properties !== undefined && listsProperties.includes(format) && { properties }),
      ...(multipoint !== undefined && format === "geojson" && { multipoint }),
      ...(format === "pmtiles" && tiles),
    };
  }

  #drawingOptions(format) {
    return { ...this.drawingFields.values(), ...(this.plotter.isOn && this.plotter.options(format)) };
  }

  async #plot(signal) {
    if (!this.plotter.isOn || this.#isSpatial) return;
    const response = await this.#ask({ ...this.options(), ...suited(this.#drawingOptions()), format: "svg" }, signal);
    this.plotter.showDrawing(await response.text());
  }

  #sites(options) {
    const { counted, per } = this.#counting();
    if (this.isMask) return this.shape.domain.width * this.shape.domain.height;
    if (counted.length === 0) return options.sites;
    return this.#counts.reduce((sum, one) => sum + (counted.includes(one.name) ? one.sum / per : 0), 0);
  }

  #ask(options, signal, onProgress = this.showJob) {
    const { path, body, type } = requestOf(this.shape, options);
    return postPatiently(path, body, { ...options, sites: this.#sites(options) }, { type, signal, onProgress });
  }

  #offerFields() {
    const isMap = this.#counting().counted.length > 0;
    const { isSurface, isVolume } = this;
    const isFlat = !this.#isSpatial;
    this.fields.offer("sites", !isMap && !this.isMask);
    this.fields.offer("method", !isMap && !this.isMask && isFlat);
    for (const { name } of surfaceFields) this.surfaceFields.offer(name, name === "domain" ? this.isMesh : isSurface);
    this.fields.offer("quality", !this.isMask);
    if (this.isMask) this.offerDownloads(masks, "mask");
    else if (!isFlat) this.offerDownloads((isVolume ? volumes : surfaces).formats, "points", Object.keys(this.options()));
    else this.offerDownloads(formats, "points", Object.keys({ ...this.options(), ...this.#fileOptions("svg") }));
    this.countFields?.offer("per", isMap);
    this.mesh.disabled = isMap;
    const { options, max_sites: most } = methodNamed(this.options().method);
    this.iteration.parentElement.hidden = isVolume || !options.includes("iterations");
    this.fields.enable("quality", options.includes("quality"));
    this.fields.limit("sites", most);
    for (const name of ["passes", "tolerance"]) this.moreFields.offer(name, options.includes(name) && (isFlat || (isSurface && name === "passes")));
    for (const name of ["density", "invalid"]) this.moreFields.offer(name, isFlat);
    this.moreFields.allow("order", "path", isFlat);
    this.moreFields.offer("fixed", options.includes("fixed") && !isMap);
    const isTorus = this.shape?.domain?.type === "torus";
    this.fields.allow("quality", "stealthy", isTorus);
    for (const name of ["properties", "multipoint"]) this.fileFields.offer(name, this.shapeChoice.value === "file");
    for (const name of ["minzoom", "maxzoom"]) this.fileFields.offer(name, this.#onGlobe);
    this.fileFields.offer("dots_per_tile", this.#onGlobe && this.fileFields.values().maxzoom === undefined);
    this.find(".of-files").hidden = this.find(".files-title").hidden = this.shapeChoice.value !== "file";
    const { isOn: isPlotted } = this.plotter;
    for (const name of ["dot", "width_mm", "style"]) this.drawingFields.offer(name, !isPlotted);
    offerPrint(this.drawingFields, { hasWidth: this.drawingFields.values().width_mm !== undefined, isPlotted });
    for (const name of ["avoid", "exclude", "buffer"]) this.moreFields.offer(name, !isMap && !isTorus && isFlat);
  }

  #isKept(options) {
    return this.#frames.has(this.#keyOf(options));
  }

  #keyOf(options) {
    const { path, body, file } = requestOf(this.shape, options);
    return `${path} ${file?.number ?? body}`;
  }

  /** Returns the answer to a request. Answers are cached, because equal requests have equal answers. */
  async #frame(options, signal, onProgress) {
    const key = this.#keyOf(options);
    if (!this.#frames.has(key)) {
      const frame = await (await this.#ask(options, signal, onProgress)).json();
      let points = frame.sites;
      for (const { sites } of this.#frames.values()) points += sites;
      for (const [old, { sites }] of this.#frames) {
        if (this.#frames.size < maxFrames && points <= maxFramePoints) break;
        this.#frames.delete(old);
        points -= sites;
      }
      this.#frames.set(key, frame);
    }
    return this.#frames.get(key);
  }

  /** Requests the result for the current settings. Drafts are not polished, unless the polished answer is cached. */
  async fetch(signal, { draft = false, onProgress } = {}) {
    this.#isBegun = true;
    const shape = this.shape.file ? this.shape : structuredClone(this.shape);
    const outline = outlineOf(shape, this.#onGlobe);
    const options = this.options();
    if (draft && methodNamed(options.method).options.includes("quality") && !this.#isKept(options)) options.quality = "draft";
    const answer = await this.#frame(options, signal, onProgress);
    const surface = this.isSurface && (answer.mesh ?? await this.surface(signal, onProgress));
    const places = new Float64Array(2 * answer.points.length);
    answer.points.forEach((point, i) => { [places[2 * i], places[2 * i + 1]] = outline.project(point); });
    return { ...answer, surface, shape, outline, places };
  }

  /** Requests the surface to show: a triangulation of evenly spread points, because the page cannot read meshes. */
  async surface(signal, onProgress, { crease } = this.surfaceFields.values()) {
    const { mesh } = await this.#frame({ sites: shownVertices, quality: "draft", mesh: true, ...(crease && { crease }) }, signal, onProgress);
    return mesh;
  }

  async #showSurface(frame) {
    const { SurfaceView, sceneOf } = await import("./surface_view.js");
    const { domain, file } = frame.shape;
    const scene = frame.surface ? sceneOf(frame.surface, frame) : (await import("./volume_scene.js")).volumeSceneOf(domain, frame);
    if (frame !== this.#result) return;
    this.#surfaceView ??= new SurfaceView(this.find("canvas.of-surfaces"), this.find(".zoom.of-surfaces"));
    const isUpright = !domain && !/\.stl$/i.test(file.name);  // the z axis points up for volumes and STL files
    this.#surfaceView.show(scene, { object: file ?? JSON.stringify(domain), isUpright, hasEdges: this.mesh.checked && frame.surface });
    this.#showFirst();
  }

  refresh(draft = false) {
    this.find("output[for=iteration]").textContent = this.iteration.value;
    this.iteration.setAttribute("aria-valuetext", `after iteration ${this.iteration.value}`);
    if (!this.shape || this.drawing.ring) return;
    this.#isStale = false;
    this.#refusal = null;
    this.#offerFields();
    if (!this.#isSpatial) this.plotter.wait();
    if (!draft) this.note();
    this.snippets.showSample(requestOf(this.shape, this.options()), this);
    if (this.isMask) return this.#refreshMask(draft);
    this.start(async (signal) => {
      const start = performance.now();
      const frame = await this.fetch(signal, { draft });
      if (signal.aborted) return;
      this.#result = frame;
      this.#before = null;
      this.viewport.redraw();
      if (this.#isSpatial) await this.#showSurface(frame);
      this.#tellOfAnswer(frame);
      const apart = frame.pitch_m && !frame.features ? `${metres(frame.pitch_m)} apart, ` : "";
      const variation = frame.variation === undefined ? "" : `variation ${frame.variation.toFixed(3)}, `;
      const summary = `${count(frame.sites)} points, ${apart}${variation}${seconds(start)}`;
      if (!draft) this.status.textContent = summary;
      if (!draft || this.#isKept(this.options(this.#lastIteration))) await this.#showTrace(signal);
      if (!draft) this.status.textContent = summary;  // the job of the trace may have cleared the text
      if (!draft) await this.#plot(signal);
    }, draft);
  }

  #refreshMask(draft) {
    this.start(async (signal) => {
      const start = performance.now();
      const response = await this.#ask(this.options(), signal);
      const { showing } = await import("./mask.js");
      const mask = await showing(await response.blob());
      if (signal.aborted) return;
      this.#mask = mask;
      this.viewport.content = mask.canvas;
      this.status.textContent = `${mask.width} \u00d7 ${mask.height} thresholds, ${seconds(start)}`;
    }, draft);
  }

  get #shownFirst() {
    return Math.round(this.#result.points.length ** (this.first.value / this.first.max));
  }

  #showFirst() {
    const hasRank = Boolean(this.#result?.rank);
    this.first.parentElement.hidden = !hasRank;
    const text = hasRank ? count(this.#shownFirst) : "";
    this.find("output[for=first]").textContent = text;
    this.first.setAttribute("aria-valuetext", `the first ${text} points`);
    this.#surfaceView?.showFirst(hasRank ? this.#shownFirst : Infinity);
    this.viewport.redraw();
  }

  #tellOfAnswer({ warnings = [], repaired = [], classes = [] }) {
    this.#showFirst();
    this.find(".legend").replaceChildren(...classes.map(({ name, color, sites }) =>
      make("li", { textContent: `${name}: ${count(sites)}`, style: `--class: ${color}` })));
    const tell = ({ detail, face }) => (face === undefined ? detail : `${detail} (triangle ${count(face)})`);
    const lost = this.#isLost ? ["Your shape is not stored in this browser. Choose it again"] : [];
    this.find(".warnings").textContent = [...lost, ...warnings.map(tell)].join("; ");
    const place = this.find(".repairs");
    place.hidden = repaired.length === 0;
    place.querySelector("summary").textContent = this.isMesh ? "Repaired" : `Repaired in ${count(repaired.length)} ${repaired.length === 1 ? "place" : "places"}`;
    const left = repaired.length - maxRepairs;
    const lines = repaired.slice(0, maxRepairs).map(tell);
    if (left > 0) lines.push(`and ${count(left)} more`);
    place.querySelector("ul").replaceChildren(...lines.map((textContent) => make("li", { textContent })));
  }

  async #showTrace(signal) {
    const place = this.find(".trace");
    const hasTrace = methodNamed(this.options().method).options.includes("iterations") && !this.isVolume && this.#counting().counted.length === 0;
    place.hidden = !hasTrace;
    if (!hasTrace) return;
    const { trace } = await this.#frame(this.options(this.#lastIteration), signal);
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

  /**
   * Whether an error is about the shape. If the body of the request is a file, pointers with a leading slash refer to the
   * file, other pointers to options. If the file is a mesh, pointers that name no option refer to it.
   */
  #isAboutShape({ pointer }) {
    if (this.isMesh) return !surfaces.options.includes(pointer.replace(/^\//, "").split("/")[0]);
    const isBody = this.shape !== null && isDocument(this.shape, this.options());
    return isBody ? pointer === "" || pointer.startsWith("/") : /^\/?(polygon|holes|geometry|domain)/.test(pointer);
  }

  /** Shows errors beside the shape or the fields, except errors of files, which are shown on the canvas. */
  place(errors) {
    const [ofShape, others] = [true, false].map((isWanted) => errors.filter((error) => this.#isAboutShape(error) === isWanted));
    this.#tellOfShape(this.shape?.file ? "" : ofShape.map(({ detail }) => detail).join("; "));
    for (const part of [this.fields, this.shapeFields, this.surfaceFields, this.countFields, this.moreFields, this.fileFields, this.drawingFields, this.plotter]) part?.show(others);
  }

  forget() {
    this.#result = this.#mask = null;
    this.#tellOfAnswer({});
    this.plotter.showDrawing(null);
    this.find(".trace").hidden = true;
    this.#surfaceView?.clear();
    this.viewport.redraw();
  }

  #draw(context) {
    if (!this.shape || this.#isSpatial) return;
    if (this.isMask) return this.#drawMask(context);
    this.#drawOutline(context);
    if (this.#result) this.#drawResult(context, this.#result);
    if (this.shapeChoice.value === "polygon") this.#drawCorners(context);
  }

  #drawMask(context) {
    if (!this.#mask) return;
    const { canvas, width, height } = this.#mask;
    const { scale, x, y } = this.viewport;
    context.imageSmoothingEnabled = scale < minScale;
    context.drawImage(canvas, x, y, canvas.width * scale, canvas.height * scale);
    context.strokeStyle = colour("--accent");
    context.lineWidth = 2;
    context.strokeRect(x, y, width * scale, height * scale);
    context.lineWidth = 1;
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
    const parts = this.drawing.ring && !this.#result ? [] : this.#outline.parts;
    context.fillStyle = colour("--panel");
    context.strokeStyle = colour("--line");
    for (const [dx, dy] of this.#tileOffsets()) {
      for (const part of parts) {
        context.beginPath();
        for (const ring of part) {
          this.#path(context, ring.map(([x, y]) => [x + dx, y + dy]));
          context.closePath();
        }
        context.fill("evenodd");
        context.stroke();
      }
    }
  }

  #drawResult(context, result) {
    const { points, classes } = result;
    const tiles = this.#tileOffsets();
    if (result.triangles && this.mesh.checked) this.#drawMesh(context, result, tiles);
    const all = points.length, shown = result.rank ? this.#shownFirst : all;
    const area = areaOf(result.outline.parts);
    const dot = (this.plotter.isOn && this.plotter.options().dot) || (result.features ? mapShare : dotShare) * Math.sqrt(area / all);
    const { scale } = this.viewport;
    const radius = Math.max(dot * scale, Math.min(minRadius, crowdedShare * scale * Math.sqrt(area / shown)));
    const isCopy = ([dx, dy]) => dx !== 0 || dy !== 0;
    const layers = classes?.map(({ color, sites }, number) => ({ tiles, color, sites, number })) ?? [
      { tiles: tiles.filter(isCopy), color: colour("--quiet"), sites: all },
      { tiles: [[0, 0]], color: colour("--ink"), sites: all },
    ];
    for (const { sites, ...layer } of layers) {
      // Each class has a separate progressive order.
      if (layer.tiles.length > 0) this.#drawLayer(context, result, radius, { ...layer, most: Math.round((shown / all) * sites) });
    }
  }

  /** Draws the first `most` dots of class `number`, or of all classes if it is undefined, at each of the tiles. */
  #drawLayer(context, { places, rank, class: classOf }, radius, { tiles, color, number, most }) {
    const ratio = devicePixelRatio;
    const isShown = (i) => (number === undefined || classOf[i] === number) && !(rank?.[i] >= most);
    this.#dots.begin(context.canvas.width, context.canvas.height);
    for (const { x, y } of tiles.map((offset) => this.#toScreen(offset)))
      this.#dots.add(places, { x: ratio * x, y: ratio * y, scale: ratio * this.viewport.scale }, ratio * radius, isShown);
    this.#dots.draw(context, color, colour("--panel"));
  }

  /** Draws the edges of the triangulation at each of the tiles. */
  #drawMesh(context, result, tiles) {
    result.edges ??= edgesOf(result);
    const ratio = devicePixelRatio;
    this.#dots.begin(context.canvas.width, context.canvas.height);
    for (const { x, y } of tiles.map((offset) => this.#toScreen(offset)))
      this.#dots.addLines(result.edges, { x: ratio * x, y: ratio * y, scale: ratio * this.viewport.scale }, ratio * edgeWidth);
    this.#dots.draw(context, colour("--accent"), colour("--panel"));
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
    const rings = drawn ? [drawn] : this.#outline.rings;
    for (const corner of rings.flat()) {
      const { x, y } = this.#toScreen(corner);
      context.fillRect(x - 4, y - 4, 8, 8);
    }
  }
}
