// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "api/halftone/halftone_request.h"
#include "api/run/options.h"

namespace ccdt::api {

/// Estimates the cost of computing an answer, before the computation begins. Returns an estimate for any parsed
/// request, even if its picture will be rejected. If the request gives no number of sites or no scale, the estimate is
/// that for the most expensive picture of the same size.
Cost cost_of(const HalftoneRequest& request, const Limits& limits);

/// Returns the number of sites for a request that gives none: sites_of_drawing() for drawings on screens,
/// default_sites() for others. The number is at most the number of sites that can be placed in two seconds, or 4,096 if
/// that is more. It never exceeds limits.max_sites.
///
/// @param part      size of the drawn part of the picture
/// @param ink       area that dots cover, in pixels of the picture
/// @param fineness  fineness of the picture, in [0, 1]
std::size_t usual_sites(const HalftoneRequest& request, PictureSize part, double ink, double fineness,
                        const Limits& limits);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const HalftoneRequest& request);

}  // namespace ccdt::api
