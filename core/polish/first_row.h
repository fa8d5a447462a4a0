#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Depth of the sites next to the border, in spacings; half a row of the hexagonal grid has 0.47.
inline constexpr double kFirstRow = 0.45;

/// Sites next to the border: those that share a triangle with vertices of it.
class FirstRow {
public:
    /// Lists them; again after all that changes edges. O(triangles).
    /// @param mesh  trimmed, not a torus'
    void find(const Triangulation& mesh);

    /// Takes from the moves of sites what would bring them nearer to the edges of the border that they face than some
    /// depth; those that are nearer do not come nearer still, and slide along it.
    /// @param spacings  [sites] 1 / sqrt(density of the sites that are wanted)
    /// @param depth     in spacings
    /// @param moves     in and out [sites]
    void keep_off_edges(const Triangulation& mesh, std::span<const double> spacings, double depth,
                        std::span<Point> moves) const;
    /// The same for vertices of the border, which hold sites in tongues and needles.
    void keep_off_vertices(const Triangulation& mesh, std::span<const double> spacings, double depth,
                           std::span<Point> moves) const;

    /// [n] in order.
    std::span<const std::uint32_t> sites() const { return sites_; }

private:
    struct Neighbours {
        std::uint32_t site, vertex;
    };
    std::vector<std::uint32_t> sites_;
    std::vector<Neighbours> ends_;         ///< of edges from sites to vertices of the border
    std::vector<std::uint32_t> segments_;  ///< edges of the border that a site faces
};

}  // namespace ccdt
