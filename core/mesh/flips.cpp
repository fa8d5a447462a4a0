// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/flips.h"

#include <algorithm>
#include <vector>

#include "core/base/pair.h"
#include "core/geometry/predicates.h"

namespace ccdt {

namespace {

using Mesh = Triangulation;
constexpr std::uint32_t kNone = Mesh::kNone;

/// An edge that is not Delaunay, and the smallest block that contains the four vertices of its two triangles.
struct Flip {
    std::uint32_t edge;
    SiteBlocks::Block block;
};

/// Whether an edge is not Delaunay.
bool wants_flip(const Triangulation& mesh, std::uint32_t edge) {
    const std::uint32_t twin = mesh.twin(edge);
    const Point beyond = mesh.point(mesh.origin(Mesh::previous(twin)));
    const auto [a, b, c] = mesh.positions(Mesh::triangle_of(edge));
    if (!mesh.crosses_seam(Mesh::triangle_of(edge)) && !mesh.crosses_seam(Mesh::triangle_of(twin)))
        return in_circle(a, b, c, beyond);
    return in_circle(a, b, c, beyond + mesh.distance(mesh.lift(edge) + mesh.shift(Mesh::next(twin))));
}

/// Whether two edges are certainly both Delaunay, by the floating-point filter of in_circle() for both at once.
bool is_certain(const Triangulation& mesh, std::uint32_t edge, std::uint32_t other) {
    if (mesh.twin(edge) == kNone || mesh.twin(other) == kNone) return false;
    if (mesh.is_torus() && (mesh.crosses_seam(Mesh::triangle_of(edge)) || mesh.crosses_seam(Mesh::triangle_of(other)) ||
                            mesh.crosses_seam(Mesh::triangle_of(mesh.twin(edge))) ||
                            mesh.crosses_seam(Mesh::triangle_of(mesh.twin(other))))) {
        return false;
    }
    const auto& p = mesh.triangles()[Mesh::triangle_of(edge)].corners;
    const auto& q = mesh.triangles()[Mesh::triangle_of(other)].corners;
    const Pair p3 = load(mesh.point(mesh.origin(Mesh::previous(mesh.twin(edge))))),
               q3 = load(mesh.point(mesh.origin(Mesh::previous(mesh.twin(other)))));
    const Pair pa = load(mesh.point(p[0])) - p3, pb = load(mesh.point(p[1])) - p3, pc = load(mesh.point(p[2])) - p3;
    const Pair qa = load(mesh.point(q[0])) - q3, qb = load(mesh.point(q[1])) - q3, qc = load(mesh.point(q[2])) - q3;
    const Pair ax = firsts(pa, qa), bx = firsts(pb, qb), cx = firsts(pc, qc);
    const Pair ay = seconds(pa, qa), by = seconds(pb, qb), cy = seconds(pc, qc);
    const Pair bc1 = bx * cy, bc2 = cx * by, ca1 = cx * ay, ca2 = ax * cy, ab1 = ax * by, ab2 = bx * ay;
    const Pair a2 = ax * ax + ay * ay, b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    const Pair det = a2 * (bc1 - bc2) + b2 * (ca1 - ca2) + c2 * (ab1 - ab2);
    const Pair permanent = (magnitude(bc1) + magnitude(bc2)) * a2 + (magnitude(ca1) + magnitude(ca2)) * b2 +
                           (magnitude(ab1) + magnitude(ab2)) * c2;
    const auto certain = det < -kInCircleBound * permanent;
    return (certain[0] & certain[1]) != 0;
}

/// Lists the edges of triangles [begin, end) that need a flip, each by its half-edge with the smaller number.
void find_flips(const Triangulation& mesh, std::size_t begin, std::size_t end, std::vector<Flip>& found) {
    // Branchless, since the outcome is unpredictable.
    std::vector<std::uint32_t> edges(3 * (end - begin) + 1);
    std::size_t count = 0;
    for (std::size_t t = begin; t < end; ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Mesh::edge(static_cast<std::uint32_t>(t), i), twin = mesh.triangles()[t].twins[i];
            edges[count] = h;
            count += static_cast<std::size_t>(twin != kNone) & static_cast<std::size_t>(twin > h);
        }
    }
    if (count % 2 != 0) edges[count] = edges[count - 1];
    for (std::size_t i = 0; i < count; i += 2) {
        if (is_certain(mesh, edges[i], edges[i + 1])) continue;
        for (std::size_t k = i; k < std::min(i + 2, count); ++k) {
            if (!wants_flip(mesh, edges[k])) continue;
            const auto& c = mesh.triangles()[Mesh::triangle_of(edges[k])].corners;
            const std::uint32_t beyond = mesh.origin(Mesh::previous(mesh.twin(edges[k])));
            found.push_back({edges[k], mesh.blocks().around({c[0], c[1], c[2], beyond})});
        }
    }
}

}  // namespace

void legalise(Triangulation& mesh, Region& region) {
    while (!region.stack.empty()) {
        const std::uint32_t h = region.stack.back();
        region.stack.pop_back();
        const std::uint32_t twin = mesh.twin(h);
        if (twin == kNone || mesh.is_constrained(h)) continue;
        if (!region.has(mesh.origin(Mesh::previous(twin)))) {
            region.edges.push_back(h);
            continue;
        }
        if (!wants_flip(mesh, h)) continue;
        mesh.flip(h);
        ++region.flips;
        region.stack.insert(region.stack.end(), {h, Mesh::previous(h), twin, Mesh::previous(twin)});
    }
}

std::size_t restore_delaunay(Triangulation& mesh, const std::stop_token& stop) {
    constexpr std::size_t kRange = 8192;
    mesh.forget_changes();
    if (mesh.is_torus()) mesh.wrap();
    std::vector<std::vector<Flip>> found((mesh.triangle_count() + kRange - 1) / kRange);
    for_ranges(mesh.executor(), mesh.triangle_count(), kRange, [&](std::size_t begin, std::size_t end) {
        if (!stop.stop_requested()) find_flips(mesh, begin, end, found[begin / kRange]);
    });
    if (stop.stop_requested()) return 0;
    Regions regions(mesh.blocks(), 1);
    for (const auto& flips : found) {
        for (const Flip& flip : flips) regions.of(flip.block).stack.push_back(flip.edge);
    }
    return regions.process(mesh.executor(), [&](Region& region) { legalise(mesh, region); }).flips;
}

}  // namespace ccdt
