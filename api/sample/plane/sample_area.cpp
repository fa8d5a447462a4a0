// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/sample_area.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <variant>

#include "api/input/option_reader.h"
#include "api/run/deadline.h"
#include "api/sample/plane/exclusions.h"
#include "core/ccdt/globe/region.h"
#include "core/ccdt/maps/confine.h"

namespace ccdt::api {
namespace {

/// Formats a number of points, such as "3 points".
std::string points(std::size_t count) {
    return std::to_string(count) + (count == 1 ? " point" : " points");
}

/// Adds warnings about geometries that have no polygon. In a dot map, features without polygons have their own
/// warnings.
void warn_of_omitted(const PolygonInput& polygon, bool is_map, std::vector<Warning>& warnings) {
    for (const auto& [kind, first, count] : polygon.omitted) {
        const bool is_empty = kind == "null" || kind == "empty";
        if (is_empty && is_map) continue;
        std::string text = std::to_string(count) + (is_empty ? ' ' + std::string(kind) : "");
        text += count == 1 ? " geometry is" : " geometries are";
        text += " left out";
        if (!is_empty) text += ": type " + std::string(kind) + ", but only polygons have an area";
        warnings.push_back({first, std::move(text)});
    }
}

/// Adds a warning if coordinates are longitudes and latitudes in the plane, or others on the globe.
void warn_of_system(const SampleRequest& request, std::vector<Warning>& warnings) {
    const auto& system = request.region.system;
    if (!system || system->is_lonlat == request.region.is_on_globe()) return;
    const std::string subject = "according to its reference system " + excerpt(system->name) + ", the map ";
    warnings.push_back(
        {request.field_of("coordinates"),
         subject + (system->is_lonlat ? "has longitudes and latitudes: coordinates=lonlat spreads points evenly on the "
                                        "earth's surface"
                                      : "does not have longitudes and latitudes in degrees: coordinates should be "
                                        "plane")});
}

/// Adds a warning if an edge of a ring on the globe follows a parallel around more than half of the globe, because the
/// ring then takes the shorter way (unrolled()).
void warn_of_long_edges(const PolygonInput& polygon, std::vector<Warning>& warnings) {
    constexpr double kHalf = 180, kTurn = 360;
    for (std::size_t part = 0; part < polygon.parts.size(); ++part) {
        const Ring& ring = polygon.parts[part].outer;
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Point a = ring[i], b = ring[(i + 1) % ring.size()];
            const double turn = std::abs(b.x - a.x);
            if (a.y != b.y || !(turn > kHalf && turn < kTurn)) continue;
            std::string text =
                "an edge that spans more than 180 degrees of longitude takes the shorter way, across the "
                "antimeridian; corners in between, at most 180 degrees apart, determine the other way";
            warnings.push_back({polygon.pointer_to('/' + std::to_string(part) + "/0/" + std::to_string(i)), text});
            return;
        }
    }
}

/// Completes the error of a region on the globe: a ring along a parallel encloses no area in degrees.
Error with_hint(Error error, std::span<const PolygonPart> parts) {
    constexpr double kTurn = 360;
    const auto is_parallel = [](const PolygonPart& part) {
        Box box = part.outer.empty() ? Box{} : Box{part.outer.front(), part.outer.front()};
        for (const Point& p : part.outer) box.include(p);
        return box.height() == 0 && box.width() >= kTurn;
    };
    if (std::ranges::any_of(parts, is_parallel))
        error.message +=
            ": a ring along a parallel from -180 to 180 encloses a pole only with the corners [180, 90] and "
            "[-180, 90], or [180, -90] and [-180, -90]";
    return error;
}

/// Adds a warning that the points of a feature are left out, if the feature should have points. Errors: `error` if the
/// request rejects invalid polygons and the feature should have points.
/// @param error  reason for leaving out the points; its field is a JSON Pointer
Result<void> omit_points(const SampleRequest& request, std::size_t feature, const Error& error,
                         std::vector<Warning>& warnings) {
    const std::size_t count = request.counts->points_of(feature);
    if (count == 0) return {};
    if (request.region.on_invalid == OnInvalid::Reject) return tl::unexpected(error);
    warnings.push_back({error.field, error.message + ": " + points(count) + " left out"});
    return {};
}

Result<void> check_points(std::span<const MapFeature> areas, const FeatureList& features) {
    if (std::ranges::any_of(areas, [](const MapFeature& each) { return dots_of(each) > 0; })) return {};
    return failure(ErrorCode::Unusable, "no feature with points has an area", features.pointer);
}

/// Computes the areas of the features of a dot map, one after the other.
class FeatureAreas {
public:
    explicit FeatureAreas(const SampleRequest& request)
        : request_(request),
          polygon_(std::get<PolygonInput>(request.region.domain)),
          counts_(*request.counts),
          features_(*request.features) {}

