// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stop_token>

#include "api/output/body.h"
#include "api/output/point_set.h"

namespace ccdt::api {

/// Writes points as comma-separated values (RFC 4180): a header, then a line for each point, one layer after the other.
/// The columns are x, y, `rank` if points have ranks, and `ink` if inks have names. If points are grouped by features,
/// the columns after x, y and `rank` are `feature` (the index of the feature), `class` if classes have names, and the
/// properties that points carry. A property is written as it is if it is text, as an empty field if it is null, and
/// otherwise as JSON. Numbers have the fewest digits that read back to the same double. After a stop, the output is
/// incomplete.
void write_csv(const PointSet& points, Body& body, const std::stop_token& stop = {});

/// Writes points as a NumPy array of float64. The first columns are x and y. They are followed by the rank if points
/// have ranks, by the index of the feature if points are grouped by features, and by the number of the layer, from 0,
/// if layers have names. Source: NEP 1, format version 1.0. After a stop, the output is incomplete.
void write_npy(const PointSet& points, Body& body, const std::stop_token& stop = {});

}  // namespace ccdt::api
