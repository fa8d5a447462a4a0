// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Adds the kinds of dots to a plan that has grounds, such that the flipped areas of the channels are nested. In the
/// result, KindOfDots::area is relative to the largest dot, and KindOfDots::density is the covered share.
///
/// @param share   [channels][dot cells] share that dots should flip
/// @param light   [channels][dot cells] light of the picture
/// @param radius  radius of the dots, in dot cells
void add_nested_kinds(TwoSidedPlan& plan, std::span<const std::vector<float>> share,
                      std::span<const std::vector<float>> light, double radius, Executor& executor = inline_executor());

}  // namespace ccdt
