// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/globe_dots.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "core/ccdt/globe/chart.h"
#include "core/ccdt/globe/clearance.h"
#include "core/ccdt/globe/inverse_projection.h"
#include "core/ccdt/globe/plane_density.h"
#include "core/ccdt/globe/region.h"
#include "core/ccdt/globe/turns.h"
#include "core/ccdt/maps/confine.h"

namespace ccdt {

namespace {

std::size_t all_dots(std::span<const MapFeature> features) {
    std::size_t sum = 0;
    for (const MapFeature& feature : features) sum += dots_of(feature);
    return sum;
}

/// Features in the plane of their common chart, and the same features in degrees, as returned by in_one_turn().
struct Charted {
    std::vector<MapFeature> plane;
    std::vector<Domain> degrees;
};

Result<Charted> project_features(const Chart& chart, std::span<const MapFeature> features,
                                 const std::stop_token& stop) {
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
    std::optional<InverseProjection> back;
    for (std::size_t i = 0; i < all.feature_of.size(); ++i) {
        const std::uint32_t feature = all.feature_of[i];
        if (i == 0 || all.feature_of[i - 1] != feature) back.emplace(degrees[feature]);
        Point& p = all.dots.points[i];
        p = (*back)(chart, p);
    }
}

}  // namespace

Result<GlobeDots> distribute_dots_on_globe(std::span<const MapFeature> features, const Domain& region,
                                           const Density& density, const Options& options, double buffer,
                                           const Control& control) {
    std::size_t dots = all_dots(features);
    const auto turned = in_one_turn(region, control.stop);
    if (!turned) return tl::unexpected(turned.error());
    auto parts = chart_region(*turned, dots, buffer, control.stop);
    if (!parts) return tl::unexpected(parts.error());
    if (parts->size() > 1) {
        return failure(ErrorCode::Unusable,
                       "the features cover the globe: on a map of dots some cap of 5 degrees must be free");
    }
    ChartedPart& part = parts->front();
    auto charted = project_features(part.chart, features, control.stop);
    if (!charted) return tl::unexpected(charted.error());
    std::vector<std::uint32_t> lost;
    if (buffer > 0) {
        if (auto kept = keep_off_border(part, buffer, control.stop); !kept) return tl::unexpected(kept.error());
        auto confined = confine(charted->plane, part.domain, control.stop);
        if (!confined) return tl::unexpected(confined.error());
        lost = *std::move(confined);
        dots = all_dots(charted->plane);
        if (dots == 0)
            return failure(ErrorCode::Unusable, "the buffer leaves nothing of any feature that has points", "buffer");
    }
    const auto wanted = plane_density(part, *turned, density, dots, control.stop);
    if (!wanted) return tl::unexpected(wanted.error());
    const auto bare =
        density.is_uniform() ? wanted : plane_density(part, *turned, Density::uniform(), dots, control.stop);
    if (!bare) return tl::unexpected(bare.error());
    Options own = options;
    for (Point& p : own.fixed) p = part.chart.to_plane(direction_of(p));
    auto classes = distribute_dots(charted->plane, part.domain.bounds(), wanted->density, own, control);
    if (!classes) return tl::unexpected(classes.error());
    for (ClassDots& each : *classes) to_degrees(part.chart, charted->degrees, each);
    return GlobeDots{*std::move(classes), std::sqrt(bare->total / static_cast<double>(dots)), std::move(lost)};
}

}  // namespace ccdt
