// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stop_token>

#include "core/base/result.h"
#include "core/ccdt/globe/chart.h"
#include "core/ccdt/globe/region.h"
#include "core/geometry/inset.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Returns a disc in a chart's plane that contains all points whose distance on the ground from the point `position` is
/// at most `metres`. The radius has a margin of 1 part in 1,000, for two reasons: the edges of a charted region are
/// accurate only to this degree, and discs are placed along an edge in steps. If the disc would contain the point
/// opposite the chart's centre, its radius is the largest double.
///
/// Distances on the conformal sphere equal distances on the ground up to a factor, which varies with latitude by less
/// than 0.007 per radian. A disc on the sphere is a disc in the plane, but with another centre.
Disc disc_on_ground(const Chart& chart, Point position, double metres);

/// Erodes a part by `buffer` metres on the ground. If the region was divided into two parts along a circle, this circle
/// does not count as border. Does nothing if `buffer` is 0; positive values below kMinBuffer count as kMinBuffer.
/// Errors: Unusable if nothing is left, with the field `buffer`; Stopped.
Result<void> keep_off_border(ChartedPart& part, double buffer, const std::stop_token& stop = {});

}  // namespace ccdt
