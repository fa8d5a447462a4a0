#pragma once

#include <stop_token>

#include "api/image/image_codec.h"
#include "api/run/options.h"
#include "api/sample.h"
#include "core/geometry/domain.h"
#include "core/result.h"

namespace ccdt::api {

/// Takes what a request wants to be avoided from its area, what its mask marks and, in a plane, what is too near to the
/// border of what is left. The bounding box stays what it is.
///
/// @param area    of the request, and what was repaired in it; repairs of what is avoided are added
/// @param decode  reads a mask
/// @param stop    asked now and then: Error Stopped
/// Errors: Unusable if nothing is left, and for what is to be avoided as for the area itself; LimitExceeded for a mask
/// whose outline has more than kMostMaskCorners; those of `decode`. Fields are JSON Pointers.
Result<RepairedDomain> without_exclusions(RepairedDomain area, const SampleRequest& request, const Limits& limits,
                                          const Decode& decode, const std::stop_token& stop);

}  // namespace ccdt::api
