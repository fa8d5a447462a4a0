// SPDX-License-Identifier: GPL-3.0-or-later
// Prepares a surface and its points for drawing, and makes the sample mesh of the page.

const smoothest = Math.cos((40 * Math.PI) / 180);  // faces that meet at a larger angle have a visible edge

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const scaled = (a, factor) => [a[0] * factor, a[1] * factor, a[2] * factor];
const unit = (a) => scaled(a, 1 / (Math.hypot(...a) || 1));

/** Returns the centre of the bounding box of vertices, and the largest distance of a vertex from it. */
function ballAround(vertices) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (const vertex of vertices) {
    for (let axis = 0; axis < 3; ++axis) {
      low[axis] = Math.min(low[axis], vertex[axis]);
      high[axis] = Math.max(high[axis], vertex[axis]);
    }
  }
  const centre = low.map((value, axis) => (value + high[axis]) / 2);
  const radius = vertices.reduce((most, vertex) => Math.max(most, Math.hypot(...minus(vertex, centre))), 0);
  return { centre, radius: radius || 1 };
}

/** Returns the normal at each corner of each triangle: the mean over those faces of the corner without a visible edge. */
function cornerNormals(triangles, normals, number) {
  const around = Array.from({ length: number }, () => []);
  triangles.forEach((triangle, face) => triangle.forEach((vertex) => around[vertex].push(face)));
  return triangles.flatMap((triangle, face) => {
    const own = unit(normals[face]);
    return triangle.map((vertex) => {
      const sum = [0, 0, 0];
      for (const other of around[vertex]) {
        const normal = normals[other];
        if (dot(own, normal) < smoothest * Math.hypot(...normal)) continue;
        for (let axis = 0; axis < 3; ++axis) sum[axis] += normal[axis];
      }
      return unit(sum);
    });
  });
}

/**
 * Prepares a surface and points on it. Lengths are in units of the diameter of a ball around the surface, whose centre
 * is the origin.
 *
 * @param mesh     {vertices, triangles}
 * @param answer   {points, normals, rank}: points in the coordinates of the mesh, with the normal of the surface at each
 *                 point; `rank` is optional
 * @returns        {corners, normals, points, pointNormals, pitch}: flat arrays of coordinates, three corners for each
 *                 triangle, points in the sequence of their ranks; and the mean distance between points
 */
export function sceneOf({ vertices, triangles }, { points, normals, rank }) {
  const { centre, radius } = ballAround(vertices);
  const placed = (position) => scaled(minus(position, centre), 0.5 / radius);
  const places = vertices.map(placed);
  const faceNormals = triangles.map(([a, b, c]) => cross(minus(places[b], places[a]), minus(places[c], places[a])));
  const area = faceNormals.reduce((sum, normal) => sum + Math.hypot(...normal) / 2, 0);
  const sequence = points.map((_, index) => index);
  if (rank) sequence.sort((a, b) => rank[a] - rank[b]);
  const flat = (list) => Float32Array.from(list.flat());
  return {
    corners: flat(triangles.flatMap((triangle) => triangle.map((vertex) => places[vertex]))),
    normals: flat(cornerNormals(triangles, faceNormals, vertices.length)),
    points: flat(sequence.map((index) => placed(points[index]))),
    pointNormals: flat(sequence.map((index) => normals[index])),
    pitch: Math.sqrt(area / Math.max(points.length, 1)),
  };
}

const knot = { along: 160, around: 16, thickness: 0.3 };

/** Returns a position on the axis of a trefoil knot. */
function trefoil(t) {
  const radius = 1 + 0.45 * Math.cos(3 * t);
  return [radius * Math.cos(2 * t), radius * Math.sin(2 * t), 0.5 * Math.sin(3 * t)];
}

/** Makes the sample mesh: a tube around a trefoil knot, whose grey changes along the knot, as the text of an OBJ file. */
export function sampleMesh() {
  const { along, around, thickness } = knot;
  const lines = [];
  for (let i = 0; i < along; ++i) {
    const t = (2 * Math.PI * i) / along;
    const at = trefoil(t);
    const direction = unit(minus(trefoil(t + 0.001), trefoil(t - 0.001)));
    const side = unit(cross(direction, at));
    const up = cross(direction, side);
    const grey = (0.5 + 0.45 * Math.cos(3 * t)).toFixed(3);
    for (let j = 0; j < around; ++j) {
      const angle = (2 * Math.PI * j) / around;
      const vertex = at.map((value, axis) => value + thickness * (Math.cos(angle) * side[axis] + Math.sin(angle) * up[axis]));
      lines.push(`v ${vertex.map((value) => value.toFixed(4)).join(" ")} ${grey} ${grey} ${grey}`);
    }
  }
  const index = (i, j) => (i % along) * around + (j % around) + 1;
  for (let i = 0; i < along; ++i) {
    for (let j = 0; j < around; ++j) {
      const [a, b, c, d] = [index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j)];
      lines.push(`f ${a} ${b} ${c}`, `f ${a} ${c} ${d}`);
    }
  }
  return `${lines.join("\n")}\n`;
}
