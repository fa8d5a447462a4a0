// SPDX-License-Identifier: GPL-3.0-or-later
// Fields for the options of /sample: labels, initial values and help texts.

import { capabilities } from "./api.js";
import { printFields } from "./print_options.js";

export const { formats, masks, methods, surfaces, volumes } = capabilities.sample;
export const { max_sites: maxPoints } = capabilities.limits;
const [standard] = methods;

export const methodNamed = (name = standard.name) => methods.find((method) => method.name === name);

export const fields = [
  { kind: "number", name: "sites", label: "Points", value: Math.min(1000, maxPoints), min: 10, max: Math.min(50000, maxPoints), step: 1, log: true },
  { kind: "choice", name: "method", label: "Method", standard: standard.name, choices: methods.map(({ name, title }) => [name, title]),
    help: "CCDT is the method of this server. The others are for comparison; they are slower and allow fewer points." },
  { kind: "choice", name: "quality", label: "Quality", standard: "standard", choices: [["standard", "standard"], ["draft", "draft: without polish"], ["best", "best"], ["stealthy", "stealthy"]],
    help: "How evenly points are spread. A draft takes half as long as standard, best takes twice as long. On a torus, stealthy removes all power at low frequencies." },
  { kind: "number", name: "seed", label: "Seed", value: 0, min: 0, max: 100, step: 1, standard: 0,
    help: "Another number gives different points, of equal quality. The same number gives the same points again." },
];

export const shapeFields = [
  { kind: "choice", name: "coordinates", label: "Coordinates", standard: "plane", choices: [["lonlat", "degrees"], ["plane", "plane"]],
    help: "Degrees: coordinates are longitude and latitude, and points are spread evenly on the ground. Plane: points are spread evenly in the given coordinates." },
  ...[["rectangle", 1.5], ["torus", 1]].map(([name, width]) => ({
    kind: "numbers", name, label: "Sides", numbers: [{ label: "width", value: width, min: 0, step: "any" }, { label: "height", value: 1, min: 0, step: "any" }],
  })),
  { kind: "numbers", name: "volume", label: "Sides", numbers: ["width", "height", "depth"].map((label) => ({ label, value: 1, min: 0, step: "any" })),
    help: "For a density, choose or drop an NPY file with an array (depth, height, width). Points are denser where its values are larger." },
  { kind: "numbers", name: "tile", label: "Sides in pixels", numbers: ["width", "height"].map((label) => ({ label, value: 64, min: 8, max: 1024, step: 1 })),
    help: "The page shows the repeated mask with one tile framed, and a picture and a grey ramp dithered with it. Pixels lighter than the mask become white." },
  { kind: "choice", name: "format", label: "Thresholds", choices: masks.filter(({ media_type: type }) => type === "image/png").map(({ name, title }) => [name, title]) },
];

/** Fields for the options that only meshes have. */
export const surfaceFields = [
  { kind: "choice", name: "domain", label: "Points", standard: "surface", choices: [["surface", "on the surface"], ["solid", "inside the mesh"]] },
  { kind: "choice", name: "density", label: "Density", standard: "uniform", choices: [["uniform", "uniform"], ["color", "by colour"], ["curvature", "by curvature"]],
    help: "By colour: points are denser where the vertices of the mesh are darker. By curvature: they are denser where the surface is bent." },
  { kind: "number", name: "crease", label: "Crease angle", value: 40, min: 5, max: 180, step: 1, auto: true, free: "none",
    help: "In degrees. An edge is a crease if the normals of its two faces form a greater angle. Points keep the same distance from creases as from borders." },
];

export const moreFields = [
  { kind: "picture", name: "density", label: "Density from a picture",
    help: "Points are denser where the picture is darker. The picture is stretched over the bounding box of the shape." },
  { kind: "picture", name: "exclude", label: "Areas to leave out, from a picture",
    help: "No points are placed where the luminance of the picture is less than half that of white. The picture is stretched over the bounding box of the shape." },
  { kind: "json", name: "avoid", label: "Areas without points",
    help: "GeoJSON polygons, or a list of rings: [[[x, y], ...], ...]." },
  { kind: "json", name: "fixed", label: "Existing points",
    help: "GeoJSON points, or [[x, y], ...]; on a surface, [[x, y, z], ...]. New points keep a distance from them." },
  { kind: "number", name: "buffer", label: "Distance from border", value: 0.05, min: 0.001, max: 10, log: true, auto: true, free: "none",
    help: "Minimum distance of points from the border: in units of the shape or, if coordinates are degrees, in metres." },
  { kind: "number", name: "passes", label: "Passes", value: 5, min: 1, max: 20, step: 1, standard: 5,
    help: "How often each point is moved per iteration." },
  { kind: "number", name: "tolerance", label: "Stop at variation", value: 0.1, min: 0.01, max: 1, log: true, auto: true, free: "none",
    help: "The iterations end once the variation is below this value." },
  { kind: "choice", name: "invalid", label: "Invalid polygons", standard: "repair", choices: [["repair", "repair"], ["reject", "show an error"]],
    help: "Rings that cross themselves, holes that extend beyond the outer ring, or parts that overlap." },
  { kind: "choice", name: "order", label: "Order", standard: "usual", choices: [["usual", "default"], ["none", "none"], ["path", "along a short path"], ["progressive", "progressive"]],
    help: "Progressive: the first points are spread evenly, for any number of them, and each point has a rank. By default, drawings follow a short path." },
  { kind: "choice", name: "on_deadline", label: "At the time limit", standard: "error", choices: [["error", "show an error"], ["partial", "show the result so far"]],
    help: "The server limits how long a request may take." },
];

/** Fields for the options of GIS files. */
export const fileFields = [
  { kind: "text", name: "properties", label: "Properties",
    help: "Properties that each point gets from its feature: names separated by commas, or * for all. For GeoJSON, GeoJSON lines and CSV." },
  { kind: "check", name: "multipoint", label: "All points in one Feature", checked: true, standard: true,
    help: "For GeoJSON. Without this, each point is a Feature, which most GIS programs need for styling and joining." },
  { kind: "number", name: "minzoom", label: "First zoom of tiles", value: 0, min: 0, max: 22, step: 1, standard: 0,
    help: "For vector tiles (PMTiles)." },
  { kind: "number", name: "maxzoom", label: "Last zoom of tiles", value: 10, min: 0, max: 22, step: 1, auto: true,
    help: "This zoom shows all dots. auto: the first zoom at which no tile has too many dots." },
  { kind: "number", name: "dots_per_tile", label: "Most dots per tile", value: 10000, min: 100, max: 50000, step: 1, log: true, standard: 10000 },
];

/** Fields for the options that only drawings have. */
export const drawingFields = [
  { kind: "number", name: "dot", label: "Dot radius", value: 0.01, min: 0.001, max: 1, log: true, auto: true,
    help: "In units of the shape, for SVG and PNG. auto: a quarter of the distance between points." },
  { kind: "number", name: "width", label: "PNG width, pixels", value: 1000, min: 100, max: 10000, step: 1, log: true, auto: true },
  { kind: "choice", name: "style", label: "Dots in SVG", standard: "fill", choices: [["fill", "circles"], ["stroke", "strokes for plotters"]] },
  ...printFields,
];
