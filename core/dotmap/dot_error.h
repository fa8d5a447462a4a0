#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/dotmap/dot_ground.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/polish/error_grid.h"

namespace ccdt {

/// Measures how far the density of a map's dots, smoothed over a few of them, is off the wanted one: with a grid for
/// each octave of the features' spacings, on which lie the features of this octave and of the ones beside it, and their
/// dots. Each dot takes its error from the grid of its own feature's octave. So dots know of all neighbours up to four
/// times as dense or as sparse as theirs; features that contrast more are to each other what is beyond the border.
class DotError {
public:
    /// @param land  whose unit frame places are in
    /// @param dots  as to their features
    /// O(dots + corners of the features).
    DotError(const DotGround& ground, const Domain& land, std::span<const FeatureDot> dots);

    /// @param places  [dots]
    /// @param errors  out [dots] as ErrorGrid::at() has them
    /// O(dots).
    void measure(std::span<const Point> places, std::span<double> errors);

private:
    struct Octave {
        ErrorGrid grid;
        Box box;                            ///< that the grid is stretched over, in the unit frame
        std::vector<std::uint32_t> own;     ///< dots of its features
        std::vector<std::uint32_t> others;  ///< dots of those beside it
    };

    std::vector<Octave> octaves_;
    std::vector<Point> places_;
};

}  // namespace ccdt
