// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/ccdt/globe/chart.h"
#include "core/ccdt/globe/inside.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Maps points of a chart's plane back to a region of the globe. The polygon in the plane has straight edges, so it can
/// extend slightly beyond the region. Points that would lie outside are moved into the region.
class InverseProjection {
public:
    /// @param degrees  the region in longitude and latitude, as returned by in_one_turn()
    explicit InverseProjection(const Domain& degrees);

    /// @returns  longitude, within [-180, 180], and latitude
    Point operator()(const Chart& chart, Point plane) const;

private:
    double west_;
    Inside inside_;
};

}  // namespace ccdt
