// SPDX-License-Identifier: GPL-3.0-or-later
// Computes outlines, bounding boxes and areas of shapes.

import { polygonsOf } from "./geojson.js";
import { onMap } from "./globe.js";

export const unitTorus = { type: "torus", width: 1, height: 1 };
export const rectangle = { type: "rectangle", width: 1.5, height: 1 };

export const firstPolygon = {
  polygon: [[0.1, 0.1], [0.75, 0.04], [1.4, 0.16], [1.3, 0.62], [1.42, 0.94], [0.85, 0.8], [0.36, 0.96], [0.06, 0.6]],
  holes: [[[0.5, 0.32], [0.78, 0.28], [0.86, 0.52], [0.6, 0.62]]],
};

const boxRing = ({ width, height }) => [[0, 0], [width, 0], [width, height], [0, height]];

const isRing = (ring) => Array.isArray(ring) && ring.length > 0 &&
  ring.every((corner) => Array.isArray(corner) && corner.length >= 2 && corner.every(Number.isFinite));

/**
 * Reads a polygon from parsed JSON: {polygon, holes}, or a single ring.
 * @returns  {polygon, holes}; null if the JSON has another form
 */
export function polygonOf(json) {
  const { polygon, holes = [] } = Array.isArray(json) ? { polygon: json } : json ?? {};
  if (!isRing(polygon) || !Array.isArray(holes) || !holes.every(isRing)) return null;
  return { polygon, ...(holes.length > 0 && { holes }) };
}

/** Returns the parts of a shape, each as a list of rings with the outer ring first. A surface has a unit square. */
function partsOf(shape) {
  if (shape.file?.mesh) return [[boxRing({ width: 1, height: 1 })]];
  if (shape.domain) return [[boxRing(shape.domain)]];
  if (shape.polygon) return [[shape.polygon, ...(shape.holes ?? [])]];
  return polygonsOf(shape.json);
}

/**
 * Returns the outline of a shape on the screen plane.
 *
 * @param onGlobe  whether positions are longitude and latitude
 * @returns        {parts, rings, project}: the corners on a plane whose y axis points up, and the projection of
 *                 positions onto this plane
 */
export function outlineOf(shape, onGlobe) {
  const given = partsOf(shape);
  const { parts, project } = onGlobe ? onMap(given) : { parts: given, project: (position) => position };
  return { parts, rings: parts.flat(), project };
}

export function boundsOf(rings) {
  const bounds = { minX: Infinity, minY: Infinity, maxX: -Infinity, maxY: -Infinity };
  for (const [x, y] of rings.flat()) {
    bounds.minX = Math.min(bounds.minX, x);
    bounds.maxX = Math.max(bounds.maxX, x);
    bounds.minY = Math.min(bounds.minY, y);
    bounds.maxY = Math.max(bounds.maxY, y);
  }
  return bounds;
}

function signedArea(ring) {
  let twice = 0;
  ring.forEach(([x, y], i) => {
    const [nextX, nextY] = ring[(i + 1) % ring.length];
    twice += x * nextY - nextX * y;
  });
  return twice / 2;
}

export function isInside([x, y], rings) {
  let odd = false;
  for (const ring of rings) {
    ring.forEach(([ax, ay], i) => {
      const [bx, by] = ring[(i + 1) % ring.length];
      if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) odd = !odd;
    });
  }
  return odd;
}

/** Computes the total area of parts, overlaps included. Assumes that the largest ring of a part is the outer one. */
export function areaOf(parts) {
  const area = (part) => {
    const areas = part.map((ring) => Math.abs(signedArea(ring)));
    return 2 * areas.reduce((most, one) => Math.max(most, one), 0) - areas.reduce((sum, one) => sum + one, 0);
  };
  return parts.reduce((sum, part) => sum + area(part), 0);
}

/**
 * Returns the polygons that a triangulation covers, each with its holes.
 *
 * @param mesh  {vertices, boundary}: outer rings run counter-clockwise, holes clockwise
 */
export function polygonsOfMesh({ vertices, boundary }) {
  const rings = boundary.map((ring) => ring.map((index) => vertices[index]));
  const polygons = rings.filter((ring) => signedArea(ring) > 0).map((ring) => [ring]);
  for (const hole of rings.filter((ring) => signedArea(ring) <= 0)) {
    const around = polygons.filter(([outer]) => isInside(hole[0], [outer]));
    around.sort(([a], [b]) => signedArea(a) - signedArea(b));
    around[0]?.push(hole);
  }
  return polygons;
}

/**
 * Estimates the largest square inside rings: the largest square of grid cells whose nodes are all inside.
 * @returns  {x, y, side}; `side` is 0 if there is no such square
 */
export function largestSquare(rings, cells = 96) {
  const { minX, minY, maxX, maxY } = boundsOf(rings);
  const step = Math.max(maxX - minX, maxY - minY) / cells;
  const columns = Math.floor((maxX - minX) / step) + 1;
  const rows = Math.floor((maxY - minY) / step) + 1;
  let best = { x: minX, y: minY, side: 0 };
  let above = new Array(columns).fill(0);
  for (let row = 0; row < rows; ++row) {
    const current = [];
    for (let column = 0; column < columns; ++column) {
      const inside = isInside([minX + column * step, minY + row * step], rings);
      current.push(inside ? 1 + Math.min(above[column], above[column - 1] ?? 0, current[column - 1] ?? 0) : 0);
      const side = (current[column] - 1) * step;
      if (side > best.side) best = { x: minX + column * step - side, y: minY + row * step - side, side };
    }
    above = current;
  }
  return best;
}
