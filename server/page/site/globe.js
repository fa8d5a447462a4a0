// SPDX-License-Identifier: GPL-3.0-or-later
// Projects the globe onto a plane with equal-area projections, so that points spread evenly on the globe look even.

const radian = 180 / Math.PI;
const farthest = Math.cos(120 / radian);  // cosine of the maximum angle to the middle on a regional map
const longest = 1;  // degrees; longer edges are divided, because they are curves on the plane

function directionOf([longitude, latitude]) {
  const [a, b] = [longitude / radian, latitude / radian];
  return [Math.cos(b) * Math.cos(a), Math.cos(b) * Math.sin(a), Math.sin(b)];
}

/** Returns the direction of the middle of rings: the mean of the edges' middles, weighted by their lengths. */
function middleOf(rings) {
  const sum = [0, 0, 0];
  for (const ring of rings) {
    let before = directionOf(ring.at(-1));
    for (const position of ring) {
      const here = directionOf(position);
      const length = Math.hypot(...here.map((value, i) => value - before[i]));
      here.forEach((value, i) => { sum[i] += length * (value + before[i]); });
      before = here;
    }
  }
  return sum.map((value) => value / (Math.hypot(...sum) || 1));
}

/** Returns Lambert's azimuthal equal-area projection around a direction, near which shapes are hardly distorted. */
function azimuthal([x, y, z]) {
  const [longitude, sine, cosine] = [Math.atan2(y, x), z, Math.hypot(x, y)];
  return ([east, north]) => {
    const [a, b] = [east / radian - longitude, north / radian];
    const across = Math.cos(b) * Math.cos(a);
    const towards = sine * Math.sin(b) + cosine * across;
    const scale = radian * Math.sqrt(2 / Math.max(1 + towards, 1e-9));
    return [scale * Math.cos(b) * Math.sin(a), scale * (cosine * Math.sin(b) - sine * across)];
  };
}

/** Projects a position by the Equal Earth projection of the whole world (Savric, Patterson, Jenny 2019). */
function equalEarth([east, north]) {
  const t = Math.asin((Math.sqrt(3) / 2) * Math.sin(north / radian));
  const [a1, a2, a3, a4] = [1.340264, -0.081106, 0.000893, 0.003796];
  const x = (2 * Math.sqrt(3) * (east / radian) * Math.cos(t)) / (3 * (9 * a4 * t ** 8 + 7 * a3 * t ** 6 + 3 * a2 * t ** 2 + a1));
  return [radian * x, radian * (a4 * t ** 9 + a3 * t ** 7 + a2 * t ** 3 + a1 * t)];
}

/**
 * Returns a ring with continuous longitudes: adds multiples of 360 degrees after each jump of more than 180 degrees.
 * Extends a ring around a pole by an edge along the pole.
 */
function unrolled(ring) {
  const result = [];
  let shift = 0;
  for (const [longitude, latitude] of [...ring, ring[0]]) {
    const leap = result.length > 0 ? longitude + shift - result.at(-1)[0] : 0;
    if (Math.abs(leap) > 180) shift -= 360 * Math.sign(leap);
    result.push([longitude + shift, latitude]);
  }
  if (shift === 0) return result;
  const pole = 90 * Math.sign(ring.reduce((sum, [, latitude]) => sum + latitude, 0));
  return [...result, [result.at(-1)[0], pole], [result[0][0], pole]];
}

/** Clips a ring at a meridian. Keeps the east side if `side` is 1, the west side if it is -1. */
function cut(ring, meridian, side) {
  const inside = ([longitude]) => side * (longitude - meridian) >= 0;
  return ring.flatMap((to, i) => {
    const from = ring.at(i - 1);
    if (inside(from) === inside(to)) return inside(to) ? [to] : [];
    const share = (meridian - from[0]) / (to[0] - from[0]);
    const crossing = [meridian, from[1] + share * (to[1] - from[1])];
    return inside(to) ? [crossing, to] : [crossing];
  });
}

/** Cuts a part at longitudes -180 and 180 degrees, and shifts the pieces outside by 360 degrees. */
function inOneTurn(part) {
  const rings = part.map(unrolled);
  return [-360, 0, 360].map((shift) => rings
    .map((ring) => cut(cut(ring.map(([longitude, latitude]) => [longitude + shift, latitude]), -180, 1), 180, -1))
    .filter((ring) => ring.length > 2)).filter((some) => some.length > 0);
}

function bent(ring) {
  return ring.flatMap((to, i) => {
    const from = ring.at(i - 1);
    const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    const number = Math.max(1, Math.ceil(Math.hypot(dx, dy) / longest));
    return Array.from({ length: number }, (_, step) => [from[0] + (dx * step) / number, from[1] + (dy * step) / number]);
  });
}

/**
 * Projects parts onto a plane. Near the middle, the unit is a degree.
 *
 * @param parts  lists of rings of [longitude, latitude], in degrees
 * @returns      {parts, project}: the projected parts, and the projection for any other position
 */
export function onMap(parts) {
  const rings = parts.flat();
  const middle = middleOf(rings);
  const isNear = (position) => directionOf(position).reduce((sum, value, i) => sum + value * middle[i], 0) > farthest;
  const isWorld = !rings.every((ring) => ring.every(isNear));
  const project = isWorld ? equalEarth : azimuthal(middle);
  const turned = isWorld ? parts.flatMap(inOneTurn) : parts.map((part) => part.map(unrolled));
  return { parts: turned.map((part) => part.map((ring) => bent(ring).map(project))), project };
}
