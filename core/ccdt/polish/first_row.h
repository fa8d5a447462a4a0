// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace ccdt {

/// Least distance of the first row from the border, in spacings. It is slightly less than half a row of the hexagonal
/// grid, 0.47 spacings.
inline constexpr double kFirstRow = 0.45;

/// The first row: the sites that share an edge with a vertex of the border. On a surface, creases count as borders. A
/// mesh is a Triangulation, trimmed and not of a torus, or a SurfaceTriangulation.
class FirstRow {
public:
    /// Finds the first row. Must be called again after edges change. O(triangles).
    template <class Mesh>
    void find(const Mesh& mesh);

    /// Limits the moves of sites that face an edge of the border across a triangle. Removes the part of a move that
    /// would bring the site nearer than `depth` to that edge. A site that is already nearer comes no nearer.
    /// @param spacings  [sites] 1 / sqrt(wanted density of sites)
    /// @param depth     least distance from the border, in spacings
    /// @param moves     in and out [sites]
    template <class Mesh, class Moves>
    void keep_off_edges(const Mesh& mesh, std::span<const double> spacings, double depth, Moves&& moves) const;
    /// Removes the part of a site's move that would bring it nearer than `depth` to a border vertex which an edge joins
    /// to the site. Also limits sites that face no edge of the border, as in narrow tongues and needles.
    template <class Mesh, class Moves>
    void keep_off_vertices(const Mesh& mesh, std::span<const double> spacings, double depth, Moves&& moves) const;

    /// Returns the sites of the first row [n], in ascending order.
    std::span<const std::uint32_t> sites() const { return sites_; }

private:
    struct Neighbours {
        std::uint32_t site, vertex;
    };

    /// Removes the part of a move that would bring a site nearer than `least` to an obstacle.
    /// @param away      any vector pointing away from the obstacle
    /// @param squared   squared length of `away`
    /// @param distance  distance of the site from the obstacle, times the length of `away`
    template <class Position>
    static void keep_off(Position away, double squared, double distance, double least, Position& move) {
        if (!(squared > 0)) return;  // too near for a direction
        // If the site is far enough for any direction of the move, no square root is needed.
        if (distance * distance > 2 * (least * least + dot(move, move)) * squared) return;
        const double scale = 1 / std::sqrt(squared);
        const double before = scale * distance, after = before + scale * dot(move, away);
        const double kept = std::min(before, least);
        if (after < kept) move = move + (kept - after) * scale * away;
    }

    std::vector<std::uint32_t> sites_;
    std::vector<Neighbours> ends_;         ///< edges from sites of the first row to vertices of the border
    std::vector<std::uint32_t> segments_;  ///< half-edges on the border that face a site across their triangle
};

template <class Mesh>
void FirstRow::find(const Mesh& mesh) {
    ends_.clear();
    segments_.clear();
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto corners = mesh.corners(t);
        if (std::ranges::all_of(corners, [&](std::uint32_t v) { return mesh.is_site(v); })) continue;
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Mesh::edge(t, i), a = corners[i], b = corners[(i + 1) % 3];
            if (mesh.is_site(a) != mesh.is_site(b)) {
                if (mesh.twin(h) > h) ends_.push_back({std::min(a, b), std::max(a, b)});
            } else if (mesh.twin(h) == Mesh::kNone && mesh.is_site(corners[(i + 2) % 3])) {
                segments_.push_back(h);
            }
        }
    }
    sites_.clear();
    for (const auto& [site, vertex] : ends_) sites_.push_back(site);
    std::ranges::sort(sites_);
    sites_.erase(std::unique(sites_.begin(), sites_.end()), sites_.end());
}

template <class Mesh, class Moves>
void FirstRow::keep_off_edges(const Mesh& mesh, std::span<const double> spacings, double depth, Moves&& moves) const {
    for (const std::uint32_t h : segments_) {
        const std::uint32_t site = mesh.origin(Mesh::previous(h));
        const auto inward = mesh.inward(h);
        const double distance = dot(inward, mesh.point(site) - mesh.point(mesh.origin(h)));
        keep_off(inward, dot(inward, inward), distance, depth * spacings[site], moves[site]);
    }
}

template <class Mesh, class Moves>
void FirstRow::keep_off_vertices(const Mesh& mesh, std::span<const double> spacings, double depth,
                                 Moves&& moves) const {
    for (const auto& [site, vertex] : ends_) {
        const auto away = mesh.point(site) - mesh.point(vertex);
        const double squared = dot(away, away);
        keep_off(away, squared, squared, depth * spacings[site], moves[site]);
    }
}

}  // namespace ccdt
