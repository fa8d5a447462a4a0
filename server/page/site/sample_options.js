// SPDX-License-Identifier: GPL-3.0-or-later
// Fields for the options of /sample: labels, initial values and help texts.

import { capabilities } from "./api.js";

export const { formats, masks, methods } = capabilities.sample;
export const { max_sites: mostPoints } = capabilities.limits;
const [standard] = methods;

export const methodNamed = (name = standard.name) => methods.find((method) => method.name === name);

export const fields = [
  { kind: "number", name: "sites", label: "Points", value: Math.min(1000, mostPoints), min: 10, max: Math.min(50000, mostPoints), step: 1, log: true },
  { kind: "choice", name: "method", label: "Method", standard: standard.name, choices: methods.map(({ name, title }) => [name, title]),
    help: "CCDT is what this server is for. The others are what it is compared with; they are slower, and take fewer points." },
  { kind: "choice", name: "quality", label: "Quality", standard: "standard", choices: [["standard", "standard"], ["draft", "draft: without polish"], ["best", "best"], ["stealthy", "stealthy"]],
    help: "How evenly points are spread: a draft takes half the time, the best twice as long. On a torus, stealthy points have no power at low frequencies at all." },
  { kind: "number", name: "seed", label: "Seed", value: 0, min: 0, max: 100, step: 1, standard: 0,
    help: "Another number gives other points, as good. The same number gives the same points again." },
];

export const shapeFields = [
  { kind: "choice", name: "coordinates", label: "Coordinates", standard: "plane", choices: [["lonlat", "longitude, latitude"], ["plane", "of a plane"]],
    help: "Longitude and latitude: as many points to a square kilometre everywhere. Of a plane: as many to a square of degrees." },
  ...[["rectangle", 1.5], ["torus", 1]].map(([name, width]) => ({
    kind: "numbers", name, label: "Sides", numbers: [{ label: "width", value: width, min: 0, step: "any" }, { label: "height", value: 1, min: 0, step: "any" }],
  })),
  { kind: "numbers", name: "tile", label: "Sides in pixels", numbers: ["width", "height"].map((label) => ({ label, value: 64, min: 8, max: 1024, step: 1 })),
    help: "Shown are the mask, repeated, with one tile framed, and a picture and a ramp of greys that it dithers: what is lighter than the mask is white." },
  { kind: "choice", name: "format", label: "Thresholds", choices: masks.map(({ name, title }) => [name, title]) },
];

export const moreFields = [
  { kind: "picture", name: "density", label: "Density from a picture",
    help: "Points are denser where the picture is darker. It is stretched over the shape's bounding box." },
  { kind: "picture", name: "mask", label: "Mask from a picture",
    help: "No points where the picture is darker than half of white. It is stretched over the shape's bounding box." },
  { kind: "json", name: "avoid", label: "Areas without points",
    help: "GeoJSON polygons, or a list of rings: [[[x, y], ...], ...]." },
  { kind: "json", name: "fixed", label: "Points that are there already",
    help: "GeoJSON points, or [[x, y], ...]. New points keep clear of them." },
  { kind: "number", name: "buffer", label: "Free border", value: 0.05, min: 0.001, max: 10, log: true, auto: true, free: "none",
    help: "How far points stay from the border: in units of the shape, with longitude and latitude in metres." },
  { kind: "number", name: "passes", label: "Passes", value: 5, min: 1, max: 20, step: 1, standard: 5,
    help: "How often each point is moved in an iteration." },
  { kind: "number", name: "tolerance", label: "Stop at variation", value: 0.1, min: 0.01, max: 1, log: true, auto: true, free: "none",
    help: "Ends the iterations once the variation is below this." },
  { kind: "choice", name: "invalid", label: "Invalid polygons", standard: "repair", choices: [["repair", "repair"], ["reject", "refuse"]],
    help: "Rings that cross themselves, holes that reach out, parts that overlap." },
  { kind: "choice", name: "order", label: "Order", standard: "usual", choices: [["usual", "usual: a path in SVG"], ["none", "none"], ["path", "along a short path"], ["progressive", "progressive"]],
    help: "Progressive: the first points, however many, are spread evenly, and each point has its rank." },
  { kind: "choice", name: "on_deadline", label: "Out of time", standard: "error", choices: [["error", "refuse"], ["partial", "take what there is"]],
    help: "The server has a limit on how long a request may take." },
];

/** Fields for the options of GIS files. */
export const fileFields = [
  { kind: "text", name: "properties", label: "Properties",
    help: "Of its feature, which each point is to have: names with commas between, or * for all. In GeoJSON, GeoJSON lines and CSV." },
  { kind: "check", name: "multipoint", label: "All points in one Feature", checked: true, standard: true,
    help: "In GeoJSON. Without it each point is a Feature, as most GIS programs want to style and to join them." },
];

/** Fields for the options that only drawings have. */
export const drawingFields = [
  { kind: "number", name: "dot", label: "Dot radius", value: 0.01, min: 0.001, max: 1, log: true, auto: true,
    help: "In units of the shape, for SVG and PNG. auto: a quarter of the way from point to point." },
  { kind: "number", name: "width", label: "PNG width, pixels", value: 1000, min: 100, max: 10000, step: 1, log: true, auto: true },
  { kind: "number", name: "width_mm", label: "Print width, mm", value: 200, min: 20, max: 2000, step: 1, log: true, auto: true, free: "none",
    help: "What files tell programs that print them: resolution in PNG, size in SVG, whose units are then millimetres." },
  { kind: "choice", name: "style", label: "SVG has", standard: "fill", choices: [["fill", "circles"], ["stroke", "strokes, for plotters"]] },
];
