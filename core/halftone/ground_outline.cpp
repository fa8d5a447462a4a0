// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/ground_outline.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace ccdt {

namespace {

/// Levels of a Ground at the nodes of a grid. The inner nodes are the cell centres. Around them is a ring of nodes on
/// the picture's border, with the level of the nearest cell. The outermost ring is white and has the same positions as
/// the ring on the border, so that every outline is closed.
class Nodes {
public:
    explicit Nodes(const Ground& ground) : ground_(ground) {}

    int width() const { return ground_.cells().columns + 4; }
    int height() const { return ground_.cells().rows + 4; }

    Point place(int column, int row) const {
        return {along(column, ground_.cells().columns), along(row, ground_.cells().rows)};
    }

    float level(int column, int row) const {
        if (column == 0 || row == 0 || column == width() - 1 || row == height() - 1) return 1;
        const int x = std::clamp(column - 2, 0, ground_.cells().columns - 1);
        const int y = std::clamp(row - 2, 0, ground_.cells().rows - 1);
        return ground_.level()[static_cast<std::size_t>(y) * static_cast<std::size_t>(ground_.cells().columns) +
                               static_cast<std::size_t>(x)];
    }

    bool is_black(int column, int row) const { return level(column, row) <= kBoundary; }

private:
    static double along(int node, int cells) { return std::clamp(node - 1.5, 0.0, static_cast<double>(cells)); }

    static constexpr float kBoundary = 0.5f;

    const Ground& ground_;
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
/// crosses next, with black ground on the left.
class Tracer {
public:
    explicit Tracer(const Ground& ground)
        : nodes_(ground),
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
        const double a = static_cast<double>(nodes_.level(column, row)) - 0.5;
        const double b = static_cast<double>(nodes_.level(other_column, other_row)) - 0.5;
        const Point from = nodes_.place(column, row), to = nodes_.place(other_column, other_row);
        return from + a / (a - b) * (to - from);
    }

    /// Links the crossed edges of a square. Corners and edges are numbered clockwise from the upper left corner.
    void link(int column, int row) {
        const std::array<bool, 4> black = {nodes_.is_black(column, row), nodes_.is_black(column + 1, row),
                                           nodes_.is_black(column + 1, row + 1), nodes_.is_black(column, row + 1)};
        const std::array<std::uint32_t, 4> edges = {number(column, row, false), number(column + 1, row, true),
                                                    number(column, row + 1, false), number(column, row, true)};
        const bool is_joined =
            black[0] == black[2] && black[1] == black[3] && black[0] != black[1] && mean(column, row) <= 0.5f;
        for (std::size_t k = 0; k < 4; ++k) {
            // The boundary enters the square through an edge that leads, clockwise, from white to black.
            if (black[k] || !black[(k + 1) % 4]) continue;
            std::size_t leaving = (k + 1) % 4;
            if (is_joined) {
                leaving = (k + 3) % 4;
            } else {
                while (black[(leaving + 1) % 4]) leaving = (leaving + 1) % 4;
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

}  // namespace

std::vector<std::vector<Point>> outline_of(const Ground& ground) {
    return Tracer(ground).rings();
}

}  // namespace ccdt
