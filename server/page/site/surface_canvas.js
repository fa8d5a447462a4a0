// SPDX-License-Identifier: GPL-3.0-or-later
// Draws a surface with its points on a 2-D canvas, for browsers without WebGL 2. The farthest parts are drawn first.

/** Applies a rotation to the vectors of a flat array. */
function turned(values, turn) {
  const result = new Float32Array(values.length);
  for (let i = 0; i < values.length; i += 3) {
    for (let axis = 0; axis < 3; ++axis)
      result[i + axis] = turn[axis] * values[i] + turn[3 + axis] * values[i + 1] + turn[6 + axis] * values[i + 2];
  }
  return result;
}

const css = (colour, factor = 1) => `rgb(${colour.map((value) => Math.round(255 * factor * value)).join(" ")})`;

export class CanvasPainter {
  constructor(context) {
    this.context = context;
  }

  /** Draws a scene; see WebglPainter. */
  draw(scene, { turn, x, y, scale, width, height, ratio, radius, first, light, lineWidth, colours }) {
    const { context } = this;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const corners = turned(scene.corners, turn);
    const normals = turned(scene.normals, turn);
    const points = turned(scene.points.subarray(0, 3 * first), turn);
    const pointNormals = turned(scene.pointNormals.subarray(0, 3 * first), turn);
    const faces = corners.length / 9;
    const depth = new Float32Array(faces + first);
    for (let face = 0; face < faces; ++face) depth[face] = (corners[9 * face + 2] + corners[9 * face + 5] + corners[9 * face + 8]) / 3;
    for (let i = 0; i < first; ++i) depth[faces + i] = points[3 * i + 2] + radius;
    const sequence = Uint32Array.from(depth.keys()).sort((a, b) => depth[a] - depth[b]);

    const triangle = (face) => {
      const at = (corner) => [x + scale * corners[9 * face + 3 * corner], y - scale * corners[9 * face + 3 * corner + 1]];
      const [[ax, ay], [bx, by], [cx, cy]] = [at(0), at(1), at(2)];
      const isFront = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) < 0;
      let towards = 0;
      for (let i = 0; i < 9; ++i) towards += (normals[9 * face + i] * light[i % 3]) / 3;
      const shade = 0.5 + 0.5 * Math.max(isFront ? towards : -towards, 0);
      context.fillStyle = css(isFront ? colours.surface : colours.surface.map((value, i) => value * [1, 0.86, 0.72][i]), shade);
      context.strokeStyle = lineWidth > 0 ? css(colours.line) : context.fillStyle;  // the stroke also closes gaps
      context.beginPath();
      context.moveTo(ax, ay);
      context.lineTo(bx, by);
      context.lineTo(cx, cy);
      context.closePath();
      context.fill();
      context.stroke();
    };
    const disc = (i) => {
      const [nx, ny, nz] = scene.isFree ? [0, 0, 1] : pointNormals.subarray(3 * i, 3 * i + 3);
      const fading = scene.isFree ? 0.8 * (0.5 - points[3 * i + 2]) : 0;
      context.fillStyle = css(colours.ink.map((value, j) => value + fading * (colours.paper[j] - value)));
      context.beginPath();
      context.ellipse(x + scale * points[3 * i], y - scale * points[3 * i + 1], scale * radius, scale * radius * Math.abs(nz), Math.atan2(-ny, nx) + Math.PI / 2, 0, 2 * Math.PI);
      context.fill();
    };
    context.lineWidth = lineWidth || 0.7;
    for (const index of sequence) {
      if (index < faces) triangle(index);
      else disc(index - faces);
    }
  }
}
