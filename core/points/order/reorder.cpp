// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/order/reorder.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace ccdt {

namespace {

/// @param points  the first order.size() points are reordered; further points do not move
template <class AnyPoint>
void permute(std::vector<AnyPoint>& points, std::span<const std::uint32_t> order) {
    const std::vector<AnyPoint> given(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(order.size()));
    std::ranges::transform(order, points.begin(), [&](std::uint32_t i) { return given[i]; });
}

/// Replaces the indices of points by their new positions.
/// @param polygons  lists of indices of vertices, the first order.size() of which are points
template <class Polygons>
void renumber(Polygons& polygons, std::span<const std::uint32_t> order) {
    std::vector<std::uint32_t> positions(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) positions[order[i]] = i;
    for (auto& polygon : polygons) {
        for (std::uint32_t& vertex : polygon) {
            if (vertex < positions.size()) vertex = positions[vertex];
        }
    }
}

}  // namespace

void reorder(Distribution& distribution, std::span<const std::uint32_t> order) {
    permute(distribution.points, order);
    if (!distribution.mesh) return;
    permute(distribution.mesh->vertices, order);
    renumber(distribution.mesh->triangles, order);
    renumber(distribution.mesh->boundary, order);
}

void reorder(SurfaceDistribution& distribution, std::span<const std::uint32_t> order) {
    permute(distribution.points, order);
    if (!distribution.mesh) return;
    permute(distribution.mesh->vertices, order);
    renumber(distribution.mesh->triangles, order);
}

void reorder(VolumeDistribution& distribution, std::span<const std::uint32_t> order) {
    permute(distribution.points, order);
    if (!distribution.mesh) return;
    permute(distribution.mesh->vertices, order);
    renumber(distribution.mesh->tetrahedra, order);
}

}  // namespace ccdt
