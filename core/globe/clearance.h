#pragma once

#include <stop_token>

#include "core/geometry/inset.h"
#include "core/geometry/point.h"
#include "core/globe/chart.h"
#include "core/globe/region.h"
#include "core/result.h"

namespace ccdt {

/// The disc in the plane of a chart in which all places lie that are nearer to one on the ground than so many metres,
/// with room of 1 part in 1,000: edges of a charted region are bent only as far, and are swept in steps. Where it would
/// reach around what is opposite the chart's centre its radius is larger than any plane.
///
/// The conformal sphere is the ground but for a factor that varies by latitude, less than 0.007 a radian. On it what is
/// nearer than an angle is a disc, and so it is in the plane, with another centre.
Disc disc_on_ground(const Chart& chart, Point place, double metres);

/// Takes from a part what is nearer to its border than so many metres; a cut is no border. Nothing happens for 0,
/// and what is less than kLeastBuffer counts as that.
/// Errors: Unusable if nothing is left, with the field `buffer`; Stopped.
Result<void> keep_off_border(ChartedPart& part, double buffer, const std::stop_token& stop = {});

}  // namespace ccdt
