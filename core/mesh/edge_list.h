// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/mesh/triangulation.h"

namespace ccdt {

/// Lists the half-edges of the triangles [begin, end) for which `counts` is true, in ascending order. The loop has no
/// branch, because the results of `counts` are almost random and a branch would be mispredicted.
/// @param edges   out, at least [3 * (end - begin)]
/// @param counts  called with each half-edge and its twin (kNone, the largest number, if none); returns a bool, or 0 or
///                1
/// @returns       number of half-edges listed
template <class Counts>
std::size_t list_edges(const Triangulation& mesh, std::size_t begin, std::size_t end, std::span<std::uint32_t> edges,
                       Counts&& counts) {
    std::size_t listed = 0;
    for (std::size_t t = begin; t < end; ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Triangulation::edge(static_cast<std::uint32_t>(t), i);
            edges[listed] = h;
            listed += counts(h, mesh.twin(h));
        }
    }
    return listed;
}

}  // namespace ccdt
