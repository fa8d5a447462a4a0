// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "core/halftone/kind_mixture.h"
#include "core/halftone/overprint.h"
#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Chooses the grounds of inks such that dots on them can reproduce the picture. A threshold of one half for each ink
/// is not sufficient: several inks that each cover less than a half may need dots that together cover more than a half.
class InkGrounds {
public:
    /// @param wanted  light of the picture; must outlive this object
    InkGrounds(const InkSet& inks, const LightPlanes& wanted, Executor& executor);

    /// Changes the ground of inks where dots would cover more than a half of the area. Sets the bare share of these
    /// inks to a value near one half, so that the smoothing of the grounds can still change it.
    /// @param bare  [inks][cells] share of each cell that an ink leaves bare; modified
    void reduce_cover(std::vector<std::vector<float>>& bare);

    /// Finds cells where dots on the grounds of a plan cannot reproduce the colour. Sets the bare share of each ink to
    /// 0 or 1 there, according to a better ground.
    /// @returns  whether there are such cells
    bool replace_grounds(std::vector<std::vector<float>>& bare, const TwoSidedPlan& plan);

private:
    /// Returns the inks that cover at least a half of a cell, as bits.
    unsigned ground_of(const std::vector<std::vector<float>>& bare, std::size_t cell) const;

    /// Returns the share of a cell that all dots on a ground cover.
    float cover(unsigned ground, std::size_t cell);

    /// Returns whether dots on a ground cannot reproduce the light of a cell.
    bool is_unsuitable(unsigned ground, std::size_t cell);

    /// Returns the ground on which dots cover the smallest share. Considers all grounds that differ from the given one
    /// in some of the inks whose share is nearest to one half.
    unsigned best_near(const std::vector<std::vector<float>>& bare, unsigned ground, std::size_t cell);

    std::size_t inks_;
    const LightPlanes& wanted_;
    Executor& executor_;
    KindMixture mixture_;
};

}  // namespace ccdt
