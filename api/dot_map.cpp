// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/dot_map.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "api/exclusions.h"
#include "api/feature_points.h"
#include "api/input/degrees.h"
#include "api/map_answer.h"
#include "api/ordering.h"
#include "api/output/json_writer.h"
#include "api/output/point_drawing.h"
#include "api/run/deadline.h"
#include "api/run/stopwatch.h"
#include "api/sample_steps.h"
#include "core/dotmap/confine.h"
#include "core/dotmap/dot_map.h"
#include "core/dotmap/globe_dots.h"

namespace ccdt::api {
namespace {

/// Features that have an area. The repairs and warnings are those of all features, also of features without area.
struct Areas {
    std::vector<MapFeature> features;
    std::vector<std::uint32_t> numbers;  ///< [features] index in the request
    std::vector<Repair> repairs;         ///< fields are JSON Pointers in the request
    std::vector<Warning> warnings;
};

/// Formats a number of points, such as "3 points".
std::string points(std::size_t count) {
    return std::to_string(count) + (count == 1 ? " point" : " points");
}

/// Leaves out the points of a feature, and adds a warning if there are any. Errors: `error` if the request rejects
/// invalid polygons.
/// @param error  the reason; its field is a JSON Pointer
Result<void> omit_points(const SampleRequest& request, std::size_t feature, const Error& error,
                         std::vector<Warning>& warnings) {
    const std::size_t count = request.counts->points_of(feature);
    if (count == 0) return {};
    if (request.on_invalid == OnInvalid::Reject) return tl::unexpected(error);
    warnings.push_back({error.field, error.message + ": " + points(count) + " left out"});
    return {};
}

Result<void> check_points(const Areas& areas, const FeatureList& features) {
    if (std::ranges::any_of(areas.features, [](const MapFeature& each) { return dots_of(each) > 0; })) return {};
    return failure(ErrorCode::Unusable, "no feature with points has an area", features.pointer);
}

/// Computes the areas of features, one after the other.
class AreaMaker {
public:
    explicit AreaMaker(const SampleRequest& request)
        : request_(request),
          polygon_(std::get<PolygonInput>(request.domain)),
          counts_(*request.counts),
          features_(*request.features) {}

    Result<Areas> execute(const std::stop_token& stop) {
        warn_of_missing();
        for (std::size_t i = 0; i < counts_.features(); ++i) {
            if (auto going = check_stop(stop); !going) return tl::unexpected(going.error());
            if (auto added = add(i, stop); !added) return tl::unexpected(added.error());
        }
        if (auto any = check_points(areas_, features_); !any) return tl::unexpected(any.error());
        return std::move(areas_);
    }

private:
    void warn_of_missing() {
        for (std::size_t number = 0; number < counts_.classes.size(); ++number) {
            const auto& missing = counts_.missing[number];
            if (missing.features == 0) continue;
            const std::string features = missing.features == 1 ? "a feature lacks this property, or it is null"
                                                               : std::to_string(missing.features) +
                                                                     " features lack this property, or it is null";
            areas_.warnings.push_back({missing.first, features + ": this counts as 0"});
        }
    }

    /// Converts a field of an error or repair of Domain::repair(), in which parts are counted within one feature, to a
    /// JSON Pointer in the request.
    std::string locate(std::size_t feature, const std::string& field) const {
        if (field.empty()) return features_.locate(feature);
        const std::size_t slash = field.find('/', 1);
        const std::size_t part = std::stoul(field.substr(1, slash - 1)) + features_.first_part[feature];
        return polygon_.locate('/' + std::to_string(part) + (slash == std::string::npos ? "" : field.substr(slash)));
    }

