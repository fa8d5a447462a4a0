// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/polish/first_row.h"

#include <algorithm>
#include <cmath>

namespace ccdt {

namespace {

/// Removes the part of a move that would bring a site nearer than `least` to an obstacle.
/// @param away      any vector pointing away from the obstacle
/// @param squared   squared length of `away`
/// @param distance  distance of the site from the obstacle, times the length of `away`
void keep_off(Point away, double squared, double distance, double least, Point& move) {
    // If the site is far enough for any direction of the move, no square root is needed.
    if (distance * distance > 2 * (least * least + dot(move, move)) * squared) return;
    const double scale = 1 / std::sqrt(squared);
    const double before = scale * distance, after = before + scale * dot(move, away), kept = std::min(before, least);
    if (after < kept) move = move + (kept - after) * scale * away;
}

}  // namespace

void FirstRow::find(const Triangulation& mesh) {
    ends_.clear();
    segments_.clear();
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto corners = mesh.corners(t);
        if (std::ranges::all_of(corners, [&](std::uint32_t v) { return mesh.is_site(v); })) continue;
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Triangulation::edge(t, i), a = corners[i], b = corners[(i + 1) % 3];
            if (mesh.is_site(a) != mesh.is_site(b)) {
                if (mesh.twin(h) > h) ends_.push_back({std::min(a, b), std::max(a, b)});
            } else if (mesh.twin(h) == Triangulation::kNone && mesh.is_site(corners[(i + 2) % 3])) {
                segments_.push_back(h);
            }
        }
    }
    sites_.clear();
    for (const auto& [site, vertex] : ends_) sites_.push_back(site);
    std::ranges::sort(sites_);
    sites_.erase(std::unique(sites_.begin(), sites_.end()), sites_.end());
}

void FirstRow::keep_off_edges(const Triangulation& mesh, std::span<const double> spacings, double depth,
                              std::span<Point> moves) const {
    for (const std::uint32_t h : segments_) {
        const std::uint32_t site = mesh.origin(Triangulation::previous(h));
        const Point along = mesh.along(h);
        const double area = cross(along, mesh.point(site) - mesh.point(mesh.origin(h)));
        keep_off({-along.y, along.x}, dot(along, along), area, depth * spacings[site], moves[site]);
    }
}

void FirstRow::keep_off_vertices(const Triangulation& mesh, std::span<const double> spacings, double depth,
                                 std::span<Point> moves) const {
    for (const auto& [site, vertex] : ends_) {
        const Point away = mesh.point(site) - mesh.point(vertex);
        const double squared = dot(away, away);
        keep_off(away, squared, squared, depth * spacings[site], moves[site]);
    }
}

}  // namespace ccdt
