// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "core/halftone/kind_mixture.h"
#include "core/halftone/overprint.h"
#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Chooses the grounds of inks such that dots on them can reproduce the picture. It is not sufficient to give each ink
/// black ground where it covers more than a half: dots of several inks that each cover less than a half may together
/// cover more than a half.
class InkGrounds {
public:
    /// @param wanted  light of the picture; must outlive this object
    InkGrounds(const InkSet& inks, const LightPlanes& wanted, Executor& executor);

    /// Changes the ground of some inks in cells of which dots would cover more than a half. Sets the bare share of
    /// these inks to a value near one half, so that the smoothing of the grounds can still change the ground.
    /// @param bare  [inks][cells] share of each cell that an ink leaves bare; modified
    void reduce_cover(std::vector<std::vector<float>>& bare);

    /// Finds cells where dots on the grounds of a plan cannot reproduce the colour, but dots on another ground can.
    /// There, sets the bare share of each ink to 0 or 1, so that the cell gets that other ground.
    /// @returns  whether there are such cells
    bool replace_grounds(std::vector<std::vector<float>>& bare, const TwoSidedPlan& plan);

private:
    /// Returns the inks that cover at least a half of a cell, as bits.
    unsigned ground_of(const std::vector<std::vector<float>>& bare, std::size_t cell) const;

    /// Returns the share of a cell that all dots on a ground cover.
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
