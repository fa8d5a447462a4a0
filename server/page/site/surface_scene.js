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

/** Returns the triangles around each vertex. */
function facesAround(triangles, number) {
  const around = Array.from({ length: number }, () => []);
  triangles.forEach((triangle, face) => triangle.forEach((vertex) => around[vertex].push(face)));
  return around;
}

/**
 * Returns the normal at each corner of each triangle: the mean normal of the triangles around the corner, without those
 * that differ in direction by more than the angle of a visible edge.
 */
function cornerNormals(triangles, normals, around) {
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
 * Returns a function that finds the triangle nearest to a position, approximately: among the triangles around the nearest
 * vertex, the one with the nearest centre. The function returns undefined if no vertex lies within the distance.
 */
function nearestFace(places, triangles, around, distance) {
  const cells = new Map();
  const cellOf = (position) => position.map((value) => Math.floor((value + 1) / distance));
  const key = (x, y, z) => (x * 65536 + y) * 65536 + z;
  places.forEach((place, vertex) => {
    const at = key(...cellOf(place));
    if (!cells.has(at)) cells.set(at, []);
    cells.get(at).push(vertex);
  });
  const nearest = (indices, placeOf, position) => indices.reduce((best, index) => {
    const to = Math.hypot(...minus(placeOf(index), position));
    return to < best.to ? { index, to } : best;
  }, { to: distance }).index;
  const centre = (face) => scaled(triangles[face].map((vertex) => places[vertex]).reduce(([a, b, c], [x, y, z]) => [a + x, b + y, c + z]), 1 / 3);
  return (position) => {
    const [x, y, z] = cellOf(position);
    const steps = [-1, 0, 1];
    const near = steps.flatMap((dx) => steps.flatMap((dy) => steps.flatMap((dz) => cells.get(key(x + dx, y + dy, z + dz)) ?? [])));
    const vertex = nearest(near, (index) => places[index], position);
    return vertex === undefined ? undefined : nearest(around[vertex], centre, position);
  };
}

/**
 * Prepares a surface and points on it. Lengths are in units of the diameter of a ball around the surface, whose centre
 * is the origin.
 *
 * @param mesh     {vertices, triangles}
 * @param answer   {points, normals, rank, mesh}: points in the coordinates of the mesh, with the normal of the surface
 *                 at each point; `rank` is optional. Without `mesh`, each disc has the normal of the nearest triangle,
 *                 because the normals of the answer are smooth across sharp edges
 * @returns        {corners, normals, points, pointNormals, pitch}: flat arrays of coordinates, three corners for each
 *                 triangle, points in the sequence of their ranks; and the mean distance between points
 */
export function sceneOf({ vertices, triangles }, { points, normals, rank, mesh }) {
  const { centre, radius } = ballAround(vertices);
  const placed = (position) => scaled(minus(position, centre), 0.5 / radius);
  const places = vertices.map(placed);
  const faceNormals = triangles.map(([a, b, c]) => cross(minus(places[b], places[a]), minus(places[c], places[a])));
  const area = faceNormals.reduce((sum, normal) => sum + Math.hypot(...normal) / 2, 0);
  const sequence = points.map((_, index) => index);
  if (rank) sequence.sort((a, b) => rank[a] - rank[b]);
  const around = facesAround(triangles, vertices.length);
  const find = mesh ? () => undefined : nearestFace(places, triangles, around, 3 * Math.sqrt(area / Math.max(vertices.length, 1)));
  const normalAt = (place, index) => {
    const face = find(place);
    return face === undefined ? normals[index] : unit(faceNormals[face]);
  };
  const flat = (list) => Float32Array.from(list.flat());
  return {
    corners: flat(triangles.flatMap((triangle) => triangle.map((vertex) => places[vertex]))),
    normals: flat(cornerNormals(triangles, faceNormals, around)),
    points: flat(sequence.map((index) => placed(points[index]))),
    pointNormals: flat(sequence.map((index) => normalAt(placed(points[index]), index))),
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
