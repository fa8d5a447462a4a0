#include "core/dotmap/globe_dots.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "core/globe/chart.h"
#include "core/globe/plane_density.h"
#include "core/globe/region.h"
#include "core/globe/turns.h"
#include "core/globe/way_back.h"

namespace ccdt {

namespace {

std::size_t dots_of(const MapFeature& feature) {
    std::size_t sum = 0;
    for (const std::size_t dots : feature.dots) sum += dots;
    return sum;
}

/// Features on the chart of all, and in one turn of the globe.
struct Charted {
    std::vector<MapFeature> plane;
    std::vector<Domain> degrees;
};

Result<Charted> lay_all(const Chart& chart, std::span<const MapFeature> features, const std::stop_token& stop) {
    Charted charted;
    double pitch = kTurn;
    for (std::size_t i = 0; i < features.size(); ++i) {
        auto turned = in_one_turn(features[i].area, stop);
        if (!turned) return tl::unexpected(turned.error());
        const std::size_t dots = dots_of(features[i]);
        if (dots > 0) pitch = std::min(pitch, ground_pitch(*turned, dots));
        charted.degrees.push_back(*std::move(turned));
    }
    for (std::size_t i = 0; i < features.size(); ++i) {
        auto laid = lay_on_chart(chart, charted.degrees[i], pitch, stop);
        if (!laid) {
            return failure(laid.error().code, laid.error().message, "features/" + std::to_string(i));
        }
        charted.plane.push_back({*std::move(laid), features[i].dots});
    }
    return charted;
}

void to_degrees(const Chart& chart, std::span<const Domain> degrees, ClassDots& all) {
    std::optional<WayBack> back;
    for (std::size_t i = 0; i < all.feature_of.size(); ++i) {
        const std::uint32_t feature = all.feature_of[i];
        if (i == 0 || all.feature_of[i - 1] != feature) back.emplace(degrees[feature]);
        Point& p = all.dots.points[i];
        p = (*back)(chart, p);
    }
}

}  // namespace

Result<GlobeDots> distribute_dots_on_globe(std::span<const MapFeature> features, const Domain& region,
                                           const Density& density, const Options& options, const Control& control) {
    std::size_t dots = 0;
    for (const MapFeature& feature : features) dots += dots_of(feature);
    const auto turned = in_one_turn(region, control.stop);
    if (!turned) return tl::unexpected(turned.error());
    const auto parts = chart_region(*turned, dots, 0, control.stop);
    if (!parts) return tl::unexpected(parts.error());
    if (parts->size() > 1) {
        return failure(ErrorCode::Unusable,
                       "the features cover the globe: on a map of dots some cap of 5 degrees must be free");
    }
    const ChartedPart& part = parts->front();
    auto charted = lay_all(part.chart, features, control.stop);
    if (!charted) return tl::unexpected(charted.error());
    const auto wanted = plane_density(part, *turned, density, dots, control.stop);
    if (!wanted) return tl::unexpected(wanted.error());
    const auto bare =
        density.is_uniform() ? wanted : plane_density(part, *turned, Density::uniform(), dots, control.stop);
    if (!bare) return tl::unexpected(bare.error());
    auto classes = distribute_dots(charted->plane, part.domain.bounds(), wanted->density, options, control);
    if (!classes) return tl::unexpected(classes.error());
    for (ClassDots& each : *classes) to_degrees(part.chart, charted->degrees, each);
    return GlobeDots{*std::move(classes), std::sqrt(bare->total / static_cast<double>(dots))};
}

}  // namespace ccdt
