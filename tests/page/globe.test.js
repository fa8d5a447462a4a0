// SPDX-License-Identifier: GPL-3.0-or-later
// The globe on a plane: areas are preserved, and shapes cut by the antimeridian are joined.

import assert from "node:assert/strict";
import { test } from "node:test";

import { onMap } from "../../server/page/site/globe.js";
import { areaOf, boundsOf } from "../../server/page/site/shape.js";

const radian = 180 / Math.PI;
const box = (west, south, east, north) => [[west, south], [east, south], [east, north], [west, north], [west, south]];
const areaOnGlobe = (west, south, east, north) => (east - west) * radian * (Math.sin(north / radian) - Math.sin(south / radian));

function keepsAreas(boxes) {
  const { parts } = onMap(boxes.map((one) => [box(...one)]));
  for (const [i, one] of boxes.entries()) {
    const share = areaOf([parts[i]]) / areaOnGlobe(...one);
    assert.ok(Math.abs(share - 1) < 1e-3, `${one}: ${share}`);
  }
}

test("keeps areas of countries, around a pole, and on a map of the world", () => {
  keepsAreas([[5, 58, 10, 63], [10, 60, 30, 71], [15, 77, 30, 80]]);
  keepsAreas([[-170, -80, -90, -70], [0, -85, 120, -65]]);
  keepsAreas([[-120, 30, -80, 50], [20, -30, 40, 0], [100, -10, 150, 60]]);
});

test("joins parts cut at the antimeridian", () => {
  const { parts } = onMap([[box(176, -20, 180, -15)], [box(-180, -20, -178, -15)]]);
  const { minX, maxX } = boundsOf(parts.flat());
  assert.ok(maxX - minX < 6, `${maxX - minX} degrees wide`);
});

test("cuts a map of the world only at the antimeridian", () => {
  const crossing = [[170, 10], [-170, 10], [-170, 20], [170, 20], [170, 10]];
  const { parts } = onMap([[crossing], [box(-20, -50, 20, 50)]]);
  assert.equal(parts.length, 3);
  assert.ok(parts.every((part) => { const { minX, maxX } = boundsOf(part); return maxX - minX < 45; }));
  assert.ok(Math.abs(areaOf(parts.slice(0, 2)) / areaOnGlobe(170, 10, 190, 20) - 1) < 1e-3);
});

test("closes a ring around a pole along the pole", () => {
  const cap = Array.from({ length: 37 }, (_, i) => [-180 + 10 * i, -70]);
  for (const others of [[], [[box(0, 40, 10, 50)]]]) {
    const { parts } = onMap([[cap], ...others]);
    assert.ok(Math.abs(areaOf(others.length > 0 ? parts.slice(0, -1) : parts) / areaOnGlobe(-180, -90, 180, -70) - 1) < 1e-2);
  }
});
