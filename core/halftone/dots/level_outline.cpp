// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/dots/level_outline.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/picture/pixel_ranges.h"

namespace ccdt {

namespace {

/// Levels at the nodes of a grid. The inner nodes are the cell centres. Around them is a ring of nodes on
/// the picture's border, with the level of the nearest cell. The outermost ring is outside and has the same positions
/// as the ring on the border, so that every outline is closed.
class Nodes {
public:
    Nodes(std::span<const float> level, const CellGrid& cells) : level_(level), cells_(cells) {}

    int width() const { return cells_.columns + 4; }
    int height() const { return cells_.rows + 4; }

    Point position(int column, int row) const { return {along(column, cells_.columns), along(row, cells_.rows)}; }

    float level(int column, int row) const {
        if (column == 0 || row == 0 || column == width() - 1 || row == height() - 1) return 1;
        const int x = std::clamp(column - 2, 0, cells_.columns - 1);
        const int y = std::clamp(row - 2, 0, cells_.rows - 1);
        return level_[static_cast<std::size_t>(y) * static_cast<std::size_t>(cells_.columns) +
                      static_cast<std::size_t>(x)];
    }

    bool is_inside(int column, int row) const { return level(column, row) <= 0; }

private:
    static double along(int node, int cells) { return std::clamp(node - 1.5, 0.0, static_cast<double>(cells)); }

    std::span<const float> level_;
    CellGrid cells_;
};

/// Removes points that are exactly collinear with their neighbours, such as those along the border.
std::vector<Point> without_straight_points(const std::vector<Point>& ring) {
    std::vector<Point> result;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point before = ring[i] - ring[(i + ring.size() - 1) % ring.size()];
        const Point after = ring[(i + 1) % ring.size()] - ring[i];
        if (before.x * after.y != before.y * after.x) result.push_back(ring[i]);
    }
    return result;
}

/// An edge between adjacent nodes of a grid.
struct Edge {
    int column, row;  ///< its first node
    bool down;        ///< whether it leads to the node below; else to the node on the right
};

/// Follows the boundary through the squares between nodes. Links each crossed edge to the edge that the boundary
/// crosses next, with the inside on the left.
class Tracer {
public:
    Tracer(std::span<const float> level, const CellGrid& cells)
        : nodes_(level, cells),
          next_(2 * static_cast<std::size_t>(nodes_.width()) * static_cast<std::size_t>(nodes_.height()), kNone) {
        for (int row = 0; row + 1 < nodes_.height(); ++row) {
            for (int column = 0; column + 1 < nodes_.width(); ++column) link(column, row);
        }
    }

    std::vector<std::vector<Point>> rings() {
        std::vector<std::vector<Point>> rings;
        for (std::uint32_t start = 0; start < next_.size(); ++start) {
            if (next_[start] == kNone) continue;
            std::vector<Point>& ring = rings.emplace_back();
            for (std::uint32_t edge = start; next_[edge] != kNone;) {
                const Point point = crossing(edge);
                if (ring.empty() || !(ring.back() == point)) ring.push_back(point);
                const std::uint32_t following = next_[edge];
                next_[edge] = kNone;
                edge = following;
            }
            ring = without_straight_points(ring);
            if (ring.size() < 3) rings.pop_back();
        }
        return rings;
    }

private:
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};

    std::uint32_t number(int column, int row, bool down) const {
        return 2 * (static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(nodes_.width()) +
                    static_cast<std::uint32_t>(column)) +
               (down ? 1 : 0);
    }

    Edge edge(std::uint32_t number) const {
        const auto node = static_cast<int>(number / 2);
        return {node % nodes_.width(), node / nodes_.width(), number % 2 == 1};
    }

    Point crossing(std::uint32_t number) const {
        const auto [column, row, down] = edge(number);
        const int other_column = down ? column : column + 1, other_row = down ? row + 1 : row;
        const double a = static_cast<double>(nodes_.level(column, row));
        const double b = static_cast<double>(nodes_.level(other_column, other_row));
        const Point from = nodes_.position(column, row), to = nodes_.position(other_column, other_row);
        return from + a / (a - b) * (to - from);
    }

