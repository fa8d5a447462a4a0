// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/inside.h"

#include <algorithm>
#include <cmath>

namespace ccdt {

namespace {

Point nearest_on(Point a, Point b, Point p, double stretch) {
    const auto product = [stretch](Point u, Point v) { return stretch * stretch * u.x * v.x + u.y * v.y; };
    const Point along = b - a;
    return a + std::clamp(product(p - a, along) / product(along, along), 0.0, 1.0) * along;
}

}  // namespace

Inside::Inside(const std::vector<Ring>& rings) {
    Box box{rings.front().front(), rings.front().front()};
    for (const Ring& ring : rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            box.include(ring[i]);
            const Point next = ring[(i + 1) % ring.size()];
            if (!(ring[i] == next)) edges_.push_back({ring[i], next});
        }
    }
    west_ = box.min.x;
    extent_ = std::max(box.width(), box.height());
    // The number of columns is the largest for which an edge lies in at most four columns on average.
    constexpr double kEach = 4;
    double widths = 0;
    for (const Edge& edge : edges_) widths += std::abs(edge.b.x - edge.a.x);
    const double spans = std::max(widths / box.width(), kEach);
    const auto columns = static_cast<std::size_t>(1 + kEach * static_cast<double>(edges_.size()) / spans);
    column_width_ = box.width() / static_cast<double>(columns);
    first_.assign(columns + 1, 0);
    const auto for_columns = [&](const Edge& edge, auto visit) {
        const auto [low, high] = std::minmax(edge.a.x, edge.b.x);
        for (std::size_t column = column_of(low); column <= column_of(high); ++column) visit(column);
    };
    for (const Edge& edge : edges_) for_columns(edge, [&](std::size_t column) { ++first_[column + 1]; });
    for (std::size_t column = 0; column < columns; ++column) first_[column + 1] += first_[column];
    members_.resize(first_.back());
    auto next = first_;
    for (std::uint32_t i = 0; i < edges_.size(); ++i)
        for_columns(edges_[i], [&](std::size_t column) { members_[next[column]++] = i; });
}

std::size_t Inside::column_of(double x) const {
    const double column = std::floor((x - west_) / column_width_);
    return static_cast<std::size_t>(std::clamp(column, 0.0, static_cast<double>(first_.size() - 2)));
}

bool Inside::contains(Point p) const {
    const std::size_t column = column_of(p.x);
    bool inside = false;
    for (std::size_t i = first_[column]; i < first_[column + 1]; ++i) {
        const auto& [a, b] = edges_[members_[i]];
        if ((a.x <= p.x) == (b.x <= p.x)) continue;
        const double above = cross(b - a, p - a) * (b.x > a.x ? -1 : 1);
        if (above == 0) return false;
        if (above > 0) inside = !inside;
    }
    return inside;
}

Point Inside::nearest(Point p, double stretch) const {
    constexpr double kMin = 1e-12, kMax = 1e-3;
    if (contains(p)) return p;
    const auto distance = [&](Point q) {
        const Point off{stretch * (q.x - p.x), q.y - p.y};
        return dot(off, off);
    };
    Point foot = edges_.front().a, inward;
    double least = distance(foot) * 4 + 1;
    for (const auto& [a, b] : edges_) {
        const Point there = nearest_on(a, b, p, stretch);
        const double found = distance(there);
        const double length = std::sqrt(dot(b - a, b - a));
        const Point normal{(a.y - b.y) / length, (b.x - a.x) / length};
        // At a corner, both edges are equally near; the normals of both are added.
        if (found == least && there == foot) inward = inward + normal;
        if (found >= least) continue;
        least = found;
        foot = there;
        inward = normal;
    }
    for (double nudge = kMin; nudge <= kMax; nudge *= 4) {
        const Point there = foot + nudge * extent_ * inward;
        if (contains(there)) return there;
    }
    return p;
}

}  // namespace ccdt
