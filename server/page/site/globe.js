// SPDX-License-Identifier: GPL-3.0-or-later
// The globe on the screen. Equal areas stay equal, so that points which are even on the ground look even.

const radian = 180 / Math.PI;
const farthest = Math.cos(120 / radian);  // from the middle of what is not a map of the world
const longest = 1;  // degrees: edges are straight in longitude and latitude, and bent on the screen

function directionOf([longitude, latitude]) {
  const [a, b] = [longitude / radian, latitude / radian];
  return [Math.cos(b) * Math.cos(a), Math.cos(b) * Math.sin(a), Math.sin(b)];
}

/** The middle of rings, each edge counting by its length. */
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

/** Lambert's azimuthal projection: what lies near the middle keeps its shape. */
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

/** The Equal Earth projection (Savric, Patterson, Jenny 2019): the whole world. */
function equalEarth([east, north]) {
  const t = Math.asin((Math.sqrt(3) / 2) * Math.sin(north / radian));
  const [a1, a2, a3, a4] = [1.340264, -0.081106, 0.000893, 0.003796];
  const x = (2 * Math.sqrt(3) * (east / radian) * Math.cos(t)) / (3 * (9 * a4 * t ** 8 + 7 * a3 * t ** 6 + 3 * a2 * t ** 2 + a1));
  return [radian * x, radian * (a4 * t ** 9 + a3 * t ** 7 + a2 * t ** 3 + a1 * t)];
}

/** A ring without jumps: where longitudes leap by more than half a turn it goes on in the next turn of the globe. */
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

/** What lies on one side of a meridian, which closes it; `side` is 1 for the east of it and -1 for the west. */
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

/** A part as it lies in the one turn that a map of the world shows: what is beyond comes in on the other side. */
function inOneTurn(part) {
  const rings = part.map(unrolled);
  return [-360, 0, 360].map((shift) => rings
    .map((ring) => cut(cut(ring.map(([longitude, latitude]) => [longitude + shift, latitude]), -180, 1), 180, -1))
    .filter((ring) => ring.length > 2)).filter((some) => some.length > 0);
}

/** A ring whose edges are no longer than what may be drawn straight. */
function bent(ring) {
  return ring.flatMap((to, i) => {
    const from = ring.at(i - 1);
    const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    const number = Math.max(1, Math.ceil(Math.hypot(dx, dy) / longest));
    return Array.from({ length: number }, (_, step) => [from[0] + (dx * step) / number, from[1] + (dy * step) / number]);
  });
}

/**
 * Lays a part of the globe, or all of it, onto a plane whose unit is a degree near the middle.
 * @param parts  lists of rings of positions in longitude and latitude, degrees
 * @returns  {parts, project}: the same on the plane, and what takes any position there
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
