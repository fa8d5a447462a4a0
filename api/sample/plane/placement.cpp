// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/placement.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>

#include "api/run/deadline.h"
#include "api/sample/plane/ordering.h"
#include "core/ccdt/globe/globe.h"
#include "core/ccdt/globe/turns.h"
#include "core/ccdt/maps/globe_dots.h"
#include "core/ccdt/maps/locate.h"
#include "core/points/order/reorder.h"

namespace ccdt::api {
namespace {

PlacedPoints single_class(Distribution points, std::optional<double> pitch) {
    PlacedPoints placed{{}, pitch};
    placed.classes.push_back({std::move(points), {}});
    return placed;
}

Result<PlacedPoints> place_in_plane(const SampleRequest& request, const SampleArea& area, const Density& density,
                                    const Control& control) {
    return request.method->run(area.whole, density, request.run, control).map([](Distribution&& points) {
        return single_class(std::move(points), {});
    });
}

Result<PlacedPoints> place_on_globe(const SampleRequest& request, const SampleArea& area, const Density& density,
                                    const Control& control) {
    return distribute_on_globe(area.whole, density, request.run, request.method->run, request.region.buffer, control)
        .map([](GlobeDistribution&& placed) { return single_class(std::move(placed.sites), placed.pitch); });
}

Result<PlacedPoints> place_map_in_plane(const SampleRequest& request, const SampleArea& area, const Density& density,
                                        const Control& control) {
    return distribute_dots(area.features, area.whole.bounds(), density, request.run, control)
        .map([](std::vector<ClassDots>&& classes) {
            return PlacedPoints{std::move(classes), {}};
        });
}

Result<PlacedPoints> place_map_on_globe(const SampleRequest& request, const SampleArea& area, const Density& density,
                                        const Control& control) {
    return distribute_dots_on_globe(area.features, area.whole, density, request.run, request.region.buffer, control)
        .map([](GlobeDots&& placed) {
            return PlacedPoints{std::move(placed.classes), placed.pitch, std::move(placed.lost)};
        });
}

/// Returns the function that places the points of a request.
auto placing_of(const SampleRequest& request) {
    if (request.counts) return request.region.is_on_globe() ? place_map_on_globe : place_map_in_plane;
    return request.region.is_on_globe() ? place_on_globe : place_in_plane;
}

/// Converts an error about an option, or about a feature of the area, to an error about the request.
Error located(const SampleRequest& request, const SampleArea& area, Error error) {
    constexpr std::string_view kFeature = "features/";
    if (error.field.starts_with(kFeature)) {
        const std::size_t feature = std::stoul(error.field.substr(kFeature.size()));
        error.field = request.features->pointer_to(area.numbers[feature]);
    } else if (!error.field.empty()) {
        error.field = request.field_of(error.field);
    }
    return error;
}

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
    // Each single feature may be too thin to have an area although the union of all features has one.
    if (made->areas.empty()) return std::vector<std::uint32_t>(points.size(), 0);
    std::vector<const Domain*> areas;
    for (const Domain& area : made->areas) areas.push_back(&area);
    const double period = request.region.is_on_globe() ? kTurn : 0;
    auto found = locate(areas, points, period, stop);
    if (!found) return found;
    for (std::uint32_t& each : *found) each = made->numbers[each];
    return found;
}

Result<void> check_carried(const SampleRequest& request, const std::vector<std::uint32_t>& feature_of) {
    if (!request.output.format->repeats_properties) return {};
    std::vector<std::size_t> counts(request.features->size(), 0);
    for (const std::uint32_t feature : feature_of) ++counts[feature];
    return check_size(request.features->carried, counts, request.field_of("properties"));
}

/// Sorts points by the features in which they lie. Points of the same feature keep their order. A point that lies in
/// several features belongs to the first of these features.
/// @param dots  without a mesh, without ranks, and not grouped yet
Result<void> group_by_features(const SampleRequest& request, ClassDots& dots, const std::stop_token& stop) {
    const auto found = find_features(request, dots.dots.points, stop);
    if (!found) return tl::unexpected(found.error());
    if (auto checked = check_carried(request, *found); !checked) return checked;
    std::vector<std::uint32_t> order(found->size());
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return (*found)[i]; });
    dots.feature_of.reserve(order.size());
    for (const std::uint32_t i : order) dots.feature_of.push_back((*found)[i]);
    reorder(dots.dots, order);
    return {};
}

}  // namespace

Result<PlacedPoints> place_points(const SampleRequest& request, const SampleArea& area, const Density& density,
                                  const Control& control) {
    if (auto going = check_stop(control.stop); !going) return tl::unexpected(going.error());
    auto placed = placing_of(request)(request, area, density, control);
    if (!placed) return tl::unexpected(located(request, area, placed.error()));
    const auto stop = stop_of_writing(control, request.on_deadline);
    for (ClassDots& each : placed->classes) {
        auto arranged = check_whole(each.dots.stopped, request.on_deadline);
        if (arranged && request.counts) {
            for (std::uint32_t& feature : each.feature_of) feature = area.numbers[feature];
        } else if (arranged && request.features) {
            arranged = group_by_features(request, each, stop);
        }
        if (arranged) arranged = order_points(request, area.whole, each, control);
        if (!arranged) return tl::unexpected(arranged.error());
    }
    return placed;
}

}  // namespace ccdt::api
