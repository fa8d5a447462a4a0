// SPDX-License-Identifier: GPL-3.0-or-later
// Tells from the name and the media type of a file which panel it is for.

import { capabilities } from "./api.js";

const partOfShapefile = /\.(shp|shx|dbf|prj|cpg)$/i;

export const isPartOfShapefile = ({ name }) => partOfShapefile.test(name);
const endings = ["geojson", "json", "topojson", "ndjson", "geojsonl", "zip", "npy", ...capabilities.sample.surfaces.inputs.map(({ extension }) => extension)];

export const isShape = ({ name }) => partOfShapefile.test(name) || endings.includes(name.split(".").pop().toLowerCase());
export const isPicture = ({ name, type }) => !isShape({ name }) && (type.startsWith("image/") || /\.(avif|hei[cf]|tiff?)$/i.test(name));
