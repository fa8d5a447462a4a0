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

/// Returns an upper estimate of the size of the answer in bytes. The maximum numbers of sites and pixels are those of
/// cost_of().
std::size_t largest_answer(const HalftoneRequest& request, const Limits& limits);

/// Returns the number of sites for a request that gives none: sites_of_drawing() for drawings on screens,
/// default_sites() for others. The result is at most the number of sites that can be placed in two seconds. This limit
/// is at least 4,096, unless limits.max_sites is lower.
///
/// @param part      size of the drawn part of the picture
/// @param ink       area that dots should cover, in pixels of the picture
/// @param fineness  result of fineness() for the picture, in [0, 1]
std::size_t usual_sites(const HalftoneRequest& request, PictureSize part, double ink, double fineness,
                        const Limits& limits);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const HalftoneRequest& request);

}  // namespace ccdt::api
