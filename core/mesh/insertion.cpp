// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/insertion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/geometry/predicates.h"
#include "core/mesh/flips.h"
#include "core/mesh/regions.h"

namespace ccdt {

namespace {

using Mesh = Triangulation;
constexpr std::uint32_t kNone = Mesh::kNone;

/// The arguments of insert_sites().
struct Batch {
    std::span<const std::uint32_t> sites;
    const Draw& draw;
    int attempts;
    double margin;
    const std::stop_token& stop;
};

/// The current triangle of a walk to a point, and the point. On a torus, the point is the periodic copy in the
/// coordinates of Triangulation::positions().
struct Location {
    std::uint32_t triangle;
    Point point;
    Shift shift;  ///< shift of the point from its given position
};

/// Result of an attempt to insert a site. Refused: insert_site() rejects the position. Elsewhere: the position, or a
/// triangle that would change, lies outside the region.
enum class Outcome { Done, Refused, Elsewhere };

/// Walks towards a position. Each step crosses an edge that has the position on its right. The edge tried first varies
/// from step to step, so that the walk cannot cycle where the triangulation is not Delaunay.
/// @param at  start of the walk on entry, its end on return
/// @returns   false if the walk left the region
bool locate(const Triangulation& mesh, const Region& region, Location& at) {
    const Point p = at.point - mesh.distance(at.shift);
    std::uint32_t entered = kNone;
    for (std::uint32_t step = 0;; ++step) {
        std::uint32_t h = Mesh::edge(at.triangle, (step * 0x9e3779b9u >> 16) % 3);
        const auto positions = mesh.positions(at.triangle);
        std::uint32_t crossed = kNone;
        for (int i = 0; i < 3 && crossed == kNone; ++i, h = Mesh::next(h)) {
            if (h == entered || mesh.twin(h) == kNone) continue;
            if (orientation(positions[h % 4], positions[Mesh::next(h) % 4], at.point) < 0) crossed = h;
        }
        if (crossed == kNone) return true;
        entered = mesh.twin(crossed);
        at.triangle = Mesh::triangle_of(entered);
        if (mesh.is_torus()) {
            at.shift = at.shift + mesh.lift(entered) - mesh.lift(Mesh::next(crossed));
            at.point = p + mesh.distance(at.shift);
        }
        if (!region.has(mesh.origin(Mesh::previous(entered)))) return false;
    }
}

/// Returns the start of a walk to a position: a triangle, and the periodic copy of the position nearest to the
/// triangle.
Location way_from(const Triangulation& mesh, std::uint32_t triangle, Point p) {
    if (!mesh.is_torus()) return {triangle, p, {}};
    const auto periods = [](double way, double period) { return static_cast<std::int8_t>(whole(way / period + 0.5)); };
    const Point way = mesh.point(mesh.corners(triangle)[0]) - p;
    const Shift shift{periods(way.x, mesh.period().x), periods(way.y, mesh.period().y)};
    return {triangle, p + mesh.distance(shift), shift};
}

/// Creates the two triangles formed by a single vertex and its periodic copies.
void insert_first(Triangulation& mesh, std::uint32_t site, Point p) {
    mesh.points()[site] = p;
    const std::uint32_t below = 2 * site, above = below + 1;
    mesh.triangles()[below] = mesh.triangles()[above] = {};
    mesh.triangles()[below].corners = mesh.triangles()[above].corners = {site, site, site};
    mesh.triangles()[below].set_shifts({1, 0}, {0, 1}, {-1, -1});
    mesh.triangles()[above].set_shifts({1, 1}, {-1, 0}, {0, -1});
    mesh.join(Mesh::edge(below, 0), Mesh::edge(above, 1));
    mesh.join(Mesh::edge(below, 1), Mesh::edge(above, 2));
    mesh.join(Mesh::edge(below, 2), Mesh::edge(above, 0));
}

/// Inserts a site if its position, and all triangles that the insertion changes, lie within a region.
Outcome insert_in(Triangulation& mesh, Region& region, std::uint32_t site, Point p, double margin,
                  Region::Site& pending) {
    if (mesh.is_torus()) p = snapped(p);
    if (region.last == kNone) {
        insert_first(mesh, site, p);
        region.last = 2 * site;
        return Outcome::Done;
    }
    const std::uint32_t start = pending.triangle == kNone ? region.last : pending.triangle;
    const auto has = [&](std::uint32_t vertex) { return region.has(vertex); };
    if (!std::ranges::all_of(mesh.triangles()[start].corners, has)) return Outcome::Elsewhere;
    Location at = way_from(mesh, start, p);
    if (!locate(mesh, region, at)) {
        pending.triangle = at.triangle;
        return Outcome::Elsewhere;
    }
    const std::uint32_t t = region.last = at.triangle;
    const Triangulation::Triangle split = mesh.triangles()[t];
    if (!split.is_inside()) return Outcome::Refused;
    const auto positions = mesh.positions(t);
    for (std::uint32_t i = 0; i < 3; ++i) {
        if (positions[i] == at.point) return Outcome::Refused;
        if (!split.is_constrained(i)) continue;
        const Point a = positions[i], b = positions[(i + 1) % 3];
        if (orientation(a, b, p) <= 0 || cross(b - a, p - a) < margin * std::sqrt(dot(b - a, b - a)))
            return Outcome::Refused;
    }

    mesh.points()[site] = p;
    mesh.set_part(site, mesh.part_of(split.corners[0]));
    const std::uint32_t u = 2 * site, v = u + 1;
    mesh.divide(site, t, at.shift, u, v);
    region.stack.insert(region.stack.end(), {Mesh::edge(t, 0), Mesh::edge(u, 0), Mesh::edge(v, 0)});
    legalise(mesh, region);
    return Outcome::Done;
}

/// Inserts the sites of a batch whose positions lie within a region. Leaves the other sites for a larger region.
void insert_batch(Triangulation& mesh, Region& region, const Batch& batch) {
    constexpr std::size_t kStopStride = 4096;
    legalise(mesh, region);
    if (region.last == kNone && !region.is_whole()) return;
    std::vector<Region::Site> remaining;
    for (std::size_t i = 0; i < region.sites.size(); ++i) {
        if (i % kStopStride == 0 && batch.stop.stop_requested()) return;
        Region::Site& pending = region.sites[i];
        const std::uint32_t site = batch.sites[pending.number];
        auto done = Outcome::Refused;
        for (int attempt = 0; attempt < batch.attempts && done == Outcome::Refused; ++attempt)
            done = insert_in(mesh, region, site, batch.draw(site, attempt), batch.margin, pending);
        if (done != Outcome::Done) remaining.push_back(pending);
    }
    region.sites = std::move(remaining);
}

}  // namespace

bool insert_site(Triangulation& mesh, std::uint32_t site, Point p, double margin) {
    constexpr std::size_t kReservedEdges = 32;  // edges on the stack
    Region whole;
    whole.last = mesh.search_start();
    whole.stack.reserve(kReservedEdges);
    Region::Site pending;
    const Outcome outcome = insert_in(mesh, whole, site, p, margin, pending);
    mesh.set_search_start(whole.last);
    return outcome == Outcome::Done;
}

std::vector<std::uint32_t> insert_sites(Triangulation& mesh, std::span<const std::uint32_t> sites, const Draw& draw,
                                        int attempts, double margin, const std::stop_token& stop) {
    constexpr std::size_t kSamplesPerBlock = 64;    // triangles sampled per block, to find one inside each block
    constexpr std::size_t kMinSitesPerBlock = 384;  // with fewer, most triangles of a block touch other blocks
    if (sites.empty()) return {};
    Regions regions(mesh.blocks(),
                    kMinSitesPerBlock * mesh.blocks().sites() / std::max(sites.size(), kMinSitesPerBlock));
    const std::size_t stride =
        std::max<std::size_t>(1, mesh.triangle_count() / (kSamplesPerBlock * mesh.blocks().count(0)));
    for (std::size_t i = 0; i < mesh.triangle_count(); i += stride) {
        const auto t = static_cast<std::uint32_t>(i);
        const auto& c = mesh.triangles()[t].corners;
        if (mesh.triangles()[t].is_inside()) regions.of(mesh.blocks().around({c[0], c[1], c[2]})).last = t;
    }
    regions.whole().last = mesh.search_start();
    for (std::uint32_t i = 0; i < sites.size(); ++i)
        regions.of({0, mesh.blocks().of(sites[i])}).sites.push_back({i, kNone});
    const Batch batch{sites, draw, attempts, margin, stop};
    const Region whole = regions.process(mesh.executor(), [&](Region& region) { insert_batch(mesh, region, batch); });
    mesh.set_search_start(whole.last);
    std::vector<std::uint32_t> remaining;
    for (const Region::Site& pending : whole.sites) remaining.push_back(sites[pending.number]);
    return remaining;
}

std::uint32_t part_at(Triangulation& mesh, Point p) {
    Location at{mesh.search_start(), p, {}};
    locate(mesh, Region(), at);
    mesh.set_search_start(at.triangle);
    return mesh.triangles()[at.triangle].is_inside() ? mesh.part_of(mesh.corners(at.triangle)[0]) : kNone;
}

}  // namespace ccdt
