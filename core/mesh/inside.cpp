// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/inside.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <span>
#include <utility>

namespace ccdt {

namespace {

using Mesh = Triangulation;
constexpr std::uint32_t kNone = Mesh::kNone;
using Triangle = Mesh::Triangle;

/// Marks triangles outside the domain, by a flood fill. The fill starts at a side of the box, which is outside, and
/// changes between outside and inside at each segment.
void mark_outside(Triangulation& mesh) {
    std::vector<bool> seen(mesh.triangle_count(), false);
    std::vector<std::uint32_t> stack;
    const auto at_box = [](const Triangle& t) {
        return std::find(t.twins.begin(), t.twins.end(), kNone) != t.twins.end();
    };
    const auto border = mesh.triangles().begin() + mesh.border_triangle();
    stack.push_back(
        static_cast<std::uint32_t>(std::find_if(border, mesh.triangles().end(), at_box) - mesh.triangles().begin()));
    seen[stack.front()] = true;
    mesh.triangles()[stack.front()].flags |= Triangle::kOutside;
    while (!stack.empty()) {
        const Triangle& triangle = mesh.triangles()[stack.back()];
        stack.pop_back();
        for (std::uint32_t i = 0; i < 3; ++i) {
            if (triangle.twins[i] == kNone || seen[Mesh::triangle_of(triangle.twins[i])]) continue;
            const std::uint32_t other = Mesh::triangle_of(triangle.twins[i]);
            seen[other] = true;
            if (triangle.is_inside() == triangle.is_constrained(i)) mesh.triangles()[other].flags |= Triangle::kOutside;
            stack.push_back(other);
        }
    }
}

/// Separates fans of inside triangles that meet at a point where several segments begin: gives each fan its own vertex.
/// This vertex is the input point at which the segment with the fan on its left begins.
void separate(Triangulation& mesh, std::span<const ConstrainedDelaunay::Branch> branches) {
    if (branches.empty()) return;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> fans;  // first edge, vertex
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const Triangle& triangle = mesh.triangles()[t];
        for (std::uint32_t i = 0; i < 3; ++i) {
            if (!triangle.is_inside() || !triangle.is_constrained(i)) continue;
            const auto first = static_cast<std::uint32_t>(mesh.site_count());
            const Segment vertices{triangle.corners[i] - first, triangle.corners[(i + 1) % 3] - first};
            const auto at = std::ranges::lower_bound(branches, vertices, {}, &ConstrainedDelaunay::Branch::vertices);
            if (at != branches.end() && at->vertices == vertices)
                fans.emplace_back(Mesh::edge(t, i), first + at->point);
        }
    }
    for (const auto& [begin, vertex] : fans) {
        for (std::uint32_t h = begin;; h = mesh.twin(Mesh::previous(h))) {
            mesh.triangles()[Mesh::triangle_of(h)].corners[h % 4] = vertex;
            if (mesh.is_constrained(Mesh::previous(h))) break;
        }
    }
}

/// Numbers the connected parts of the inside and assigns the numbers to their vertices.
void mark_parts(Triangulation& mesh) {
    std::vector<std::uint32_t> part_of(mesh.vertex_count(), kNone);
    std::uint32_t parts = 0;
    std::vector<bool> seen(mesh.triangle_count(), false);
    std::vector<std::uint32_t> stack;
    for (std::uint32_t first = 0; first < mesh.triangle_count(); ++first) {
        if (seen[first] || !mesh.triangles()[first].is_inside()) continue;
        const std::uint32_t part = parts++;
        stack.push_back(first);
        seen[first] = true;
        while (!stack.empty()) {
            const Triangle& triangle = mesh.triangles()[stack.back()];
            stack.pop_back();
            for (std::uint32_t i = 0; i < 3; ++i) {
                part_of[triangle.corners[i]] = part;
                const std::uint32_t other = Mesh::triangle_of(triangle.twins[i]);
                if (triangle.is_constrained(i) || seen[other]) continue;
                seen[other] = true;
                stack.push_back(other);
            }
        }
    }
    mesh.set_parts(std::move(part_of), parts);
}

/// Drops triangles outside the domain. All triangles of sites lie inside, so only triangles of the border are
/// renumbered.
void drop_outside(Triangulation& mesh) {
    std::uint32_t next = mesh.border_triangle();
    for (std::uint32_t t = next; t < mesh.triangle_count(); ++t) {
        if (!mesh.triangles()[t].is_inside()) continue;
        mesh.triangles()[next] = mesh.triangles()[t];
        for (std::uint32_t i = 0; i < 3; ++i) mesh.join(Mesh::edge(next, i), mesh.triangles()[t].twins[i]);
        ++next;
    }
    mesh.triangles().resize(next);
}

/// Sorts triangles by their smallest vertex number, so that neighbours in the plane are neighbours in memory.
void number_along_sites(Triangulation& mesh) {
    constexpr std::size_t kRange = 8192;
    const std::size_t count = mesh.triangle_count();
    const auto first_of = [&](std::size_t t) { return std::ranges::min(mesh.triangles()[t].corners); };
    // End of each vertex' triangles in the new order.
    std::vector<std::uint32_t> ends(mesh.vertex_count() + 1, 0);
    for_ranges(mesh.executor(), count, kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t)
            std::atomic_ref(ends[first_of(t) + 1]).fetch_add(1, std::memory_order_relaxed);
    });
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    std::vector<std::uint32_t> order(count), number(count);
    for_ranges(mesh.executor(), count, kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t)
            order[std::atomic_ref(ends[first_of(t)]).fetch_add(1, std::memory_order_relaxed)] =
                static_cast<std::uint32_t>(t);
    });
    for_ranges(mesh.executor(), mesh.vertex_count(), kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const std::uint32_t first = v == 0 ? 0 : ends[v - 1];
            // Before this sort, the order of the vertex' triangles depends on the schedule of the tasks.
            std::sort(order.begin() + first, order.begin() + ends[v]);
            for (std::uint32_t i = first; i < ends[v]; ++i) number[order[i]] = i;
        }
    });
    std::vector<Triangle> sorted(count);
    for_ranges(mesh.executor(), count, kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            sorted[i] = mesh.triangles()[order[i]];
            for (std::uint32_t& twin : sorted[i].twins) {
                if (twin != kNone) twin = Mesh::edge(number[Mesh::triangle_of(twin)], twin % 4);
            }
        }
    });
    mesh.triangles() = std::move(sorted);
}

}  // namespace

Triangulation mesh_of_border(std::size_t sites, const ConstrainedDelaunay& border) {
    Triangulation mesh(sites, border);
    mark_outside(mesh);
    separate(mesh, border.branches);
    mark_parts(mesh);
    return mesh;
}

std::vector<std::array<Point, 3>> inside_triangles(const Triangulation& mesh, std::uint32_t part) {
    std::vector<std::array<Point, 3>> inside;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        if (!mesh.triangles()[t].is_inside()) continue;
        if (part == kNone || mesh.part_of(mesh.corners(t)[0]) == part) inside.push_back(mesh.positions(t));
    }
    return inside;
}

void trim(Triangulation& mesh) {
    constexpr std::size_t kRange = 16384;
    for_ranges(mesh.executor(), mesh.triangle_count(), kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            for (std::uint32_t i = 0; i < 3; ++i) {
                if (mesh.triangles()[t].is_constrained(i)) mesh.triangles()[t].twins[i] = kNone;
            }
            mesh.triangles()[t].flags &= static_cast<std::uint8_t>(~Triangle::kConstrained);
        }
    });
    drop_outside(mesh);
    number_along_sites(mesh);
    mesh.finish();
}

}  // namespace ccdt
