#pragma once

#include "api/input/option_reader.h"
#include "core/result.h"

namespace ccdt::api {

/// Order that points are answered in.
enum class PointOrder {
    None,         ///< as they were placed
    Path,         ///< along a short path
    Progressive,  ///< so that the first ones, however many, are spread evenly
};

/// Reads the option `order`. Errors: Malformed.
Result<PointOrder> read_point_order(const Input& input);

}  // namespace ccdt::api
