// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Least distance of the first row from the border, in spacings. It is slightly less than half a row of the hexagonal
/// grid, 0.47 spacings.
inline constexpr double kFirstRow = 0.45;

/// The first row: the sites that share an edge with a vertex of the border.
class FirstRow {
public:
    /// Finds the first row. Must be called again after edges change. O(triangles).
    /// @param mesh  trimmed, not of a torus
    void find(const Triangulation& mesh);

    /// Limits the moves of sites that face an edge of the border across a triangle. Removes the part of a move that
    /// would bring the site nearer than `depth` to that edge. A site that is already nearer comes no nearer.
    /// @param spacings  [sites] 1 / sqrt(wanted density of sites)
    /// @param depth     least distance from the border, in spacings
    /// @param moves     in and out [sites]
    void keep_off_edges(const Triangulation& mesh, std::span<const double> spacings, double depth,
                        std::span<Point> moves) const;
    /// Removes the part of a site's move that would bring it nearer than `depth` to a border vertex which an edge joins
    /// to the site. Also limits sites that face no edge of the border, as in narrow tongues and needles.
    void keep_off_vertices(const Triangulation& mesh, std::span<const double> spacings, double depth,
                           std::span<Point> moves) const;

    /// Returns the sites of the first row [n], in ascending order.
    std::span<const std::uint32_t> sites() const { return sites_; }

private:
    struct Neighbours {
        std::uint32_t site, vertex;
    };
    std::vector<std::uint32_t> sites_;
    std::vector<Neighbours> ends_;         ///< edges from sites of the first row to vertices of the border
    std::vector<std::uint32_t> segments_;  ///< half-edges on the border that face a site across their triangle
};

}  // namespace ccdt
