// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/input/option_reader.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Order of the points in an answer.
enum class PointOrder {
    None,         ///< the order of placement
    Path,         ///< along a short path
    Progressive,  ///< the first k points are spread evenly, for every k
};

/// Reads the option `order`. Errors: Malformed.
Result<PointOrder> read_point_order(const Input& input);
/// Reads the option `order` of points on a surface or in space, which has no value `path`.
Result<PointOrder> read_point_order3(const Input& input);

}  // namespace ccdt::api
