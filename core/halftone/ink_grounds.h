// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "core/halftone/kind_mixture.h"
#include "core/halftone/overprint.h"
#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Chooses the grounds of inks such that dots on them can reproduce the picture. It does not suffice to make the ground
/// of an ink black where this ink covers more than a half. Several inks that each cover less than a half may need dots
/// that together cover more than a half.
class InkGrounds {
public:
    /// @param wanted  light of the picture; must outlive this object
    InkGrounds(const InkSet& inks, const LightPlanes& wanted, Executor& executor);

    /// Exchanges white and black ground of some inks in each cell where dots would cover more than a half. Sets the
    /// bare share of these inks to 0.35 or 0.65, so that the later smoothing can still change their ground.
    /// @param bare  [inks][cells] share of each cell that an ink leaves bare; modified
    void reduce_cover(std::vector<std::vector<float>>& bare);

    /// Finds cells where dots on the grounds of a plan cannot reproduce the colour, but dots on another ground can.
    /// Sets the bare share of each ink in such a cell to 0 or 1, so that the cell gets the better ground.
    /// @returns  whether there are such cells
    bool replace_grounds(std::vector<std::vector<float>>& bare, const TwoSidedPlan& plan);

private:
    /// Returns the inks that cover at least a half of a cell, as bits.
    unsigned ground_of(const std::vector<std::vector<float>>& bare, std::size_t cell) const;

    /// Returns the share of a cell that dots on a ground must cover.
    /// @param ground  solid inks, as bits
    float cover(unsigned ground, std::size_t cell);

    /// Returns whether dots on a ground cannot reproduce the light of a cell.
    bool is_unsuitable(unsigned ground, std::size_t cell);

    /// Returns the ground on which dots cover the smallest share. Considers the given ground, and all grounds that
    /// differ from it only in the three inks whose bare share is nearest to one half.
    unsigned best_near(const std::vector<std::vector<float>>& bare, unsigned ground, std::size_t cell);

    std::size_t inks_;
    const LightPlanes& wanted_;
    Executor& executor_;
    KindMixture mixture_;
};

}  // namespace ccdt
