#pragma once

#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/globe/chart.h"
#include "core/globe/inside.h"

namespace ccdt {

/// Takes points of a chart's plane back to a region of the globe, and what the plane's polygon, whose edges are
/// straight, has more than the region, into it.
class WayBack {
public:
    /// @param degrees  the region in longitude and latitude, in one turn
    explicit WayBack(const Domain& degrees);

    /// @returns  longitude, within [-180, 180], and latitude
    Point operator()(const Chart& chart, Point plane) const;

private:
    double west_;
    Inside inside_;
};

}  // namespace ccdt
