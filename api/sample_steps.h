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

// Steps that the answers of /sample share.
namespace ccdt::api {

/// Makes the density that a request has. Errors: those of `decode` and of Density::grid, with a JSON Pointer.
Result<Density> make_density(const SampleRequest& request, const Limits& limits, const Decode& decode,
                             const Control& control);

/// Plans the sheet. A width that was asked for is kept, and may be too much; a chosen one gives way to the limit.
/// Errors: LimitExceeded.
Result<Page> plan_page(const SampleRequest& request, const Domain& domain, const Limits& limits);

/// Brings points, whose longitudes are within half a turn, to the turn of the globe that is drawn.
void bring_into(const Box& box, std::vector<Point>& points);

/// Radius of the dots, in units of the domain: a dot of twice its box's longer side covers it from anywhere inside.
double radius_of(const SampleRequest& request, const Domain& domain);

/// Makes an error about options one about the request: they are members of its body, or parameters.
Error error_of_options(const SampleRequest& request, Error error);

/// Tells of repairs and warnings in an answer whose body does not.
void tell(const std::vector<Repair>& repairs, const std::vector<Warning>& warnings, Answer& answer);

}  // namespace ccdt::api
