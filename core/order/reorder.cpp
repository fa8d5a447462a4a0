// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/order/reorder.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/geometry/point.h"

namespace ccdt {

namespace {

/// @param points  the first order.size() points are reordered; further points do not move
void permute(std::vector<Point>& points, std::span<const std::uint32_t> order) {
    const std::vector<Point> given(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(order.size()));
    std::ranges::transform(order, points.begin(), [&](std::uint32_t i) { return given[i]; });
}

}  // namespace

void reorder(Distribution& distribution, std::span<const std::uint32_t> order) {
    permute(distribution.points, order);
    if (!distribution.mesh) return;
    permute(distribution.mesh->vertices, order);
    std::vector<std::uint32_t> places(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) places[order[i]] = i;
    const auto renumber = [&](std::uint32_t& vertex) {
        if (vertex < places.size()) vertex = places[vertex];
    };
    for (auto& triangle : distribution.mesh->triangles) std::ranges::for_each(triangle, renumber);
    for (auto& loop : distribution.mesh->boundary) std::ranges::for_each(loop, renumber);
}

}  // namespace ccdt
