// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/triangulation.h"

#include <atomic>
#include <utility>

namespace ccdt {

void Triangulation::fix_last(std::size_t count) {
    free_ = sites_ - count;
    blocks_ = SiteBlocks(free_);
}

Triangulation::Triangulation(std::size_t sites, const ConstrainedDelaunay& border) : sites_(sites) {
    fix_last(0);
    reserve_triangles(border.triangles.size());
    points_.reserve(sites + border.points.size());
    points_.resize(sites);
    points_.insert(points_.end(), border.points.begin(), border.points.end());
    const std::uint32_t first = search_start_ = border_triangle();
    for (const auto& given : border.triangles) {
        Triangle& triangle = triangles_.emplace_back();
        for (std::uint32_t i = 0; i < 3; ++i) {
            triangle.set_constrained(i, given.constrained[i]);
            triangle.corners[i] = static_cast<std::uint32_t>(sites + given.corners[i]);
            const std::uint32_t neighbour = given.neighbours[i];
            if (neighbour == ConstrainedDelaunay::kNone) continue;
            // The shared edge of the neighbour begins where this edge ends.
            const auto& other = border.triangles[neighbour].corners;
            const std::uint32_t end = given.corners[(i + 1) % 3];
            triangle.twins[i] = edge(first + neighbour, other[0] == end ? 0 : other[1] == end ? 1 : 2);
        }
    }
}

Triangulation::Triangulation(std::size_t sites, Point period)
    : sites_(sites), period_(period), points_(sites), part_of_(sites, 0), part_count_(1) {
    fix_last(0);
    reserve_triangles(0);
}

/// Reserves memory for two triangles per site and for the triangles of the border.
void Triangulation::reserve_triangles(std::size_t border) {
    Triangle unused;
    unused.flags = Triangle::kOutside;
    triangles_.reserve(2 * sites_ + border);
    triangles_.resize(2 * sites_, unused);
}

void Triangulation::divide(std::uint32_t site, std::uint32_t triangle, Shift shift, std::uint32_t u, std::uint32_t v) {
    // If the site lies on an edge, one of the three triangles is flat. Its circumcircle is a half-plane that contains
    // the corner beyond the edge, so the edge is flipped.
    const std::array<Shift, 3> along = triangles_[triangle].shifts;
    const Shift first = shift, second = shift - lift(edge(triangle, 1)), third = shift - lift(edge(triangle, 2));
    HalfEdges::divide(site, triangle, u, v);
    if (!is_torus()) return;
    triangles_[u].set_shifts(along[1], third, Shift{} - second);
    triangles_[v].set_shifts(along[2], first, Shift{} - third);
    triangles_[triangle].set_shifts(along[0], second, Shift{} - first);
}

void Triangulation::flip(std::uint32_t edge) {
    const std::uint32_t twin = this->twin(edge);
    if (!changed_.empty()) {
        for (const std::uint32_t vertex : {origin(edge), origin(twin), apex(edge), apex(twin)}) changed_[vertex] = 1;
    }
    if (crosses_seam(triangle_of(edge)) || crosses_seam(triangle_of(twin))) flip_shifts(edge);
    HalfEdges::flip(edge);
}

void Triangulation::flip_shifts(std::uint32_t edge) {
    const std::uint32_t twin = this->twin(edge);
    const auto shift_of = [&](std::uint32_t h) { return shift(h); };
    const Shift ad = shift_of(next(twin)), bc = shift_of(next(edge));
    const Shift ca = shift_of(previous(edge)), db = shift_of(previous(twin));
    const auto set = [&](std::uint32_t h, Shift first, Shift second, Shift third) {
        std::array<Shift, 3> shifts;
        shifts[h % 4] = first;
        shifts[next(h) % 4] = second;
        shifts[previous(h) % 4] = third;
        triangles_[triangle_of(h)].set_shifts(shifts[0], shifts[1], shifts[2]);
    };
    set(edge, ad, Shift{} - ca - ad, ca);  // (a, d, c)
    set(twin, bc, ca + ad, db);            // (b, c, d)
}

void Triangulation::wrap() {
    constexpr double kMargin = 0.25;  // in periods; keeps sites near the seam from wrapping back and forth
    constexpr std::size_t kRange = 16384;
    const auto periods = [](double position, double period) {
        const double share = position / period;
        return static_cast<std::int8_t>(share < -kMargin || share >= 1 + kMargin ? whole(share) : 0);
    };
    std::vector<Shift> remaining(points_.size());
    std::atomic<bool> any = false;
    for_ranges(*executor_, points_.size(), kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            remaining[v] = {periods(points_[v].x, period_.x), periods(points_[v].y, period_.y)};
            if (remaining[v] == Shift{}) continue;
            points_[v] = points_[v] - distance(remaining[v]);
            any = true;
        }
    });
    if (!any) return;
    for (Triangle& triangle : triangles_) {
        const auto& [a, b, c] = triangle.corners;
        const auto shifts = triangle.shifts;
        triangle.set_shifts(shifts[0] + remaining[b] - remaining[a], shifts[1] + remaining[c] - remaining[b],
                            shifts[2] + remaining[a] - remaining[c]);
        if (triangle.shifts == shifts) continue;
        for (const std::uint32_t corner : triangle.corners) changed_[corner] = 1;
    }
}

void Triangulation::set_parts(std::vector<std::uint32_t> part_of, std::size_t count) {
    part_of_ = std::move(part_of);
    part_count_ = count;
}

void Triangulation::finish() {
    if (!is_torus()) points_.resize(points_.size() - 4);  // the corners of the box
    part_of_.resize(points_.size());
    if (part_count_ == 1) part_of_ = std::vector<std::uint32_t>();
    edge_of_.assign(points_.size(), kNone);
    for (std::uint32_t t = 0; t < triangle_count(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) keep_edge(edge(t, i));
    }
    forget_changes();
}

}  // namespace ccdt
