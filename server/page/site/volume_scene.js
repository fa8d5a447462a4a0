// SPDX-License-Identifier: GPL-3.0-or-later
// Prepares points in space for drawing, in a frame of the edges of their box. The page loads this module only when it
// shows such points.

const rod = 0.003;  // half the thickness of an edge, in diameters of a ball around the box

/** Returns flat arrays of the corners and normals of triangles: a square rod along each edge of a box around the origin. */
function rodsAround(half) {
  const [corners, normals] = [[], []];
  for (const axis of [0, 1, 2]) {
    const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    const across = (quarters) => [Math.cos((quarters * Math.PI) / 2), Math.sin((quarters * Math.PI) / 2)];
    for (const [toU, toV] of [[-1, -1], [-1, 1], [1, -1], [1, 1]]) {
      for (const side of [0, 1, 2, 3]) {
        for (const [end, turn] of [[-1, 0], [-1, 1], [1, 1], [-1, 0], [1, 1], [1, 0]]) {
          const [corner, normal] = [[], [0, 0, 0]];
          [normal[u], normal[v]] = across(side + 0.5);
          const [du, dv] = across(side + turn);
          corner[axis] = end * half[axis];
          corner[u] = toU * half[u] + rod * du;
          corner[v] = toV * half[v] + rod * dv;
          corners.push(...corner);
          normals.push(...normal);
        }
      }
    }
  }
  return { corners: Float32Array.from(corners), normals: Float32Array.from(normals) };
}

/**
 * Prepares points in a box; see `sceneOf` for surfaces. The points are not on a surface: their discs face the viewer, hide
 * each other, and fade with distance.
 *
 * @param domain  {width, height, depth}: the box from the origin; undefined: the bounding box of the points
 * @param answer  {points, rank}; `rank` is optional
 */
export function volumeSceneOf(domain, { points, rank }) {
  const [low, high] = domain ? [[0, 0, 0], [domain.width, domain.height, domain.depth]]
    : [Math.min, Math.max].map((most) => points.reduce((a, b) => a.map((value, axis) => most(value, b[axis]))));
  const sides = high.map((value, axis) => value - low[axis]);
  const scale = 1 / (Math.hypot(...sides) || 1);
  const places = new Float32Array(3 * points.length);
  points.forEach((point, index) => places.set(point.map((value, axis) => scale * (value - low[axis] - sides[axis] / 2)), 3 * (rank?.[index] ?? index)));
  return {
    ...rodsAround(sides.map((side) => (scale * side) / 2)),
    points: places, pointNormals: new Float32Array(places.length),
    pitch: scale * Math.cbrt((sides[0] * sides[1] * sides[2]) / Math.max(points.length, 1)),
    isFree: true,
  };
}
