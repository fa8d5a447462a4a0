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

    /// Finds the nearest point with density, to a factor of sqrt(2) of its distance: p itself where there is some, or
    /// where none is within reach. O(cells within reach).
    Point nearest(Point p, double reach) const;

    /// The same for a place with density; none for others.
    std::optional<Point> here(Point p) const;

private:
    std::optional<Point> nearest_within(Point g, int column, int row, int around) const;

    const Density& density_;
    Point to_grid_;
};

}  // namespace ccdt
