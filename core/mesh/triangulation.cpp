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

void Triangulation::join(std::uint32_t edge, std::uint32_t twin) {
    set_twin(edge, twin);
    if (twin != kNone) set_twin(twin, edge);
}

void Triangulation::divide(std::uint32_t site, std::uint32_t triangle, Shift shift, std::uint32_t u, std::uint32_t v) {
    // Triangle t becomes (c0, c1, p). If p lies on an edge, one of the three triangles is flat. Its circumcircle is a
    // half-plane that contains the corner beyond the edge, so the edge is flipped.
    const std::uint32_t t = triangle;
    const Triangle split = triangles_[t];
    const auto& c = split.corners;
    triangles_[u] = triangles_[v] = {};
    triangles_[u].corners = {c[1], c[2], site};
    triangles_[v].corners = {c[2], c[0], site};
    if (is_torus()) {
        const Shift first = shift, second = shift - lift(edge(t, 1)), third = shift - lift(edge(t, 2));
        triangles_[u].set_shifts(split.shifts[1], third, Shift{} - second);
        triangles_[v].set_shifts(split.shifts[2], first, Shift{} - third);
        triangles_[t].set_shifts(split.shifts[0], second, Shift{} - first);
    }
    triangles_[t].corners[2] = site;
    triangles_[u].set_constrained(0, split.is_constrained(1));
    triangles_[v].set_constrained(0, split.is_constrained(2));
    triangles_[t].set_constrained(1, false);
    triangles_[t].set_constrained(2, false);
    join(edge(u, 0), split.twins[1]);
    join(edge(v, 0), split.twins[2]);
    join(edge(t, 1), edge(u, 2));
    join(edge(u, 1), edge(v, 2));
    join(edge(v, 1), edge(t, 2));
}

void Triangulation::flip(std::uint32_t edge) {
    const std::uint32_t twin = this->twin(edge);
    const std::uint32_t edge_next = next(edge), twin_next = next(twin);
    const std::uint32_t c = origin(previous(edge)), d = origin(previous(twin));
    set_constrained(edge, is_constrained(twin_next));
    set_constrained(twin, is_constrained(edge_next));
    set_constrained(edge_next, false);
    set_constrained(twin_next, false);
    if (!changed_.empty()) {
        for (const std::uint32_t vertex : {origin(edge), origin(twin), c, d}) changed_[vertex] = 1;
    }
    if (crosses_seam(triangle_of(edge)) || crosses_seam(triangle_of(twin))) flip_shifts(edge);
    if (this->twin(twin_next) == edge_next) {
        join(edge, twin);  // the two triangles share a second edge, around the torus
    } else {
        join(edge, this->twin(twin_next));
        join(twin, this->twin(edge_next));
    }
    join(edge_next, twin_next);
    triangles_[triangle_of(edge)].corners[edge_next % 4] = d;
    triangles_[triangle_of(twin)].corners[twin_next % 4] = c;
    if (edge_of_.empty()) return;
    for (const std::uint32_t triangle : {triangle_of(edge), triangle_of(twin)}) {
        for (std::uint32_t i = 0; i < 3; ++i) keep_edge(Triangulation::edge(triangle, i));
    }
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
    const auto periods = [](double place, double period) {
        const double share = place / period;
        return static_cast<std::int8_t>(share < -kMargin || share >= 1 + kMargin ? whole(share) : 0);
    };
    std::vector<Shift> left(points_.size());
    std::atomic<bool> any = false;
    for_ranges(*executor_, points_.size(), kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            left[v] = {periods(points_[v].x, period_.x), periods(points_[v].y, period_.y)};
            if (left[v] == Shift{}) continue;
            points_[v] = points_[v] - distance(left[v]);
            any = true;
        }
    });
    if (!any) return;
    for (Triangle& triangle : triangles_) {
        const auto& [a, b, c] = triangle.corners;
        const auto shifts = triangle.shifts;
        triangle.set_shifts(shifts[0] + left[b] - left[a], shifts[1] + left[c] - left[b],
                            shifts[2] + left[a] - left[c]);
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
    edge_of_.resize(points_.size());
    for (std::uint32_t t = 0; t < triangle_count(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) keep_edge(edge(t, i));
    }
    forget_changes();
}

void Triangulation::keep_edge(std::uint32_t edge) {
    const std::uint32_t vertex = origin(edge);
    if (is_site(vertex) || twin(edge) == kNone) edge_of_[vertex] = edge;
}

}  // namespace ccdt
