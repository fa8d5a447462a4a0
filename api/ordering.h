// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/sample.h"
#include "core/dotmap/dot_map.h"
#include "core/geometry/domain.h"
#include "core/result.h"

namespace ccdt::api {

/// Puts points into the order that a request asks for. A progressive order also gives them ranks. Does nothing for a
/// path in SVG, PDF and other drawings of shapes, whose writers find the path themselves.
/// Errors: Stopped, unless the request accepts partial results. After a stop, the order is arbitrary.
Result<void> order_points(const SampleRequest& request, const Domain& domain, Distribution& points,
                          const Control& control);

/// Orders the dots of one class of a dot map like order_points(). The dots stay grouped by feature. A path is found for
/// each feature separately. A progressive order is computed for the whole class: ranks count all dots of the class, and
/// the dots of each feature are sorted by rank.
/// @param whole  union of all features
Result<void> order_dots(const SampleRequest& request, const Domain& whole, ClassDots& dots, const Control& control);

}  // namespace ccdt::api
