// SPDX-License-Identifier: GPL-3.0-or-later
// Counts and areas of large maps.

import assert from "node:assert/strict";
import { test } from "node:test";

import { countsOf } from "../../server/page/site/geojson.js";
import { areaOf } from "../../server/page/site/shape.js";

const many = 200_000;  // exceeds the number of arguments of a call

test("counts the properties of very many features", () => {
  const features = Array.from({ length: many }, (_, row) => ({ type: "Feature", properties: { row, people: 2 }, geometry: null }));
  assert.deepEqual(countsOf({ type: "FeatureCollection", features }),
    [{ name: "people", sum: 2 * many }, { name: "row", sum: (many * (many - 1)) / 2 }]);
});

test("measures a polygon with very many holes", () => {
  const square = (x, side) => [[x, 0], [x + side, 0], [x + side, side], [x, side]];
  const holes = Array.from({ length: many }, (_, i) => square(2 * i, 1));
  assert.equal(areaOf([[square(0, 2 * many), ...holes]]), (2 * many) ** 2 - many);
});
