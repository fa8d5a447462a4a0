// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stop_token>

#include "core/halftone/overprint.h"
#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Adds the kinds of dots to a plan that has grounds. The mean colour of ground and dots is then the colour of the
/// picture (KindMixture). In the result, KindOfDots::area is relative to the largest dot, and KindOfDots::density is
/// the covered share. Sets the light of each channel to the share that the ink leaves bare, by its ground and its dots
/// together.
///
/// @param light   [dot cells] light of the picture
/// @param radius  radius of the dots, in dot cells
/// @param sigma   standard deviation, in dot cells, of the blur that sharpening compensates
/// @param stop    polled between steps; after a stop the plan must not be used
void add_mixed_kinds(TwoSidedPlan& plan, const InkSet& inks, LightPlanes light, double radius, double sigma,
                     const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt
