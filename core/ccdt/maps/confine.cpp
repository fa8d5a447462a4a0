// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/confine.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/geometry/difference.h"

namespace ccdt {

std::size_t dots_of(const MapFeature& feature) {
    return std::accumulate(feature.dots.begin(), feature.dots.end(), std::size_t{0});
}

Result<std::vector<std::uint32_t>> cut_areas(std::span<MapFeature> features, const Cut& cut) {
    std::vector<std::uint32_t> lost;
    for (std::uint32_t i = 0; i < features.size(); ++i) {
        if (dots_of(features[i]) == 0) continue;
        auto remaining = cut(features[i].area);
        if (remaining) {
            features[i].area = *std::move(remaining);
            continue;
        }
        if (remaining.error().code != ErrorCode::Unusable) return tl::unexpected(remaining.error());
        std::ranges::fill(features[i].dots, std::size_t{0});
        lost.push_back(i);
    }
    return lost;
}

Result<std::vector<std::uint32_t>> confine(std::span<MapFeature> features, const Domain& kept,
                                           const std::stop_token& stop) {
    Box box = kept.bounds();
    for (const MapFeature& feature : features) {
        box.include(feature.area.bounds().min);
        box.include(feature.area.bounds().max);
    }
    const Area outside = outside_of(kept, box);
    return cut_areas(features, [&](const Domain& area) { return without(area, {&outside, 1}, stop); });
}

}  // namespace ccdt
