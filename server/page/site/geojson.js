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

/** Whether all positions may be longitudes and latitudes, as RFC 7946 has them, in any turn that the server takes. */
export function mayBeDegrees({ minX, maxX, minY, maxY }) {
  return minX >= -540 && maxX <= 540 && minY >= -90 && maxY <= 90;
}
