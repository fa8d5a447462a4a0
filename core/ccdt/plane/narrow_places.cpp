// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/narrow_places.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/ccdt/plane/domain_mesh.h"
#include "core/ccdt/plane/narrow_rows.h"
#include "core/ccdt/polish/cell_list.h"

namespace ccdt {

namespace {

/// Returns the triangles of a border's mesh at which the domain is narrower than the spacing.
/// @param site  capacity of a site
std::vector<NarrowPiece<Point>> find_pieces(const Triangulation& mesh, const CapacityIntegral& capacity, double site) {
    const auto sites_in = [&](std::uint32_t t) {
        if (!mesh.triangles()[t].is_inside()) return 0.0;
        if (capacity.is_uniform()) return mesh.doubled_area(t) / 2 / site;
        const auto [a, b, c] = mesh.positions(t);
        return (capacity.along(a, b) + capacity.along(b, c) + capacity.along(c, a)) / site;
    };
    return find_narrow_pieces(mesh, sites_in, [&](std::uint32_t edge) {
        return mesh.triangles()[Triangulation::triangle_of(edge)].is_constrained(edge % 4);
    });
}

}  // namespace

std::vector<std::uint8_t> even_out_narrow_places(const Domain& domain, const CapacityIntegral& capacity,
                                                 std::span<Point> sites, double site, const std::stop_token& stop) {
    constexpr std::size_t kFine = 16;  // number of sites per site for which vertices on the border are close enough
    const auto mesh = empty_mesh(domain, make_border(domain, capacity, kFine * sites.size()), 1, stop);
    if (!mesh || stop.stop_requested()) return {};
    const auto pieces = find_pieces(mesh->mesh, capacity, site);
    const CellList cells(domain, sites);
    const auto sites_of = [&](std::span<const std::uint32_t> walk) {
        std::vector<std::uint32_t> found;
        for (const std::uint32_t number : walk) {
            const auto& piece = pieces[number];
            double reach = 0;
            for (const Point corner : piece.corners)
                reach = std::max(reach, dot(corner - piece.centre, corner - piece.centre));
            cells.for_near(piece.centre, std::sqrt(reach), [&](Point p, std::uint32_t i) {
                if (piece.contains(p)) found.push_back(i);
            });
        }
        std::ranges::sort(found);
        found.erase(std::unique(found.begin(), found.end()), found.end());
        return found;
    };
    const auto rows = narrow_rows(pieces, sites_of, stop);
    if (stop.stop_requested() || rows.empty()) return {};
    return move_rows<Point>(
        rows, sites, [&](std::span<const Point> positions) { return CellList(domain, positions); },
        [](std::uint32_t, std::uint32_t) { return false; });
}

}  // namespace ccdt
