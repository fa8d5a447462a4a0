// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the polygons and the counts in GeoJSON documents.

/** Returns the polygons of a document, each as a list of rings with the outer ring first. Skips other geometries. */
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

/** Whether the member `type` of a document is a type of GeoJSON. */
export function isGeojson(json) {
  const geometries = ["Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon", "GeometryCollection"];
  return ["Feature", "FeatureCollection", ...geometries].includes(json?.type);
}

/** Returns a value as a number of at least 0, otherwise NaN. The value may be a text, as in census files. */
function countIn(value) {
  const number = typeof value === "string" && value.trim() !== "" ? Number(value) : value;
  return Number.isFinite(number) && number >= 0 ? number : NaN;
}

/** Names of properties that identify features, such as codes and row numbers. */
const identifierName = /(^|_)(id|[fgop]id|fips|code|iso\w*|zip|key|nuts\w*|index|year)$|fips|fp$|geoid|objectid|postcode|[a-z](ID|Id|Code)$/;

/**
 * Whether a property probably identifies features instead of counting: it has a typical name, texts of equal lengths or
 * with leading zeros, or consecutive whole numbers.
 */
function isIdentifier(name, values) {
  if (identifierName.test(name) || identifierName.test(name.toLowerCase())) return true;
  if (values.length < 2) return false;
  if (values.every((value) => typeof value === "string"))
    return values.some((value) => /^0\d/.test(value)) || (values[0].length > 3 && values.every(({ length }) => length === values[0].length));
  if (values.length < 4 || !values.every(Number.isInteger) || new Set(values).size !== values.length) return false;
  const [least, most] = values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
  return most - least === values.length - 1;
}

/**
 * Returns the properties that may be counts, because all values are null or numbers of at least 0.
 * @returns  [{name, sum}] in the sequence of the document, but with probable identifiers at the end
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

/** Whether a bounding box may be in degrees of longitude (-540 to 540, as the server accepts) and latitude. */
export function mayBeDegrees({ minX, maxX, minY, maxY }) {
  return minX >= -540 && maxX <= 540 && minY >= -90 && maxY <= 90;
}
