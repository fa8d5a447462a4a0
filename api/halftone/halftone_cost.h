// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "api/halftone/halftone_request.h"
#include "api/run/options.h"

namespace ccdt::api {

/// Estimates the cost of computing an answer, before the computation begins. Returns an estimate for any parsed
/// request, even if its picture will be rejected. If the request gives no sites or no scale, the estimate is the
/// highest one for all pictures of the same size.
Cost cost_of(const HalftoneRequest& request, const Limits& limits);

/// Returns the default number of sites: sites_of_drawing() for drawings on screens, default_sites() for others. A
/// number above 4,096 is reduced if placing so many sites takes more than two seconds.
///
/// @param part           size of the drawn part of the picture
/// @param ink, fineness  as for default_sites()
std::size_t usual_sites(const HalftoneRequest& request, PictureSize part, double ink, double fineness,
                        const Limits& limits);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const HalftoneRequest& request);

}  // namespace ccdt::api