    Result<void> add(std::size_t feature, const std::stop_token& stop) {
        const auto parts = parts_of(request_, feature);
        if (!parts) return omit_points(feature, parts.error());
        if (parts->empty()) return omit_points(feature, {ErrorCode::Unusable, "the feature has no geometry", ""});
        auto made = Domain::repair(*parts, stop);
        if (!made) return omit_points(feature, made.error());
        for (Repair& repair : made->repairs) {
            repair.field = locate(feature, repair.field);
            if (request_.on_invalid == OnInvalid::Reject)
                return failure(ErrorCode::Unusable, repair.detail, repair.field);
            areas_.repairs.push_back(std::move(repair));
        }
        MapFeature own{std::move(made->domain), {}};
        for (std::size_t number = 0; number < counts_.classes.size(); ++number)
            own.dots.push_back(counts_.count(feature, number));
        areas_.features.push_back(std::move(own));
        areas_.numbers.push_back(static_cast<std::uint32_t>(feature));
        return {};
    }

    /// Leaves out a feature that has no valid area.
    Result<void> omit_points(std::size_t feature, const Error& error) {
        const Error error_in_request{error.code, error.message, locate(feature, error.field)};
        if (error.code != ErrorCode::Unusable) return tl::unexpected(error_in_request);
        return api::omit_points(request_, feature, error_in_request, areas_.warnings);
    }

