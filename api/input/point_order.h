// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/input/option_reader.h"
#include "core/result.h"

namespace ccdt::api {

/// Order of the points in an answer.
enum class PointOrder {
    None,         ///< as they were placed
    Path,         ///< along a short path
    Progressive,  ///< every first part of the points is spread evenly
};

/// Reads the option `order`. Errors: Malformed.
Result<PointOrder> read_point_order(const Input& input);

}  // namespace ccdt::api
