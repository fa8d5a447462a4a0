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

/**
 * The properties of a collection's features that may be counts: numbers wherever they are not null.
 * @returns  [{name, sum}], as the first feature that has them has them in order
 */
export function countsOf(json) {
  if (json?.type !== "FeatureCollection") return [];
  const sums = new Map();
  for (const { properties } of json.features) {
    for (const [name, value] of Object.entries(properties ?? {})) {
      if (value !== null) sums.set(name, (sums.get(name) ?? 0) + countIn(value));
    }
  }
  const canBeNamed = (name) => !/,/.test(name) && !/^[-+.\d]/.test(name);
  return [...sums].map(([name, sum]) => ({ name, sum })).filter(({ name, sum }) => sum > 0 && sum < Infinity && canBeNamed(name));
}

/** Whether all positions may be longitudes and latitudes, as RFC 7946 has them, in any turn that the server takes. */
export function mayBeDegrees({ minX, maxX, minY, maxY }) {
  return minX >= -540 && maxX <= 540 && minY >= -90 && maxY <= 90;
}
