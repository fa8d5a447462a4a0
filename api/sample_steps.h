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

/// Plans the page of a drawing. A requested width is kept, even if it exceeds the limit; a chosen one is reduced to it.
/// Errors: LimitExceeded.
Result<Page> plan_page(const SampleRequest& request, const Domain& domain, const Limits& limits);

/// Shifts points, whose longitudes are within half a turn, into the turn of the globe that is drawn.
void bring_into(const Box& box, std::vector<Point>& points);

/// Returns the radius of the dots, in units of the domain. It is at most twice the longer side of the bounding box,
/// since such a dot covers the box from anywhere inside.
double radius_of(const SampleRequest& request, const Domain& domain);

/// Converts an error about options to one about the request, in which they are members of the body or parameters.
Error error_of_options(const SampleRequest& request, Error error);

/// Reports repairs and warnings in `answer`, for formats whose body does not contain them.
void tell(const std::vector<Repair>& repairs, const std::vector<Warning>& warnings, Answer& answer);

}  // namespace ccdt::api
