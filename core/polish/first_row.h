// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Depth of the first row below the border, in spacings. Half a row of the hexagonal grid is 0.47 spacings.
inline constexpr double kFirstRow = 0.45;

/// The first row: the sites that share an edge with a vertex of the border.
class FirstRow {
public:
    /// Finds the first row. Must be called again after edges change. O(triangles).
    /// @param mesh  trimmed, not of a torus
    void find(const Triangulation& mesh);

    /// Removes the part of each move that would bring a site nearer than `depth` to the border edge opposite to it. A
    /// site that is already nearer may slide along the edge, but comes no nearer.
    /// @param spacings  [sites] 1 / sqrt(wanted density of sites)
    /// @param depth     in spacings
    /// @param moves     in and out [sites]
    void keep_off_edges(const Triangulation& mesh, std::span<const double> spacings, double depth,
                        std::span<Point> moves) const;
    /// Does the same for vertices of the border instead of edges. Vertices hold back sites in narrow tongues and
    /// needles.
    void keep_off_vertices(const Triangulation& mesh, std::span<const double> spacings, double depth,
                           std::span<Point> moves) const;

    /// The sites of the first row [n], in ascending order.
    std::span<const std::uint32_t> sites() const { return sites_; }

private:
    struct Neighbours {
        std::uint32_t site, vertex;
    };
    std::vector<std::uint32_t> sites_;
    std::vector<Neighbours> ends_;         ///< edges from sites of the first row to vertices of the border
    std::vector<std::uint32_t> segments_;  ///< half-edges on the border opposite to a site
};

}  // namespace ccdt