    const SampleRequest& request_;
    const PolygonInput& polygon_;
    const FeatureCounts& counts_;
    const FeatureList& features_;
    Areas areas_;
};

Result<Domain> united(const Areas& areas, const std::stop_token& stop) {
    std::vector<const Domain*> domains;
    for (const MapFeature& feature : areas.features) domains.push_back(&feature.area);
    return Domain::united(domains, stop);
}

/// Leaves out the points of features of which the exclusions leave no area.
/// @param lost  indices into the features of `areas`
Result<void> omit_points(const SampleRequest& request, std::span<const std::uint32_t> lost, Areas& areas) {
    for (const std::uint32_t i : lost) {
        const std::uint32_t feature = areas.numbers[i];
        const Error error{ErrorCode::Unusable, "nothing is left of the feature", request.features->locate(feature)};
        if (auto omitted = omit_points(request, feature, error, areas.warnings); !omitted) return omitted;
    }
    return {};
}

/// Subtracts the exclusions of a request from its features. In the plane, also applies the buffer.
/// @param whole  union of all features
/// @returns      union of the remaining features
Result<Domain> exclude(const SampleRequest& request, Domain whole, const Limits& limits, const Decode& decode,
                       Areas& areas, const std::stop_token& stop) {
    if (!request.has_exclusions()) return whole;
    auto exclusions = find_exclusions(request, whole.bounds(), limits, decode, stop);
    if (!exclusions) return tl::unexpected(exclusions.error());
    auto left = without(whole, *exclusions, request, stop);
    const bool keeps_off = request.buffer > 0 && request.coordinates == Coordinates::Plane;
    if (left && keeps_off) left = without_buffer(*left, request, stop);
    if (!left) return left;
    const auto lost =
        keeps_off
            ? confine(areas.features, *left, stop)
            : cut_areas(areas.features, [&](const Domain& area) { return without(area, *exclusions, request, stop); });
    if (!lost) return tl::unexpected(lost.error());
    if (auto omitted = omit_points(request, *lost, areas); !omitted) return tl::unexpected(omitted.error());
    if (auto any = check_points(areas, *request.features); !any) return tl::unexpected(any.error());
    std::ranges::move(exclusions->repairs, std::back_inserter(areas.repairs));
    return left;
}

/// Placed dots of all classes.
struct PlacedDots {
    std::vector<ClassDots> classes;
    std::optional<double> pitch;
    std::vector<std::uint32_t> lost;  ///< features of which the buffer on the globe leaves no area
};

Result<PlacedDots> distribute(const SampleRequest& request, const Areas& areas, const Domain& whole,
                              const Density& density, const Control& control) {
    if (request.coordinates == Coordinates::Plane) {
        return distribute_dots(areas.features, whole.bounds(), density, request.run, control)
            .map([](std::vector<ClassDots>&& classes) {
                return PlacedDots{std::move(classes), {}, {}};
            });
    }
    return distribute_dots_on_globe(areas.features, whole, density, request.run, request.buffer, control)
        .map([](GlobeDots&& placed) {
            return PlacedDots{std::move(placed.classes), placed.pitch, std::move(placed.lost)};
        });
}

/// Converts an error about a feature in `areas` to an error about the request.
Error located(const SampleRequest& request, const Areas& areas, Error error) {
    constexpr std::string_view kFeature = "features/";
    if (!error.field.starts_with(kFeature)) return error_of_options(request, error_below(std::move(error), ""));
    const std::size_t feature = std::stoul(error.field.substr(kFeature.size()));
    error.field = request.features->locate(areas.numbers[feature]);
    return error;
}

Result<PlacedDots> place(const SampleRequest& request, const Areas& areas, const Domain& whole, const Density& density,
                         const Control& control) {
    if (auto going = check_stop(control.stop); !going) return tl::unexpected(going.error());
    auto placed = distribute(request, areas, whole, density, control);
    if (!placed) return tl::unexpected(located(request, areas, placed.error()));
    for (ClassDots& each : placed->classes) {
        if (auto going = check_whole(each.dots, request.on_deadline); !going) return tl::unexpected(going.error());
        if (auto ordered = order_dots(request, whole, each, control); !ordered) return tl::unexpected(ordered.error());
        for (std::uint32_t& feature : each.feature_of) feature = areas.numbers[feature];
    }
    return placed;
}

void warn_of_degrees(const SampleRequest& request, const Domain& whole, std::vector<Warning>& warnings) {
    if (request.coordinates != Coordinates::Plane) return;
    if (const auto detail = warning_of_degrees(whole.bounds()))
        warnings.push_back({std::get<PolygonInput>(request.domain).locate({}), *detail});
}

}  // namespace

Result<Answer> run_dot_map(const SampleRequest& request, const Limits& limits, const Decode& decode,
                           const Control& control, Timings& timings, BodySink* sink) {
    Stopwatch watch;
    auto areas = AreaMaker(request).execute(control.stop);
    if (!areas) return tl::unexpected(areas.error());
    const auto whole = united(*areas, control.stop).and_then([&](Domain&& all) {
        return exclude(request, std::move(all), limits, decode, *areas, control.stop);
    });
    if (!whole) return tl::unexpected(whole.error());
    const auto page = plan_page(request, *whole, limits);
    if (!page) return tl::unexpected(page.error());
    const auto density = make_density(request, limits, decode, control);
    timings.decode = watch.lap();
    if (!density) return tl::unexpected(density.error());

    auto placed = place(request, *areas, *whole, *density, control);
    timings.optimise = watch.lap();
    if (!placed) return tl::unexpected(placed.error());
    if (auto omitted = omit_points(request, placed->lost, *areas); !omitted) return tl::unexpected(omitted.error());
    Answer answer;
    for (ClassDots& each : placed->classes) {
        if (request.format->is_drawn() && placed->pitch) bring_into(page->box, each.dots.points);
        answer.sites += each.dots.points.size();
        answer.partial = answer.partial || each.dots.stopped;
    }
    warn_of_degrees(request, *whole, areas->warnings);
    const Report report{request.run.seed,
                        timings.decode + timings.optimise,
                        {},
                        request.method->name,
                        areas->repairs,
                        {},
                        areas->warnings,
                        placed->pitch};
    answer.media_type = request.format->file.content_type();
    answer.repeats = request.format->repeats();
    if (request.format->file.name != "json") add_remarks(areas->repairs, areas->warnings, answer);
    Body body(answer, sink, control.stop);
    auto written = write_sample(request, *whole, *page, placed->classes, report, control, body);
    timings.encode = watch.lap();
    if (!written) return tl::unexpected(written.error());
    return body.finish(std::move(answer));
}

}  // namespace ccdt::api