    Result<SampleArea> make(const std::stop_token& stop) {
        warn_of_missing();
        for (std::size_t i = 0; i < counts_.features(); ++i) {
            if (auto going = check_stop(stop); !going) return tl::unexpected(going.error());
            if (auto added = add(i, stop); !added) return tl::unexpected(added.error());
        }
        if (auto any = check_points(areas_, features_); !any) return tl::unexpected(any.error());
        std::vector<const Domain*> domains;
        for (const MapFeature& feature : areas_) domains.push_back(&feature.area);
        return Domain::united(domains, stop).map([&](Domain&& whole) {
            return SampleArea{std::move(whole), std::move(areas_), std::move(numbers_), std::move(repairs_),
                              std::move(warnings_)};
        });
    }

private:
    void warn_of_missing() {
        for (const auto& missing : counts_.missing) {
            if (missing.features == 0) continue;
            const std::string features = missing.features == 1 ? "a feature lacks this property, or it is null"
                                                               : std::to_string(missing.features) +
                                                                     " features lack this property, or it is null";
            warnings_.push_back({missing.first, features + ": this counts as 0"});
        }
    }

    /// Converts the field of an error or repair of Domain::repair() to a JSON Pointer in the request. Such a field
    /// numbers the parts within the feature.
    std::string pointer_to(std::size_t feature, const std::string& field) const {
        if (field.empty()) return features_.pointer_to(feature);
        const std::size_t slash = field.find('/', 1);
        const std::size_t part = std::stoul(field.substr(1, slash - 1)) + features_.first_part[feature];
        return polygon_.pointer_to('/' + std::to_string(part) +
                                   (slash == std::string::npos ? "" : field.substr(slash)));
    }

    Result<void> add(std::size_t feature, const std::stop_token& stop) {
        const auto parts = parts_of(request_, feature);
        if (!parts) return omit(feature, parts.error());
        if (parts->empty()) return omit(feature, {ErrorCode::Unusable, "the feature has no polygon", ""});
        auto made = Domain::repair(*parts, stop);
        if (!made && request_.region.is_on_globe()) made.error() = with_hint(made.error(), *parts);
        if (!made) return omit(feature, made.error());
        for (Repair& repair : made->repairs) {
            repair.field = pointer_to(feature, repair.field);
            if (request_.region.on_invalid == OnInvalid::Reject)
                return failure(ErrorCode::Unusable, repair.detail, repair.field);
            repairs_.push_back(std::move(repair));
        }
        MapFeature own{std::move(made->domain), {}};
        for (std::size_t number = 0; number < counts_.classes.size(); ++number)
            own.dots.push_back(counts_.count(feature, number));
        areas_.push_back(std::move(own));
        numbers_.push_back(static_cast<std::uint32_t>(feature));
        return {};
    }

    /// Leaves out a feature that has no valid area.
    Result<void> omit(std::size_t feature, const Error& error) {
        const Error error_in_request{error.code, error.message, pointer_to(feature, error.field)};
        if (error.code != ErrorCode::Unusable) return tl::unexpected(error_in_request);
        return omit_points(request_, feature, error_in_request, warnings_);
    }

