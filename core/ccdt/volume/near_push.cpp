// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/near_push.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "core/base/random.h"
#include "core/ccdt/polish/cell_list.h"
#include "core/ccdt/polish/push.h"
#include "core/ccdt/volume/box_domain3.h"
#include "core/ccdt/volume/solid_domain.h"

namespace ccdt {

namespace {

constexpr std::size_t kSites = 512;  ///< sites per task
/// Wanted distance of a site from its own mirror image, relative to the distance of neighbours: the distance of layers
/// in the densest packing. If it were the distance of neighbours, sites would crowd in the first layer off the border.
constexpr double kLayers = 0.816496580927726;
constexpr double kMaxPush = 0.5;  ///< longest move, relative to the reach
constexpr double kApart = 1e-9;   ///< distance at which coincident sites push each other, relative to the reach

/// Returns the direction, different for each site, in which a site moves if it coincides with another site.
Point3 own_way(std::size_t site) {
    Random random(0, site);
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    return {x - 0.5, y - 0.5, z - 0.5};
}

}  // namespace

template <class Domain>
double push_apart(const Domain& domain, const VolumeSpacing& spacing, std::span<Point3> sites, std::size_t free,
                  double reach, double share, Executor& executor, const std::stop_token& stop) {
    struct Copy {
        Point3 position;
        std::uint32_t site;
    };
    const double ratio = spacing.is_uniform() ? 1 : VolumeSpacing::kMaxRatio;
    std::vector<double> reaches(sites.size());  // [sites] reach of the pushes of each site
    for_ranges(executor, sites.size(), kSites, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) reaches[i] = reach * spacing.densest(sites[i]);
    });
    std::vector<std::uint32_t> numbers(sites.size());  // [positions] site of each position
    std::iota(numbers.begin(), numbers.end(), 0U);
    const auto list_positions = [&] {
        std::vector<std::vector<Copy>> copies(sites.size() / kSites + 1);
        for_ranges(executor, sites.size(), kSites, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end && !stop.stop_requested(); ++i) {
                domain.for_copies(sites[i], ratio * reaches[i], [&](Point3 copy, bool is_original) {
                    if (!is_original) copies[begin / kSites].push_back({copy, static_cast<std::uint32_t>(i)});
                });
            }
        });
        std::vector<Point3> positions(sites.begin(), sites.end());
        for (const auto& list : copies) {
            for (const auto& [position, site] : list) {
                positions.push_back(position);
                numbers.push_back(site);
            }
        }
        return CellList3(positions);
    };
    const CellList3 cells = list_positions();
    std::vector<Point3> moved(free);
    std::vector<double> least(free / kSites + 1, 1);
    for_ranges(executor, free, kSites, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end && !stop.stop_requested(); ++i) {
            const Point3 p = sites[i];
            const double own = reaches[i], range = ratio * own;
            const auto push_of = [&](std::uint32_t number, double distance) {
                if (number == i) return PairPush{0, 0};
                const std::uint32_t other = numbers[number];
                double wanted = (own + reaches[other]) / 2;
                if (other == i) wanted *= kLayers;
                least[begin / kSites] = std::min(least[begin / kSites], distance / wanted);
                // A fixed site does not yield, so the other site moves twice as far.
                return PairPush{wanted, other < free ? share : 2 * share};
            };
            const Point3 move = pushed_off(cells, p, range, {}, push_of, [&] { return kApart * own * own_way(i); });
            moved[i] = domain.moved(p, p + capped(move, kMaxPush * own));
        }
    });
    if (!stop.stop_requested()) std::ranges::copy(moved, sites.begin());
    return reach * std::ranges::min(least);
}

template double push_apart(const BoxDomain3&, const VolumeSpacing&, std::span<Point3>, std::size_t, double, double,
                           Executor&, const std::stop_token&);
template double push_apart(const SolidDomain&, const VolumeSpacing&, std::span<Point3>, std::size_t, double, double,
                           Executor&, const std::stop_token&);

}  // namespace ccdt
