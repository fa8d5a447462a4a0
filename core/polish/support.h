#pragma once

#include <optional>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Finds the nearest place with density: keeps sites out of parts without any.
class Support {
public:
    /// @param density  not uniform, or nearest() must not be called; must outlive this
    Support(const Domain& domain, const Density& density);

    /// The point itself where there is density, else the nearest point with some, looked for so far; if there is none,
    /// the point itself. O(cells so far).
    Point nearest(Point p, double reach) const;

private:
    std::optional<Point> nearest_within(Point g, int column, int row, int around) const;

    const Density& density_;
    Point to_grid_;
};

}  // namespace ccdt
