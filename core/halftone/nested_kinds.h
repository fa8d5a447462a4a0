// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Adds the kinds of dots to a plan, with the areas of dots over that of the largest and, as their densities, the
/// shares that they cover, where the flipped areas of channels are nested.
///
/// @param share   [channels][cells] that is to be flipped
/// @param light   [channels][cells] of the picture
/// @param radius  of the dots, in cells
void add_nested_kinds(TwoSidedPlan& plan, std::span<const std::vector<float>> share,
                      std::span<const std::vector<float>> light, double radius, Executor& executor = inline_executor());

}  // namespace ccdt
