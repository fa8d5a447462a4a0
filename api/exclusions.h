#pragma once

#include <stop_token>
#include <vector>

#include "api/image/image_codec.h"
#include "api/run/options.h"
#include "api/sample.h"
#include "core/geometry/domain.h"
#include "core/geometry/faults.h"
#include "core/geometry/polygon.h"
#include "core/result.h"

namespace ccdt::api {

/// Where no point of a request may lie, whatever its area is like, in the request's coordinates.
struct Exclusions {
    std::vector<Area> avoided;    ///< on the globe in any turn
    std::vector<Area> masked;     ///< what is dark in the mask
    std::vector<Repair> repairs;  ///< of what is avoided; fields are JSON Pointers
};

/// Finds what a request wants to be avoided, and what its mask marks.
/// @param box     bounding box of the area, over which the mask is stretched
/// @param decode  reads the mask
/// @param stop    asked now and then: Error Stopped
/// Errors: Unusable for what is to be avoided, as for an area; LimitExceeded for a mask whose outline has more than
/// kMostMaskCorners; those of `decode`. Fields are JSON Pointers.
Result<Exclusions> find_exclusions(const SampleRequest& request, const Box& box, const Limits& limits,
                                   const Decode& decode, const std::stop_token& stop);

/// Takes exclusions from a domain, or from a part of it. The bounding box stays what it is.
/// Errors: Unusable if nothing is left; Stopped. Fields are JSON Pointers.
Result<Domain> without(const Domain& domain, const Exclusions& exclusions, const SampleRequest& request,
                       const std::stop_token& stop);

/// Takes from a domain in the plane what is too near to its border. The bounding box stays what it is.
/// Errors: Unusable if nothing is left; Stopped. Fields are those of the request.
Result<Domain> without_buffer(const Domain& domain, const SampleRequest& request, const std::stop_token& stop);

/// Takes all of it from the area of a request; of the buffer, only in a plane.
/// @param area  repairs of what is avoided are added to its own
/// Errors: as all of these.
Result<RepairedDomain> without_exclusions(RepairedDomain area, const SampleRequest& request, const Limits& limits,
                                          const Decode& decode, const std::stop_token& stop);

}  // namespace ccdt::api
