// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/ink_push.h"

#include <cmath>
#include <numbers>

#include "core/base/elementary.h"
#include "core/ccdt/polish/cell_list.h"
#include "core/geometry/hexagonal_spacing.h"

namespace ccdt {

namespace {

constexpr double kPi = std::numbers::pi;

/// Returns the direction, different for each site, in which a site moves if it coincides with another site.
Point own_way(std::uint32_t site) {
    constexpr double kGolden = 0.6180339887498949;
    const double angle = 2 * kPi * kGolden * site;
    return {elementary::cos(angle), elementary::sin(angle)};
}

/// Returns the share of the total move of two sites that `site` makes; `other` makes the remaining share.
double share_of(const InkSite& site, const InkSite& other) {
    const double area = site.own_spacing * site.own_spacing;
    return area / (area + other.own_spacing * other.own_spacing);
}

}  // namespace

std::vector<Point> push_inks_apart(const Domain& domain, std::span<const InkSite> sites, double reach, double push,
                                   const std::stop_token& stop) {
    constexpr std::uint32_t kStopStride = 4096;
    std::vector<Point> positions;
    positions.reserve(sites.size());
    for (const InkSite& site : sites)
        positions.push_back(domain.is_torus() ? wrapped(site.position, domain.unit_bounds().max) : site.position);
    const CellList cells(domain, positions);
    std::vector<Point> moves(sites.size());
    for (std::uint32_t a = 0; a < sites.size(); ++a) {
        if (a % kStopStride == 0 && stop.stop_requested()) break;
        const double least = reach * hexagonal_spacing(1) * sites[a].spacing;
        cells.for_near(positions[a], least, [&](Point other, std::uint32_t b) {
            const Point apart = positions[a] - other;
            const double squared = dot(apart, apart);
            if (squared >= least * least || sites[b].ink == sites[a].ink) return;
            const double distance = std::sqrt(squared);
            const Point way = distance > 1e-9 * least ? 1 / distance * apart : own_way(a);
            moves[a] = moves[a] + 2 * share_of(sites[a], sites[b]) * push * (least - distance) * way;
        });
    }
    return moves;
}

}  // namespace ccdt
