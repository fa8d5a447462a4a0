// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "api/image/image_codec.h"
#include "api/output/point_drawing.h"
#include "api/run/options.h"
#include "api/sample.h"
#include "core/ccdt/ccdt.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/result.h"

// Steps shared by all answers of /sample.
namespace ccdt::api {

/// Creates the density of a request. Errors: those of `decode` and of Density::grid, with a JSON Pointer.
Result<Density> make_density(const SampleRequest& request, const Limits& limits, const Decode& decode,
                             const Control& control);

/// Plans the page of a drawing. If the request gives no width, the page has at most limits.max_pixels. Errors:
/// LimitExceeded for a requested width that makes more pixels.
Result<Page> plan_page(const SampleRequest& request, const Domain& domain, const Limits& limits);

/// Shifts the longitudes of points, which are from -180 to 180 degrees, by multiples of 360 degrees, so that the points
/// lie in the box that is drawn.
void bring_into(const Box& box, std::vector<Point>& points);

/// Returns the radius of the dots, in units of the domain. The radius is at most twice the longer side of the bounding
/// box; a dot of that size covers the box wherever its centre lies in the box.
double radius_of(const SampleRequest& request, const Domain& domain);

/// Converts an error about options of core to an error about the request, where these options are members of the body
/// or query parameters.
Error error_of_options(const SampleRequest& request, Error error);

/// Stores repairs and warnings in `answer`, for formats whose body cannot list them.
void add_remarks(const std::vector<Repair>& repairs, const std::vector<Warning>& warnings, Answer& answer);

}  // namespace ccdt::api
