// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ccdt {

/// A triangle of HalfEdges. Edge i runs from corners[i] to corners[(i + 1) % 3].
struct LinkedTriangle {
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};

    std::array<std::uint32_t, 3> corners{};                   ///< counter-clockwise
    std::array<std::uint32_t, 3> twins{kNone, kNone, kNone};  ///< twins of the three half-edges
    std::uint8_t flags = 0;                                   ///< bit 1 << i is set if edge i is constrained

    static constexpr std::uint8_t kConstrained = 7;  ///< these three bits

    bool is_constrained(std::uint32_t number) const { return (flags >> number & 1) != 0; }
    void set_constrained(std::uint32_t number, bool on) {
        flags = static_cast<std::uint8_t>((flags & ~(1u << number)) | (on ? 1u << number : 0u));
    }
};

/// The connectivity of a triangulation, without positions. Half-edge h is edge h % 4 (0, 1 or 2) of triangle h / 4,
/// whose edges run counter-clockwise.
/// @tparam Triangle  LinkedTriangle, or a type derived from it
template <class Triangle>
class HalfEdges {
public:
    static constexpr std::uint32_t kNone = LinkedTriangle::kNone;

    static std::uint32_t edge(std::uint32_t triangle, std::uint32_t number) { return 4 * triangle + number; }
    static std::uint32_t triangle_of(std::uint32_t edge) { return edge / 4; }
    static std::uint32_t number_of(std::uint32_t edge) { return edge % 4; }
    static std::uint32_t next(std::uint32_t edge) { return edge % 4 == 2 ? edge - 2 : edge + 1; }
    static std::uint32_t previous(std::uint32_t edge) { return edge % 4 == 0 ? edge + 2 : edge - 1; }

    std::size_t triangle_count() const { return triangles_.size(); }
    const std::array<std::uint32_t, 3>& corners(std::uint32_t triangle) const { return triangles_[triangle].corners; }

    std::uint32_t origin(std::uint32_t edge) const { return triangles_[edge / 4].corners[edge % 4]; }
    std::uint32_t target(std::uint32_t edge) const { return origin(next(edge)); }
    /// Returns the vertex of the edge's triangle that is not on the edge.
    std::uint32_t apex(std::uint32_t edge) const { return origin(previous(edge)); }
    /// Returns the half-edge on the other side of the edge; kNone on a border.
    std::uint32_t twin(std::uint32_t edge) const { return triangles_[edge / 4].twins[edge % 4]; }
    /// Whether an edge must not be flipped.
    bool is_constrained(std::uint32_t edge) const { return triangles_[edge / 4].is_constrained(edge % 4); }

    /// Returns a half-edge that leaves the vertex; kNone if the vertex has no triangle. For a vertex of the border, it
    /// is the half-edge along the border with the triangles on its left, so a counter-clockwise turn visits all
    /// half-edges.
    std::uint32_t edge_of(std::uint32_t vertex) const { return edge_of_[vertex]; }

    /// Calls function(half-edge) for each half-edge that leaves the vertex, counter-clockwise. A vertex of the border
    /// has one neighbour more than half-edges: the apex of the last one.
    template <class Function>
    void for_edges(std::uint32_t vertex, Function&& function) const {
        const std::uint32_t first = edge_of(vertex);
        if (first == kNone) return;
        std::uint32_t h = first;
        do {
            function(h);
            h = twin(previous(h));
        } while (h != first && h != kNone);
    }

    std::vector<Triangle>& triangles() { return triangles_; }
    const std::vector<Triangle>& triangles() const { return triangles_; }

    /// Makes two half-edges twins. `twin` may be kNone.
    void join(std::uint32_t edge, std::uint32_t twin) {
        triangles_[edge / 4].twins[edge % 4] = twin;
        if (twin != kNone) triangles_[twin / 4].twins[twin % 4] = edge;
    }

    /// Makes `edge` the stored edge of the vertex where it starts (see edge_of), unless the stored edge is on the
    /// border and `edge` is not.
    void keep_edge(std::uint32_t edge) {
        std::uint32_t& kept = edge_of_[origin(edge)];
        if (twin(edge) == kNone || kept == kNone || origin(kept) != origin(edge) || twin(kept) != kNone) kept = edge;
    }

protected:
    ~HalfEdges() = default;
    HalfEdges() = default;
    HalfEdges(const HalfEdges&) = default;
    HalfEdges(HalfEdges&&) noexcept = default;
    HalfEdges& operator=(const HalfEdges&) = default;
    HalfEdges& operator=(HalfEdges&&) noexcept = default;

    void set_constrained(std::uint32_t edge, bool on) { triangles_[edge / 4].set_constrained(edge % 4, on); }

    /// Splits a triangle into three at a vertex.
    /// @param u, v  two unused triangles, which become parts of the divided one
    void divide(std::uint32_t vertex, std::uint32_t triangle, std::uint32_t u, std::uint32_t v) {
        const std::uint32_t t = triangle;  // becomes (c0, c1, vertex)
        const Triangle split = triangles_[t];
        const auto& c = split.corners;
        triangles_[u] = triangles_[v] = {};
        triangles_[u].corners = {c[1], c[2], vertex};
        triangles_[v].corners = {c[2], c[0], vertex};
        triangles_[t].corners[2] = vertex;
        triangles_[u].set_constrained(0, split.is_constrained(1));
        triangles_[v].set_constrained(0, split.is_constrained(2));
        triangles_[t].set_constrained(1, false);
        triangles_[t].set_constrained(2, false);
        join(edge(u, 0), split.twins[1]);
        join(edge(v, 0), split.twins[2]);
        join(edge(t, 1), edge(u, 2));
        join(edge(u, 1), edge(v, 2));
        join(edge(v, 1), edge(t, 2));
    }

    /// Replaces the edge a-b of triangles (a, b, c) and (b, a, d) by d-c of (a, d, c) and (b, c, d).
    void flip(std::uint32_t edge) {
        const std::uint32_t twin = this->twin(edge);
        const std::uint32_t edge_next = next(edge), twin_next = next(twin);
        const std::uint32_t c = apex(edge), d = apex(twin);
        set_constrained(edge, is_constrained(twin_next));
        set_constrained(twin, is_constrained(edge_next));
        set_constrained(edge_next, false);
        set_constrained(twin_next, false);
        if (this->twin(twin_next) == edge_next) {
            join(edge, twin);  // the two triangles share a second edge, around a torus
        } else {
            join(edge, this->twin(twin_next));
            join(twin, this->twin(edge_next));
        }
        join(edge_next, twin_next);
        triangles_[triangle_of(edge)].corners[edge_next % 4] = d;
        triangles_[triangle_of(twin)].corners[twin_next % 4] = c;
        if (edge_of_.empty()) return;
        for (const std::uint32_t triangle : {triangle_of(edge), triangle_of(twin)}) {
            for (std::uint32_t i = 0; i < 3; ++i) keep_edge(HalfEdges::edge(triangle, i));
        }
    }

    std::vector<Triangle> triangles_;
    std::vector<std::uint32_t> edge_of_;  ///< [vertices] a half-edge that leaves the vertex
};

}  // namespace ccdt
