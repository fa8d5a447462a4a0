// SPDX-License-Identifier: GPL-3.0-or-later
// GeoJSON: what a document holds.

/** Its polygons, each a list of rings of which the first is the outer one; none if it has no area. */
export function polygonsOf(json) {
  switch (json?.type) {
    case "FeatureCollection": return json.features.flatMap(polygonsOf);
    case "GeometryCollection": return json.geometries.flatMap(polygonsOf);
    case "Feature": return polygonsOf(json.geometry);
    case "MultiPolygon": return json.coordinates;
    case "Polygon": return [json.coordinates];
    default: return [];
  }
}

/** Whether a document is GeoJSON, by its type. */
export function isGeojson(json) {
  const geometries = ["Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon", "GeometryCollection"];
  return ["Feature", "FeatureCollection", ...geometries].includes(json?.type);
}

/** A number of at least 0, that may stand in a text as in files of a census; else NaN. */
function countIn(value) {
  const number = typeof value === "string" && value.trim() !== "" ? Number(value) : value;
  return Number.isFinite(number) && number >= 0 ? number : NaN;
}

/** Names that say that a property tells features apart, as codes and numbers of rows do. */
const identifierName = /(^|_)(id|[fgop]id|fips|code|iso\w*|zip|key|nuts\w*|index|year)$|fips|fp$|geoid|objectid|postcode|[a-z](ID|Id|Code)$/;

/**
 * Whether a property tells features apart rather than counting something: by its name, as texts of digits that are as long
 * as each other or begin with 0, or as whole numbers without a gap.
 */
function isIdentifier(name, values) {
  if (identifierName.test(name) || identifierName.test(name.toLowerCase())) return true;
  if (values.length < 2) return false;
  if (values.every((value) => typeof value === "string"))
    return values.some((value) => /^0\d/.test(value)) || (values[0].length > 3 && values.every(({ length }) => length === values[0].length));
  const range = Math.max(...values) - Math.min(...values);
  return values.length > 3 && values.every(Number.isInteger) && new Set(values).size === values.length && range === values.length - 1;
}

/**
 * The properties of a collection's features that may be counts: numbers wherever they are not null.
 * @returns  [{name, sum}], as the first feature that has them has them in order; those that seem to tell features apart last
 */
export function countsOf(json) {
  if (json?.type !== "FeatureCollection") return [];
  const all = new Map();
  for (const { properties } of json.features) {
    for (const [name, value] of Object.entries(properties ?? {})) {
      if (value === null) continue;
      if (!all.has(name)) all.set(name, []);
      all.get(name).push(value);
    }
  }
  const canBeNamed = (name) => !/,/.test(name) && !/^[-+.\d]/.test(name);
  const counts = [...all].map(([name, values]) => ({ name, sum: values.reduce((sum, value) => sum + countIn(value), 0), values }))
    .filter(({ name, sum }) => sum > 0 && sum < Infinity && canBeNamed(name));
  const rank = ({ name, values }) => Number(isIdentifier(name, values));
  return counts.sort((a, b) => rank(a) - rank(b)).map(({ name, sum }) => ({ name, sum }));
}

/** Whether all positions may be longitudes and latitudes, as RFC 7946 has them, in any turn that the server takes. */
export function mayBeDegrees({ minX, maxX, minY, maxY }) {
  return minX >= -540 && maxX <= 540 && minY >= -90 && maxY <= 90;
}
