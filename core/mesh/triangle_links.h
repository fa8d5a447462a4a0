// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ccdt {

/// The connectivity of a triangulation, without positions. Half-edge h is edge h % 4 (0, 1 or 2) of triangle h / 4. It
/// runs from corner h % 4 to the next corner. The edges of a triangle run counter-clockwise.
class TriangleLinks {
public:
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};

    struct Triangle {
        std::array<std::uint32_t, 3> corners{kNone, kNone, kNone};
        std::array<std::uint32_t, 3> twins{kNone, kNone, kNone};
        std::uint8_t constrained = 0;  ///< bit 1 << i is set if edge i must not be flipped
    };

    static std::uint32_t edge(std::uint32_t triangle, std::uint32_t number) { return 4 * triangle + number; }
    static std::uint32_t triangle_of(std::uint32_t edge) { return edge / 4; }
    static std::uint32_t next(std::uint32_t edge) { return edge % 4 == 2 ? edge - 2 : edge + 1; }
    static std::uint32_t previous(std::uint32_t edge) { return edge % 4 == 0 ? edge + 2 : edge - 1; }

    std::size_t triangle_count() const { return triangles_.size(); }
    std::size_t vertex_count() const { return edge_of_.size(); }

    const std::array<std::uint32_t, 3>& corners(std::uint32_t triangle) const { return triangles_[triangle].corners; }
    /// Whether the triangle was removed.
    bool is_removed(std::uint32_t triangle) const { return triangles_[triangle].corners[0] == kNone; }
    std::uint32_t origin(std::uint32_t edge) const { return triangles_[edge / 4].corners[edge % 4]; }
    std::uint32_t target(std::uint32_t edge) const { return origin(next(edge)); }
    /// The vertex of the edge's triangle that is not on the edge.
    std::uint32_t apex(std::uint32_t edge) const { return origin(previous(edge)); }
    std::uint32_t twin(std::uint32_t edge) const { return triangles_[edge / 4].twins[edge % 4]; }
    bool is_constrained(std::uint32_t edge) const { return (triangles_[edge / 4].constrained >> edge % 4 & 1) != 0; }

    /// A half-edge that leaves the vertex, kNone if the vertex was removed. For a vertex on a border, it is the one
    /// along the border, so that a counter-clockwise turn visits all half-edges.
    std::uint32_t edge_of(std::uint32_t vertex) const { return edge_of_[vertex]; }
    /// Half-edge that leaves the same vertex, counter-clockwise after `edge`; kNone behind the last one on a border.
    std::uint32_t turned(std::uint32_t edge) const { return twin(previous(edge)); }

    /// Calls function(half-edge) for each half-edge that leaves the vertex, counter-clockwise.
    template <class Function>
    void for_edges(std::uint32_t vertex, Function&& function) const {
        const std::uint32_t first = edge_of(vertex);
        std::uint32_t h = first;
        if (first == kNone) return;
        do {
            function(h);
            h = turned(h);
        } while (h != first && h != kNone);
    }

    /// Whether an edge joins two vertices.
    bool are_joined(std::uint32_t a, std::uint32_t b) const;

    /// Adds a triangle without twins, and returns its number.
    std::uint32_t add(const std::array<std::uint32_t, 3>& corners);
    void add_vertices(std::size_t count) { edge_of_.resize(edge_of_.size() + count, kNone); }
    /// Makes two half-edges twins. `twin` may be kNone.
    void join(std::uint32_t edge, std::uint32_t twin);
    void set_constrained(std::uint32_t edge, bool on);
    /// Makes `edge` the stored edge of its origin (see edge_of), unless the stored one is on a border and `edge` is
    /// not.
    void keep_edge(std::uint32_t edge);

    /// Splits a triangle into three at a vertex.
    void divide(std::uint32_t vertex, std::uint32_t triangle);
    /// Splits an edge into two at a vertex, and the triangles on both sides, too.
    void split(std::uint32_t vertex, std::uint32_t edge);
    /// Replaces the edge a-b of triangles (a, b, c) and (b, a, d) by d-c of (a, d, c) and (b, c, d).
    void flip(std::uint32_t edge);
    /// Removes the origin of an edge by merging it with the target. Removes the triangles beside the edge. The two
    /// vertices must have exactly one common neighbour on each side of the edge.
    void collapse(std::uint32_t edge);

    /// Renumbers the triangles, without the removed ones, in the order of their smallest corners.
    /// @param number_of  [vertices] new number of each vertex that is not removed
    /// @param count      number of vertices afterwards
    void renumber(const std::vector<std::uint32_t>& number_of, std::size_t count);

private:
    std::vector<Triangle> triangles_;
    std::vector<std::uint32_t> edge_of_;  ///< [vertices]
};

}  // namespace ccdt
