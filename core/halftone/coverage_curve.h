// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace ccdt {

/// What discs of one size cover of an area by how many they are, overlaps counted once, and how many cover what: for
/// dots as distribute() spreads them, polished.
///
/// A place is covered if its nearest dot is no further away than the radius. So the curve is that of the distance from
/// anywhere to the nearest dot, and holds in the mean for the pixels of a binary raster, too, which are covered if
/// their centres are.
class CoverageCurve {
public:
    /// What is next to solid has some white specks; none would take half as many dots again, for a thousandth of the
    /// light.
    static constexpr double kLeastGain = 0.003;

    CoverageCurve();

    /// Dots per area of a disc that cover a share, in [0, 1]: at most as many as it is worth. Each next one covers less
    /// of what is bare; once that is below kLeastGain of its own size, an area counts as solid.
    double dots(double share) const;

    /// The share that counts as solid.
    double solid() const { return solid_; }

private:
    std::vector<double> dots_;  ///< by shares at equal steps from 0 to 1
    double solid_ = 0;
};

}  // namespace ccdt
