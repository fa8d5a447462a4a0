// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/sample.h"
#include "core/dotmap/dot_map.h"
#include "core/geometry/domain.h"
#include "core/result.h"

namespace ccdt::api {

/// Puts points into the order that a request asks for; a progressive order also gives them ranks. The path of a drawing
/// of shapes is left to its writer.
/// Errors: Stopped, unless the request accepts partial results. After a stop the order has no meaning.
Result<void> order_points(const SampleRequest& request, const Domain& domain, Distribution& points,
                          const Control& control);

/// Does the same for the dots of a class of a dot map. They stay grouped by feature, and the order applies within each
/// feature. Ranks are among all dots of the class.
/// @param whole  union of all features
Result<void> order_dots(const SampleRequest& request, const Domain& whole, ClassDots& dots, const Control& control);

}  // namespace ccdt::api
