// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/ccdt/maps/dot_ground.h"
#include "core/ccdt/polish/error_grid.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Measures the smoothed difference between the actual and the wanted density of a map's dots. Each octave of spacing
/// has a grid with the features of this octave and of the two adjacent octaves. The error of a dot is read from the
/// grid of its feature's octave. This grid contains all neighbouring features that are up to four times denser or
/// sparser. Features that it does not contain count as outside the border.
class DotError {
public:
    /// @param land  domain in whose unit frame all positions are given
    /// @param dots  used only to look up the feature of each dot
    ///
    /// O(dots + corners of the features).
    DotError(const DotGround& ground, const Domain& land, std::span<const FeatureDot> dots);

    /// @param positions  [dots] positions in the unit frame
    /// @param errors     out: [dots] results of ErrorGrid::at()
    ///
    /// O(dots).
    void measure(std::span<const Point> positions, std::span<double> errors);

private:
    struct Octave {
        ErrorGrid grid;
        Box box;                            ///< box over which the grid is stretched, in the unit frame
        std::vector<std::uint32_t> own;     ///< dots of the octave's own features
        std::vector<std::uint32_t> others;  ///< dots of features in the adjacent octaves
    };

    std::vector<Octave> octaves_;
    std::vector<Point> positions_;
};

}  // namespace ccdt
