#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Finds the nearest place with density: keeps sites out of parts without any.
class Support {
public:
    /// @param density  not uniform, or none of the following must be called
    /// O(density's cells).
    Support(const Domain& domain, const Density& density);

    /// Finds the nearest point with density, to a factor of sqrt(2) of its distance: p itself where there is some, or
    /// where none is within reach. O(cells within reach).
    Point nearest(Point p, double reach) const;

    /// The same for a place with density; none for others.
    std::optional<Point> here(Point p) const;

private:
    bool has_density(int column, int row) const {
        return has_density_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                            static_cast<std::size_t>(column)];
    }
    std::optional<Point> nearest_within(Point g, int column, int row, int around) const;

    int columns_;
    int rows_;
    Point to_grid_;
    std::vector<bool> has_density_;  ///< [rows * columns], as they stay in the cache where the density does not
};

}  // namespace ccdt
