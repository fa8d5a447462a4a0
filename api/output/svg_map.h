// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stop_token>

#include "api/input/palette.h"
#include "api/output/body.h"
#include "api/output/page.h"
#include "api/output/point_set.h"

namespace ccdt::api {

/// Writes points with a figure as SVG: the element with the id `outlines`, then a group for each feature, whose id is
/// `feature-2` for the feature with the index 2, then the group `legend`. Circles have the class `class-0` for the
/// first layer, and data-rank if points have ranks. User units are those of write_svg().
/// @param stop  once stopped, writing ends early and the output is incomplete
void write_svg_map(const PointSet& points, const Palette& palette, const Page& page, Body& body,
                   const std::stop_token& stop);

}  // namespace ccdt::api
