// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "core/halftone/kind_mixture.h"
#include "core/halftone/overprint.h"
#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Chooses grounds of inks on which dots can make the picture: inks that each cover less than a half may take more than
/// half of the light together.
class InkGrounds {
public:
    /// @param wanted  light of the picture; kept by reference
    InkGrounds(const InkSet& inks, const LightPlanes& wanted, Executor& executor);

    /// Turns grounds over where dots on them would cover too much, but leaves them near to a half.
    /// @param bare  [inks][cells] what inks leave bare
    void settle(std::vector<std::vector<float>>& bare);

    /// Makes sure of better grounds where dots cannot make the picture on those of a plan.
    /// @returns  whether there are such places
    bool repair(std::vector<std::vector<float>>& bare, const TwoSidedPlan& plan);

private:
    unsigned ground_of(const std::vector<std::vector<float>>& bare, std::size_t cell) const;

    /// Share that all dots cover.
    float cover(unsigned ground, std::size_t cell);

    /// Tells whether dots on a ground cannot make the light of a cell.
    bool is_off(unsigned ground, std::size_t cell);

    /// Finds the ground on which dots cover least, of those that differ from one in the inks nearest to a half.
    unsigned best_near(const std::vector<std::vector<float>>& bare, unsigned ground, std::size_t cell);

    std::size_t inks_;
    const LightPlanes& wanted_;
    Executor& executor_;
    KindMixture mixture_;
};

}  // namespace ccdt
