// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stop_token>
#include <string>

#include "api/output/body.h"
#include "api/output/ink_dots.h"
#include "api/output/map_dots.h"

namespace ccdt::api {

/// Writes points as comma-separated values (RFC 4180): a header `x,y`, then a line for each point. If inks have names,
/// the points are written one ink after the other, with the name of the ink in a third column `ink`. Points with ranks
/// have a third column `rank`. Dots on both sides of the tonal scale have two more columns: `radius` and `side`, which
/// is ink or paper. With several channels they have three more: `radius`, `flips` and `ground`. Numbers have the fewest
/// digits that read back to the same double. A stop ends the output early and makes it useless.
void write_csv(std::span<const InkDots> inks, Body& body, const std::stop_token& stop = {});

/// Writes points as a NumPy array of float64. Its shape is [n, 2] with the columns x and y. If inks have names, it is
/// [n, 3], with the number of the ink from 0. If points have ranks, it is [n, 3], with the rank. For dots on both sides
/// of the tonal scale it is [n, 4], with the radius and the side, 0 for ink or 1 for paper. With several channels it is
/// [n, 5], with the radius, the flipped channels, and the inks of the ground. The latter two are sums of bits, 1 for
/// the first channel. Source: NEP 1, format version 1.0. A stop ends the output early and makes it useless.
void write_npy(std::span<const InkDots> inks, Body& body, const std::stop_token& stop = {});

/// Writes the dots of a map as comma-separated values. The columns are x, y, `rank` if dots have ranks, `feature` with
/// the index of the feature, `class` if classes have names, and the properties that points carry. Text is written as it
/// is, null as an empty field, and other values as JSON. A stop ends the output early and makes it useless.
void write_map_csv(const MapOfDots& map, Body& body, const std::stop_token& stop = {});

/// Writes the dots of a map as a NumPy array of float64. The columns are x, y, the rank if dots have ranks, the index
/// of the feature, and the number of the class, from 0, if classes have names. A stop ends the output early and makes
/// it useless.
void write_map_npy(const MapOfDots& map, Body& body, const std::stop_token& stop = {});

}  // namespace ccdt::api
