// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/narrow_strips.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/ccdt/polish/cell_list.h"
#include "core/ccdt/surface/crease_vertices.h"
#include "core/ccdt/surface/face_tree.h"
#include "core/ccdt/surface/surface_triangulation.h"

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = SurfaceTriangulation::kNone;

/// Triangulates a surface between vertices on its borders and creases: the vertices of the surface there, and further
/// vertices, which are close together compared with the spacing.
SurfaceTriangulation mesh_of_borders(const Surface& surface, std::vector<double> spacings, std::size_t sites,
                                     Executor& executor, const std::stop_token& stop) {
    constexpr std::size_t kFine = 3;  // distance of vertices on borders, relative to the spacing
    for (double& spacing : spacings) spacing /= kFine;
    CreaseVertices vertices = choose_crease_vertices(surface, spacings, sites / 2);
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const auto corners = surface.corners(f);
        for (std::uint32_t i = 0; i < 3; ++i) {
            if (surface.is_crease(4 * f + i)) vertices.corner[corners[i]] = vertices.corner[corners[(i + 1) % 3]] = 1;
        }
    }
    return {surface, vertices, executor, stop};
}

std::vector<NarrowPiece<Point3>> find_pieces(const SurfaceTriangulation& mesh, const SurfaceDensity& density,
                                             double capacity) {
    std::vector<std::uint8_t> on_border(mesh.vertex_count(), 0);
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t edge = SurfaceTriangulation::edge(t, i);
            if (mesh.twin(edge) == kNone) on_border[mesh.origin(edge)] = on_border[mesh.target(edge)] = 1;
        }
    }
    const auto sites_in = [&](std::uint32_t t) {
        // Some vertices inside the surface cannot be removed.
        if (!std::ranges::all_of(mesh.corners(t), [&](std::uint32_t v) { return on_border[v] != 0; })) return 0.0;
        const auto [a, b, c] = mesh.positions(t);
        const double held = density.is_uniform() ? 1 : density.at(mesh.surface().nearest(1.0 / 3 * (a + b + c)));
        return held * mesh.doubled_area(t) / 2 / capacity;
    };
    return find_narrow_pieces(mesh, sites_in, [&](std::uint32_t edge) { return mesh.twin(edge) == kNone; });
}

/// Returns the nearest piece to each position [positions]; kNone if no piece is very near.
std::vector<std::uint32_t> nearest_pieces(const std::vector<NarrowPiece<Point3>>& pieces,
                                          std::span<const Point3> positions) {
    constexpr double kNear = 0.1;  // in spacings
    const CellList3 cells(positions);
    std::vector<std::uint32_t> found(positions.size(), kNone);
    std::vector<double> least(positions.size(), std::numeric_limits<double>::infinity());
    for (std::uint32_t i = 0; i < pieces.size(); ++i) {
        const auto& corners = pieces[i].corners;
        const double near = kNear * std::sqrt(pieces[i].area / pieces[i].sites);
        double reach = 0;
        for (const Point3 corner : corners) reach = std::max(reach, length(corner - pieces[i].centre));
        cells.for_near(pieces[i].centre, reach + near, [&](Point3 position, std::uint32_t number) {
            const auto weights = nearest_weights(position, corners);
            const Point3 nearest = weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
            const double distance = length(nearest - position);
            if (distance >= std::min(near, least[number])) return;
            least[number] = distance;
            found[number] = i;
        });
    }
    return found;
}

}  // namespace

NarrowStrips::NarrowStrips(const Surface& surface, const SurfaceDensity& density, double capacity,
                           std::vector<double> spacings, std::size_t sites, Executor& executor,
                           const std::stop_token& stop)
    : surface_(surface) {
    const auto mesh = mesh_of_borders(surface, std::move(spacings), sites, executor, stop);
    if (!stop.stop_requested()) pieces_ = find_pieces(mesh, density, capacity);
}

std::vector<std::uint8_t> NarrowStrips::even_out(std::span<SurfacePoint> sites, const std::stop_token& stop) const {
    if (pieces_.empty()) return {};
    std::vector<Point3> positions;
    for (const SurfacePoint& site : sites) positions.push_back(surface_.position(site));
    std::vector<std::pair<std::uint32_t, std::uint32_t>> located;  // piece, site
    for (std::uint32_t site = 0; const std::uint32_t piece : nearest_pieces(pieces_, positions)) {
        if (piece != kNone) located.emplace_back(piece, site);
        ++site;
    }
    std::ranges::sort(located);
    const auto component = [&](const SurfacePoint& at) { return surface_.component(at.face); };
    auto rows = narrow_rows(
        pieces_,
        [&](std::span<const std::uint32_t> walk) {
            const std::uint32_t own = component(surface_.nearest(pieces_[walk.front()].centre));
            std::vector<std::uint32_t> found;
            for (const std::uint32_t piece : walk) {
                auto each = std::ranges::lower_bound(located, std::pair(piece, std::uint32_t{0}));
                for (; each != located.end() && each->first == piece; ++each) {
                    if (component(sites[each->second]) == own) found.push_back(each->second);
                }
            }
            std::ranges::sort(found);
            return found;
        },
        stop);
    std::vector<SurfacePoint> moved(sites.begin(), sites.end());
    std::erase_if(rows, [&](const NarrowRow<Point3>& row) {
        for (std::size_t i = 0; i < row.sites.size(); ++i) {
            moved[row.sites[i]] = surface_.nearest(row.positions[i]);
            if (component(moved[row.sites[i]]) != component(sites[row.sites[i]])) return true;
        }
        return false;
    });
    if (rows.empty() || stop.stop_requested()) return {};
    auto is_moved = move_rows<Point3>(
        rows, positions, [](std::span<const Point3> all) { return CellList3(all); },
        [&](std::uint32_t a, std::uint32_t b) { return component(sites[a]) != component(sites[b]); });
    for (std::size_t i = 0; i < is_moved.size(); ++i) {
        if (is_moved[i] != 0) sites[i] = moved[i];
    }
    return is_moved;
}

}  // namespace ccdt
