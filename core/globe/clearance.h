// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stop_token>

#include "core/geometry/inset.h"
#include "core/geometry/point.h"
#include "core/globe/chart.h"
#include "core/globe/region.h"
#include "core/result.h"

namespace ccdt {

/// Returns the disc in a chart's plane that contains all points within a distance in metres of a point on the ground.
/// The radius has a margin of 1 part in 1,000: edges of a charted region are bent with that accuracy only, and discs
/// along an edge are placed in steps. If the disc would contain the point opposite the chart's centre, its radius is
/// the largest double.
///
/// Distances on the conformal sphere equal those on the ground up to a factor, which varies with latitude by less than
/// 0.007 per radian. A disc on the sphere is a disc in the plane, but with another centre.
Disc disc_on_ground(const Chart& chart, Point place, double metres);

/// Removes from a part all points within `buffer` metres of its border. The circle along which the region was cut does
/// not count as border. Does nothing if `buffer` is 0; positive values below kLeastBuffer count as kLeastBuffer.
/// Errors: Unusable if nothing is left, with the field `buffer`; Stopped.
Result<void> keep_off_border(ChartedPart& part, double buffer, const std::stop_token& stop = {});

}  // namespace ccdt