    /// Links the crossed edges of a square. Corners and edges are numbered clockwise from the upper left corner.
    void link(int column, int row) {
        const std::array<bool, 4> inside = {nodes_.is_inside(column, row), nodes_.is_inside(column + 1, row),
                                            nodes_.is_inside(column + 1, row + 1), nodes_.is_inside(column, row + 1)};
        const std::array<std::uint32_t, 4> edges = {number(column, row, false), number(column + 1, row, true),
                                                    number(column, row + 1, false), number(column, row, true)};
        const bool is_joined =
            inside[0] == inside[2] && inside[1] == inside[3] && inside[0] != inside[1] && mean(column, row) <= 0;
        for (std::size_t k = 0; k < 4; ++k) {
            // The boundary enters the square through an edge that leads, clockwise, from outside to inside.
            if (inside[k] || !inside[(k + 1) % 4]) continue;
            std::size_t leaving = (k + 1) % 4;
            if (is_joined) {
                leaving = (k + 3) % 4;
            } else {
                while (inside[(leaving + 1) % 4]) leaving = (leaving + 1) % 4;
            }
            next_[edges[k]] = edges[leaving];
        }
    }

    float mean(int column, int row) const {
        return (nodes_.level(column, row) + nodes_.level(column + 1, row) + nodes_.level(column, row + 1) +
                nodes_.level(column + 1, row + 1)) /
               4;
    }

    Nodes nodes_;
    std::vector<std::uint32_t> next_;  ///< [edges] edge that the boundary crosses next; kNone if an edge is not crossed
};

/// Returns the share of a square in which the level is at most 0, as outlines divide it.
/// @param levels  at the corners, clockwise
float inside_share(const std::array<float, 4>& levels) {
    const auto inside = static_cast<int>(std::ranges::count_if(levels, [](float level) { return level <= 0; }));
    if (inside == 0 || inside == 4) return static_cast<float>(inside) / 4;
    // Area of the triangle that the boundary cuts off at a corner. The neighbours of the corner lie on the other side.
    const auto triangle = [&](std::size_t corner) {
        const float own = levels[corner], next = levels[(corner + 1) % 4], before = levels[(corner + 3) % 4];
        return own / (own - next) * (own / (own - before)) / 2;
    };
    if (inside == 2 && (levels[0] <= 0) == (levels[2] <= 0)) {
        const std::size_t first = levels[0] <= 0 ? 0 : 1;
        const bool is_joined = levels[0] + levels[1] + levels[2] + levels[3] <= 0;
        if (!is_joined) return triangle(first) + triangle(first + 2);
        return 1 - triangle(first + 1) - triangle((first + 3) % 4);
    }
    if (inside == 2) {
        // The two edges that the boundary crosses are opposite.
        const std::size_t edge = (levels[0] <= 0) == (levels[1] <= 0) ? 1 : 0;
        const auto part = [&](std::size_t from, std::size_t to) {
            const float share = levels[from] / (levels[from] - levels[to]);
            return levels[from] <= 0 ? share : 1 - share;
        };
        return (part(edge, edge + 1) + part((edge + 3) % 4, edge + 2)) / 2;
    }
    const auto odd = static_cast<std::size_t>(
        std::ranges::find_if(levels, [&](float level) { return (level <= 0) == (inside == 1); }) - levels.begin());
    return inside == 1 ? triangle(odd) : 1 - triangle(odd);
}

}  // namespace

std::vector<float> outlined_shares(std::span<const float> level, const CellGrid& cells, Executor& executor) {
    const auto columns = static_cast<std::size_t>(cells.columns), rows = static_cast<std::size_t>(cells.rows);
    std::vector<float> shares(level.size());
    const auto at = [&](std::size_t x, std::size_t y) {
        return level[std::min(y, rows - 1) * columns + std::min(x, columns - 1)];
    };
    // Computes the shares of a row of squares. The first and the last square reach to the border.
    const auto squares = [&](std::size_t y, std::vector<float>& out) {
        const std::size_t upper = y > 0 ? y - 1 : 0;
        for (std::size_t x = 0; x <= columns; ++x) {
            const std::size_t left = x > 0 ? x - 1 : 0;
            out[x] = inside_share({at(left, upper), at(x, upper), at(x, y), at(left, y)});
        }
    };
    for_ranges(executor, rows, rows_of_task(cells.columns), [&](std::size_t begin, std::size_t end) {
        std::vector<float> above(columns + 1), below(columns + 1);
        squares(begin, below);
        for (std::size_t y = begin; y < end; ++y) {
            std::swap(above, below);
            squares(y + 1, below);
            for (std::size_t x = 0; x < columns; ++x)
                shares[y * columns + x] = (above[x] + above[x + 1] + below[x] + below[x + 1]) / 4;
        }
    });
    return shares;
}

std::vector<std::vector<Point>> outline_of(std::span<const float> level, const CellGrid& cells) {
    return Tracer(level, cells).rings();
}

}  // namespace ccdt
