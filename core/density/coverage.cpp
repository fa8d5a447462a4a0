#include "core/density/coverage.h"

#include <cstddef>

#include "core/density/grid_walk.h"

namespace ccdt {

std::vector<double> coverage(std::span<const BorderEdge> border, Point sides, int columns, int rows) {
    const auto width = static_cast<std::size_t>(columns);
    std::vector<double> share(width * static_cast<std::size_t>(rows), 0);
    std::vector<double> left_of(share.size(), 0);  // what an edge adds to all cells on its left
    const Point scale{columns / sides.x, rows / sides.y};
    for (const auto& [a, b, weight] : border) {
        walk_cells({a.x * scale.x, a.y * scale.y}, {b.x * scale.x, b.y * scale.y}, columns, rows,
                   [&, w = weight](int column, int row, double x, double dy) {
                       const auto cell = static_cast<std::size_t>(row) * width + static_cast<std::size_t>(column);
                       share[cell] += w * (x - column) * dy;
                       left_of[cell] += w * dy;
                   });
    }
    for (std::size_t row = 0; row < static_cast<std::size_t>(rows); ++row) {
        double from_right = 0;
        for (std::size_t column = width; column-- > 0;) {
            const std::size_t cell = row * width + column;
            share[cell] += from_right;
            from_right += left_of[cell];
        }
    }
    return share;
}

}  // namespace ccdt
