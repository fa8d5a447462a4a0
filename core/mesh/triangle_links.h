// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mesh/half_edges.h"

namespace ccdt {

/// The connectivity of a triangulation whose vertices and triangles can be added and removed.
class TriangleLinks : public HalfEdges<LinkedTriangle> {
public:
    using Triangle = LinkedTriangle;
    using HalfEdges::flip;
    using HalfEdges::set_constrained;

    /// Whether the triangle was removed.
    bool is_removed(std::uint32_t triangle) const { return triangles_[triangle].corners[0] == kNone; }

    /// Whether an edge joins two vertices. O(neighbours of the vertex that has fewer).
    bool are_joined(std::uint32_t a, std::uint32_t b) const;

    /// Adds a triangle without twins, and returns its number, which a removed triangle may have had.
    std::uint32_t add(const std::array<std::uint32_t, 3>& corners);
    void add_vertices(std::size_t count) { edge_of_.resize(edge_of_.size() + count, kNone); }
    /// Splits a triangle into three at a vertex.
    void divide(std::uint32_t vertex, std::uint32_t triangle);
    /// Splits an edge into two at a vertex, and each triangle beside the edge into two. The half-edge `edge` becomes
    /// the part before the vertex.
    /// @returns  the new number of next(edge), which now belongs to another triangle
    std::uint32_t split(std::uint32_t vertex, std::uint32_t edge);
    /// Merges the origin of an edge with the target, and removes the triangles beside the edge. The two vertices must
    /// have one common neighbour for each of these triangles, and no other.
    void collapse(std::uint32_t edge);

    /// Renumbers the triangles, without the removed ones, in the order of their smallest corners.
    /// @param number_of  [vertices] new number of each vertex that is not removed
    /// @param count      number of vertices afterwards
    void renumber(const std::vector<std::uint32_t>& number_of, std::size_t count);

private:
    std::vector<std::uint32_t> removed_;  ///< removed triangles, whose numbers are free
};

}  // namespace ccdt
