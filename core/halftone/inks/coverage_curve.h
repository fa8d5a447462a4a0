// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace ccdt {

/// Shapes that are drawn at sites.
enum class Mark {
    Disc,  ///< discs of equal size
    Line,  ///< a line of constant width along a short path through all sites
};

/// Relation between the number of sites in an area and the share of the area that their marks cover. Overlaps count
/// once. The relation holds for sites that distribute() places and polishes.
///
/// The unit of area is that of a disc, or the square of the width of a line.
///
/// A position is covered if its nearest dot is within the radius. So the curve is the cumulative distribution of the
/// distance from a random position to the nearest dot. A pixel of a binary raster is covered if its centre is, so on
/// average the curve holds for binary rasters as well.
class CoverageCurve {
public:
    /// Least area that one more dot must newly cover, relative to the dot's own area. With this limit, nearly solid
    /// areas keep a few white specks. Covering them would take 50 % more dots and change the light by 0.001.
    static constexpr double kMinGain = 0.003;

    explicit CoverageCurve(Mark mark = Mark::Disc);

    /// Returns the mean number of sites, per unit of area, whose marks cover a given share of the plane, in [0, 1]. For
    /// shares above solid(), returns the number for solid().
    double dots(double share) const;

    /// Returns the share at which one more dot would newly cover only kMinGain of its own area. Areas of this share
    /// count as solid.
    double solid() const { return solid_; }

private:
    std::vector<double> dots_;  ///< number of dots in the area of one disc, for equal steps of the share from 0 to 1
    double solid_ = 0;
};

}  // namespace ccdt