    const SampleRequest& request_;
    const PolygonInput& polygon_;
    const FeatureCounts& counts_;
    const FeatureList& features_;
    std::vector<MapFeature> areas_;
    std::vector<std::uint32_t> numbers_;
    std::vector<Repair> repairs_;
    std::vector<Warning> warnings_;
};

/// Builds the domain of a request that is not for a dot map, before exclusions.
Result<SampleArea> make_domain(const SampleRegion& region, const std::stop_token& stop) {
    const auto valid = [](Domain&& domain) { return RepairedDomain{std::move(domain), {}}; };
    const auto area_of = [](RepairedDomain&& made) {
        return SampleArea{std::move(made.domain), {}, {}, std::move(made.repairs), {}};
    };
    if (const auto* rectangle = std::get_if<Rectangle>(&region.domain))
        return make_domain(*rectangle).map(valid).map(area_of);
    const auto& polygon = std::get<PolygonInput>(region.domain);
    const auto located = [&](Error error) {
        error.field = polygon.pointer_to(error.field);
        return error;
    };
    const auto parts = region.is_on_globe() ? unrolled(polygon.parts) : Result<std::vector<PolygonPart>>();
    if (!parts) return tl::unexpected(located(parts.error()));
    const auto& given = region.is_on_globe() ? *parts : polygon.parts;
    auto domain =
        region.on_invalid == OnInvalid::Repair ? Domain::repair(given, stop) : Domain::create(given, stop).map(valid);
    if (!domain && region.is_on_globe()) domain.error() = with_hint(domain.error(), given);
    if (!domain) return tl::unexpected(located(domain.error()));
    for (Repair& repair : domain->repairs) repair.field = polygon.pointer_to(repair.field);
    return std::move(domain).map(area_of);
}

/// Subtracts the exclusions of a request from its area, and in the plane erodes the area by the buffer.
Result<void> exclude(const SampleRequest& request, const Limits& limits, const Decode& decode,
                     const std::stop_token& stop, SampleArea& area) {
    auto exclusions = find_exclusions(request, area.whole.bounds(), limits, decode, stop);
    if (!exclusions) return tl::unexpected(exclusions.error());
    auto remaining = without(area.whole, *exclusions, request, stop);
    const bool is_eroded = request.region.buffer > 0 && !request.region.is_on_globe();
    if (remaining && is_eroded) remaining = without_buffer(*remaining, request, stop);
    if (!remaining) return tl::unexpected(remaining.error());
    area.whole = *std::move(remaining);
    std::ranges::move(exclusions->repairs, std::back_inserter(area.repairs));
    if (!request.counts) return {};
    const auto cut = [&](const Domain& feature) { return without(feature, *exclusions, request, stop); };
    const auto lost = is_eroded ? confine(area.features, area.whole, stop) : cut_areas(area.features, cut);
    if (!lost) return tl::unexpected(lost.error());
    if (auto warned = warn_of_lost(request, *lost, area); !warned) return warned;
    return check_points(area.features, *request.features);
}

}  // namespace

Result<SampleArea> make_area(const SampleRequest& request, const Limits& limits, const Decode& decode,
                             const std::stop_token& stop) {
    auto area = request.counts ? FeatureAreas(request).make(stop) : make_domain(request.region, stop);
    if (!area) return area;
    if (const auto* polygon = std::get_if<PolygonInput>(&request.region.domain)) {
        warn_of_omitted(*polygon, request.counts.has_value(), area->warnings);
        if (request.region.is_on_globe()) warn_of_long_edges(*polygon, area->warnings);
    }
    warn_of_omitted(request.region.avoid, false, area->warnings);
    warn_of_system(request, area->warnings);
    if (!request.region.has_exclusions()) return area;
    if (auto remaining = exclude(request, limits, decode, stop, *area); !remaining)
        return tl::unexpected(remaining.error());
    return area;
}

Result<void> warn_of_lost(const SampleRequest& request, std::span<const std::uint32_t> lost, SampleArea& area) {
    for (const std::uint32_t i : lost) {
        const std::uint32_t feature = area.numbers[i];
        const Error error{ErrorCode::Unusable, "nothing is left of the feature", request.features->pointer_to(feature)};
        if (auto omitted = omit_points(request, feature, error, area.warnings); !omitted) return omitted;
    }
    return {};
}

Result<std::vector<PolygonPart>> parts_of(const SampleRequest& request, std::size_t feature) {
    const auto& first_part = request.features->first_part;
    const auto begin = std::get<PolygonInput>(request.region.domain).parts.begin();
    std::vector<PolygonPart> parts(begin + static_cast<std::ptrdiff_t>(first_part[feature]),
                                   begin + static_cast<std::ptrdiff_t>(first_part[feature + 1]));
    return request.region.is_on_globe() ? unrolled(std::move(parts)) : parts;
}

}  // namespace ccdt::api
