#pragma once

#include "api/sample.h"
#include "core/dotmap/dot_map.h"
#include "core/geometry/domain.h"
#include "core/result.h"

namespace ccdt::api {

/// Puts points into the order that a request asks for, and ranks them if it is progressive. The path of a drawing is
/// left to its writer.
/// Errors: Stopped, unless the request takes what there is by the deadline: points are then in an order of no use.
Result<void> order_points(const SampleRequest& request, const Domain& domain, Distribution& points,
                          const Control& control);

/// The same of the dots of a map's class. They stay by features, and in each are in the order that is asked for; ranks
/// are those among all dots of the class.
/// @param whole  all features together
Result<void> order_dots(const SampleRequest& request, const Domain& whole, ClassDots& dots, const Control& control);

}  // namespace ccdt::api
