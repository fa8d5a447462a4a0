// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/feature_points.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <variant>

#include "api/run/deadline.h"
#include "core/dotmap/locate.h"
#include "core/geometry/domain.h"
#include "core/globe/region.h"
#include "core/globe/turns.h"
#include "core/order/reorder.h"

namespace ccdt::api {
namespace {

/// Areas of the features; features without area are omitted.
struct FeatureAreas {
    std::vector<Domain> areas;
    std::vector<std::uint32_t> numbers;  ///< [areas] index of the feature
};

Result<FeatureAreas> make_areas(const SampleRequest& request, const std::stop_token& stop) {
    FeatureAreas made;
    for (std::size_t i = 0; i < request.features->size(); ++i) {
        if (auto going = check_stop(stop); !going) return tl::unexpected(going.error());
        const auto parts = parts_of(request, i);
        if (!parts) return tl::unexpected(parts.error());
        if (parts->empty()) continue;
        auto area = Domain::repair(*parts, stop);
        if (!area && area.error().code != ErrorCode::Unusable) return tl::unexpected(area.error());
        if (!area) continue;
        made.areas.push_back(std::move(area->domain));
        made.numbers.push_back(static_cast<std::uint32_t>(i));
    }
    return made;
}

/// Finds the feature of each point.
Result<std::vector<std::uint32_t>> find_features(const SampleRequest& request, const std::vector<Point>& points,
                                                 const std::stop_token& stop) {
    auto made = make_areas(request, stop);
    if (!made) return tl::unexpected(made.error());
    // Possibly the union of all features has an area although each single feature is too thin to have one.
    if (made->areas.empty()) return std::vector<std::uint32_t>(points.size(), 0);
    std::vector<const Domain*> areas;
    for (const Domain& area : made->areas) areas.push_back(&area);
    const double period = request.coordinates == Coordinates::LonLat ? kTurn : 0;
    auto found = locate(areas, points, period, stop);
    if (!found) return found;
    for (std::uint32_t& each : *found) each = made->numbers[each];
    return found;
}

Result<void> check_carried(const SampleRequest& request, const std::vector<std::uint32_t>& feature_of) {
    if (!request.format->repeats_properties) return {};
    std::vector<std::size_t> counts(request.features->size(), 0);
    for (const std::uint32_t feature : feature_of) ++counts[feature];
    return check_size(request.features->carried, counts, request.field_of("properties"));
}

}  // namespace

Result<std::vector<PolygonPart>> parts_of(const SampleRequest& request, std::size_t feature) {
    const auto& first_part = request.features->first_part;
    const auto begin = std::get<PolygonInput>(request.domain).parts.begin();
    std::vector<PolygonPart> parts(begin + static_cast<std::ptrdiff_t>(first_part[feature]),
                                   begin + static_cast<std::ptrdiff_t>(first_part[feature + 1]));
    return request.coordinates == Coordinates::Plane ? parts : unrolled(std::move(parts));
}

Result<ClassDots> by_features(const SampleRequest& request, Distribution points, const std::stop_token& stop) {
    const auto found = find_features(request, points.points, stop);
    if (!found) return tl::unexpected(found.error());
    if (auto checked = check_carried(request, *found); !checked) return tl::unexpected(checked.error());
    std::vector<std::uint32_t> order(found->size());
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return (*found)[i]; });
    ClassDots dots;
    dots.feature_of.reserve(order.size());
    for (const std::uint32_t i : order) dots.feature_of.push_back((*found)[i]);
    reorder(points, order);
    dots.dots = std::move(points);
    return dots;
}

}  // namespace ccdt::api
