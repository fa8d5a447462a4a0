// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stop_token>

#include "core/halftone/overprint.h"
#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Adds the kinds of dots to a plan, with the areas of dots over that of the largest and, as their densities, the
/// shares that they cover, such that the mean colour of ground and dots is that of the picture (KindMixture). Sets the
/// light of the channels to what the inks then leave bare.
///
/// @param light   of the picture
/// @param radius  of the dots, in cells
/// @param sigma   of the blur that the dots' places are sharpened against, in cells
/// @param stop    asked between steps; a stop ends it early, with nothing of use
void add_mixed_kinds(TwoSidedPlan& plan, const InkSet& inks, LightPlanes light, double radius, double sigma,
                     const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt
