// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stop_token>
#include <string>

#include "api/output/body.h"
#include "api/output/ink_dots.h"
#include "api/output/map_dots.h"

namespace ccdt::api {

/// Writes points as comma-separated values (RFC 4180): a header `x,y`, then a line for each point. Points of named inks
/// are written one ink after the other, with a third column `ink`, its name. Points with ranks have a third column
/// `rank`. Dots on both sides of the tonal scale have the further columns `radius` and `side`, which is ink or paper;
/// with several channels `radius`, `flips` and `ground`. Numbers have the fewest digits that read back to the same
/// double. A stop ends the output early and makes it useless.
void write_csv(std::span<const InkDots> inks, Body& body, const std::stop_token& stop = {});

/// Writes points as a NumPy array, float64 [n, 2]. With named inks it is [n, 3], the last column being the number of
/// the ink, from 0; with ranks [n, 3], the last column being the rank. Dots on both sides of the tonal scale have [n,
/// 4], with the radius, and 0 for ink or 1 for paper; with several channels [n, 5], with the radius, the flipped
/// channels, and the inks of the ground, both as bits. Source: NEP 1, format version 1.0. A stop ends the output early
/// and makes it useless.
void write_npy(std::span<const InkDots> inks, Body& body, const std::stop_token& stop = {});

/// Writes the dots of a map as comma-separated values. After x and y come `rank` if dots have ranks, `feature`, which
/// is its index, `class` if classes have names, and the properties that points carry: text as it is, other values as
/// JSON, null as nothing. A stop ends the output early and makes it useless.
void write_map_csv(const MapOfDots& map, Body& body, const std::stop_token& stop = {});

/// Writes the dots of a map as a NumPy array, float64 [n, 3], the last column being the index of the feature. If
/// classes have names, it is [n, 4], the last column being the number of the class, from 0. If dots have ranks, these
/// are a column before both. A stop ends the output early and makes it useless.
void write_map_npy(const MapOfDots& map, Body& body, const std::stop_token& stop = {});

}  // namespace ccdt::api
