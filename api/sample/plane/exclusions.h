// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "api/decode/decode.h"
#include "api/run/options.h"
#include "api/sample/plane/sample_request.h"
#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/geometry/faults.h"
#include "core/geometry/polygon.h"

namespace ccdt::api {

/// Maximum number of corners of the outline of an excluded picture.
inline constexpr std::size_t kMaxExcludedCorners = 100'000;

/// Areas, in the coordinates of a request, that are subtracted from its domain: no point may lie in them.
struct Exclusions {
    std::vector<Area> avoided;  ///< areas of the option `avoid`; on the globe, longitudes may differ from those of the
                                ///< domain by multiples of 360 degrees
    std::vector<Area> dark;     ///< dark area of the excluded picture; empty if there is none
    std::vector<Repair> repairs;  ///< repairs of the avoided areas; fields are JSON Pointers
};

/// Computes the areas that the options `avoid` and `exclude` subtract.
/// @param box  bounding box of the domain, over which the excluded picture is stretched
/// Errors: Unusable for avoided areas that cannot be repaired, or that need a repair although the request rejects
/// invalid polygons; LimitExceeded for a picture whose outline has more than kMaxExcludedCorners corners; those of
/// `decode`; Stopped. Fields are JSON Pointers.
Result<Exclusions> find_exclusions(const SampleRequest& request, const Box& box, const Limits& limits,
                                   const Decode& decode, const std::stop_token& stop);

/// Subtracts exclusions from a domain, or from the area of a feature. The result keeps the bounding box of `domain`.
/// Errors: Unusable if the remaining domain is empty; Stopped. Fields are JSON Pointers.
Result<Domain> without(const Domain& domain, const Exclusions& exclusions, const SampleRequest& request,
                       const std::stop_token& stop);

/// Erodes a domain in the plane by the buffer of a request. The result keeps the bounding box of `domain`.
/// Errors: Unusable if the remaining domain is empty; Stopped.
Result<Domain> without_buffer(const Domain& domain, const SampleRequest& request, const std::stop_token& stop);

}  // namespace ccdt::api
