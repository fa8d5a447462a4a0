// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/triangle_links.h"

#include <algorithm>
#include <utility>

namespace ccdt {

bool TriangleLinks::are_joined(std::uint32_t a, std::uint32_t b) const {
    // Both vertices are turned around at once, because one of them may have very many neighbours.
    const std::array vertices{a, b};
    std::array edges{edge_of(a), edge_of(b)};
    if (edges[0] == kNone || edges[1] == kNone) return false;
    while (true) {
        for (std::size_t i = 0; i < 2; ++i) {
            const std::uint32_t other = vertices[1 - i];
            if (target(edges[i]) == other || apex(edges[i]) == other) return true;
            edges[i] = twin(previous(edges[i]));
            if (edges[i] == kNone || edges[i] == edge_of(vertices[i])) return false;
        }
    }
}

std::uint32_t TriangleLinks::add(const std::array<std::uint32_t, 3>& corners) {
    std::uint32_t triangle = static_cast<std::uint32_t>(triangles_.size());
    if (removed_.empty()) {
        triangles_.emplace_back();
    } else {
        triangle = removed_.back();
        removed_.pop_back();
    }
    triangles_[triangle] = {};
    triangles_[triangle].corners = corners;
    return triangle;
}

void TriangleLinks::divide(std::uint32_t vertex, std::uint32_t triangle) {
    const std::uint32_t u = add({vertex, vertex, vertex}), v = add({vertex, vertex, vertex});
    HalfEdges::divide(vertex, triangle, u, v);
    for (const std::uint32_t each : {triangle, u, v}) {
        for (std::uint32_t i = 0; i < 3; ++i) keep_edge(edge(each, i));
    }
}

std::uint32_t TriangleLinks::split(std::uint32_t vertex, std::uint32_t h) {
    // (a, b, c) becomes (a, v, c) and (v, b, c); beyond the edge, (b, a, d) becomes (b, v, d) and (v, a, d).
    const auto halve = [&](std::uint32_t e) {
        const std::uint32_t b = target(e), c = apex(e), after = next(e), t = triangle_of(e);
        const std::uint32_t u = add({vertex, b, c});
        triangles_[t].corners[after % 4] = vertex;
        set_constrained(edge(u, 0), is_constrained(e));
        set_constrained(edge(u, 1), is_constrained(after));
        set_constrained(after, false);
        join(edge(u, 1), twin(after));
        join(edge(u, 2), after);
        return edge(u, 0);
    };
    const std::uint32_t other = twin(h);
    const std::uint32_t second = halve(h);
    const std::uint32_t beyond = other == kNone ? kNone : halve(other);
    if (other != kNone) {
        join(h, beyond);
        join(second, other);
    }
    for (const std::uint32_t e : {h, second, other, beyond}) {
        if (e == kNone) continue;
        for (const std::uint32_t each : {e, next(e), previous(e)}) keep_edge(each);
    }
    return next(second);
}

void TriangleLinks::collapse(std::uint32_t h) {
    const std::uint32_t a = origin(h), b = target(h), other = twin(h);
    std::vector<std::uint32_t> leaving;
    for_edges(a, [&](std::uint32_t e) { leaving.push_back(e); });
    edge_of_[a] = kNone;
    for (const std::uint32_t e : leaving) triangles_[triangle_of(e)].corners[e % 4] = b;
    const auto remove = [&](std::uint32_t e) {
        // Of the two sides that become one, a constrained one stays constrained.
        const std::uint32_t first = twin(next(e)), second = twin(previous(e));
        const bool constrained = is_constrained(next(e)) || is_constrained(previous(e));
        for (const auto& [from, to] : {std::pair{first, second}, std::pair{second, first}}) {
            if (from == kNone) continue;
            join(from, to);
            set_constrained(from, constrained);
        }
        triangles_[triangle_of(e)].corners = {kNone, kNone, kNone};
        removed_.push_back(triangle_of(e));
        return std::array{first, second};
    };
    const std::array near = remove(h), far = other == kNone ? std::array{kNone, kNone} : remove(other);
    for (const std::uint32_t e : {near[0], near[1], far[0], far[1]}) {
        if (e == kNone) continue;
        for (const std::uint32_t each : {e, next(e), previous(e)}) keep_edge(each);
    }
    for (const std::uint32_t e : leaving) {
        if (!is_removed(triangle_of(e))) keep_edge(e);
    }
}

void TriangleLinks::renumber(const std::vector<std::uint32_t>& number_of, std::size_t count) {
    std::vector<std::uint32_t> order;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
        if (!is_removed(t)) order.push_back(t);
    }
    for (Triangle& triangle : triangles_) {
        for (std::uint32_t& corner : triangle.corners) corner = corner == kNone ? kNone : number_of[corner];
    }
    const auto least = [&](std::uint32_t t) { return *std::ranges::min_element(triangles_[t].corners); };
    std::ranges::stable_sort(order, {}, least);
    std::vector<std::uint32_t> position(triangles_.size(), kNone);
    for (std::uint32_t i = 0; i < order.size(); ++i) position[order[i]] = i;
    std::vector<Triangle> sorted(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        sorted[i] = triangles_[order[i]];
        for (std::uint32_t& twin : sorted[i].twins) {
            if (twin != kNone) twin = edge(position[twin / 4], twin % 4);
        }
    }
    triangles_ = std::move(sorted);
    removed_.clear();
    edge_of_.assign(count, kNone);
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) keep_edge(edge(t, i));
    }
}

}  // namespace ccdt
