// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/ccdt/surface/surface.h"

namespace ccdt {

/// Vertices that a triangulation of sites needs along the borders and creases of a surface.
struct CreaseVertices {
    /// A position on an edge of the surface.
    struct OnEdge {
        std::uint32_t edge;  ///< the half-edge; if the edge has two, the one with the smaller number
        double share;        ///< position between origin and target, in (0, 1)
    };

    std::vector<OnEdge> added;         ///< sorted by edge, then by share
    std::vector<std::uint8_t> corner;  ///< [vertices] whether a vertex of the surface is needed
};

/// Chooses vertices along borders and creases. Chains of edges between corners are simplified: a vertex of a chain is
/// kept where it is farther than a tenth of the local spacing from the simplified chain. Between the kept vertices,
/// further vertices are added at about the local spacing. If there would be more than four such vertices per
/// site, plus 1,000, all spacings are increased by the same factor.
/// @param spacings  [vertices] wanted distance of neighbouring sites around each vertex of the surface, > 0
/// @param sites     number of sites
/// Typically O(vertices log vertices). A chain of n edges whose distances from the simplified chain shrink along the
/// chain takes O(n^2).
CreaseVertices choose_crease_vertices(const Surface& surface, std::span<const double> spacings, std::size_t sites);

}  // namespace ccdt
