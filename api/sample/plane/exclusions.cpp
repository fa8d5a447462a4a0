// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/exclusions.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/ccdt/globe/region.h"
#include "core/ccdt/globe/turns.h"
#include "core/geometry/difference.h"
#include "core/geometry/hexagonal_spacing.h"
#include "core/geometry/inset.h"
#include "core/geometry/pixel_outline.h"
#include "core/picture/tone.h"

namespace ccdt::api {
namespace {

constexpr const char* kAvoid = "/avoid";
constexpr const char* kExcludedImage = "/exclude/image";

/// Returns copies of an area on the globe, shifted by multiples of 360 degrees: one for each shift at which the area
/// may overlap the box.
std::vector<Area> copies_over(const Box& box, const Area& area) {
    constexpr double kFar = std::numeric_limits<double>::max();
    double west = kFar, east = -kFar;
    for (const Ring& ring : area) {
        for (const Point& p : ring) {
            west = std::min(west, p.x);
            east = std::max(east, p.x);
        }
    }
    std::vector<Area> copies;
    for (double shift = std::ceil((box.min.x - east) / kTurn); west + shift * kTurn <= box.max.x; ++shift) {
        Area& copy = copies.emplace_back(area);
        for (Ring& ring : copy) {
            for (Point& p : ring) p.x += shift * kTurn;
        }
    }
    return copies;
}

/// Converts an error about an avoided area to an error about the request.
Error located(Error error, const PolygonInput& avoid) {
    error.field = avoid.pointer_to(error.field);
    if (error.field.empty()) error.field = kAvoid;
    return error;
}

/// Computes the area of the polygons to be avoided. Fields of the repairs are JSON Pointers in the request.
Result<RepairedArea> avoided_area(const SampleRequest& request, const std::stop_token& stop) {
    const PolygonInput& avoid = request.region.avoid;
    const bool is_plane = !request.region.is_on_globe();
    const auto parts = is_plane ? Result<std::vector<PolygonPart>>(avoid.parts) : unrolled(avoid.parts);
    if (!parts) return tl::unexpected(located(parts.error(), avoid));
    auto area = Domain::repair_area(*parts, stop);
    if (!area) return tl::unexpected(located(area.error(), avoid));
    for (Repair& repair : area->repairs) repair.field = avoid.pointer_to(repair.field);
    if (area->repairs.empty() || request.region.on_invalid == OnInvalid::Repair) return area;
    return failure(ErrorCode::Unusable, area->repairs.front().detail, area->repairs.front().field);
}

/// Marks the pixels whose luminance, in linear light, is less than half the luminance of white.
PixelSet dark_pixels(const Picture& picture) {
    constexpr float kHalf = 0.5F;
    const std::vector<float> coverage = ink_coverage(picture, Tone::Linear, false);
    PixelSet pixels{picture.width, picture.height, std::vector<bool>(coverage.size())};
    std::transform(coverage.begin(), coverage.end(), pixels.marked.begin(), [](float ink) { return ink > kHalf; });
    return pixels;
}

/// Computes the area of the dark pixels of the excluded picture, if there is one.
Result<std::vector<Area>> dark_areas(const SampleRequest& request, const Box& box, const Limits& limits,
                                     const Decode& decode, const std::stop_token& stop) {
    if (!request.region.exclude) return {};
    const auto picture = decode.grey(request.region.exclude->bytes, limits.max_pixels, stop);
    if (!picture) return failure(picture.error().code, picture.error().message, kExcludedImage);
    auto outline = outline_of(dark_pixels(*picture), box, kMaxExcludedCorners);
    if (!outline)
        return failure(ErrorCode::LimitExceeded,
                       "the outline of the dark area of the excluded picture has more than " +
                           std::to_string(kMaxExcludedCorners) + " corners",
                       kExcludedImage);
    if (outline->empty()) return {};
    return std::vector<Area>{*std::move(outline)};
}

Result<Domain> without(const Domain& domain, std::span<const Area> areas, const char* field,
                       const std::stop_token& stop) {
    return ccdt::without(domain, areas, stop).map_error([&](Error error) {
        error.field = field;
        return error;
    });
}

/// Formats a distance with three significant digits. The distance is first reduced by half a percent, so that the
/// rounded number is not larger than `distance`.
std::string format_distance(double distance) {
    constexpr double kLess = 0.995;
    char text[32];
    const char* const end =
        std::to_chars(text, text + sizeof text, kLess * distance, std::chars_format::general, 3).ptr;
    return "about " + std::string(text, static_cast<std::size_t>(end - text));
}

}  // namespace

Result<Exclusions> find_exclusions(const SampleRequest& request, const Box& box, const Limits& limits,
                                   const Decode& decode, const std::stop_token& stop) {
    Exclusions found;
    if (!request.region.avoid.parts.empty()) {
        auto avoided = avoided_area(request, stop);
        if (!avoided) return tl::unexpected(avoided.error());
        found.avoided.push_back(std::move(avoided->rings));
        found.repairs = std::move(avoided->repairs);
    }
    auto dark = dark_areas(request, box, limits, decode, stop);
    if (!dark) return tl::unexpected(dark.error());
    found.dark = *std::move(dark);
    return found;
}

Result<Domain> without(const Domain& domain, const Exclusions& exclusions, const SampleRequest& request,
                       const std::stop_token& stop) {
    std::vector<Area> avoided;
    for (const Area& area : exclusions.avoided) {
        if (!request.region.is_on_globe()) {
            avoided.push_back(area);
        } else {
            std::ranges::move(copies_over(domain.bounds(), area), std::back_inserter(avoided));
        }
    }
    return without(domain, avoided, kAvoid, stop).and_then([&](const Domain& allowed) {
        return without(allowed, exclusions.dark, kExcludedImage, stop);
    });
}

Result<Domain> without_buffer(const Domain& domain, const SampleRequest& request, const std::stop_token& stop) {
    constexpr double kTolerance = 1e-3;  // relative to the spacing of the sites
    const double spacing = hexagonal_spacing(static_cast<double>(request.run.sites) / domain.area());
    auto remaining = inset(domain, request.region.buffer, kTolerance * spacing, stop);
    if (remaining) return remaining;
    constexpr double kMargin = 1.02;  // the computed clearance and the buffer each have an error of up to one percent
    const double farthest = largest_clearance(domain, stop);
    if (remaining.error().code != ErrorCode::Unusable || farthest > kMargin * request.region.buffer)
        return failure(remaining.error().code, remaining.error().message, request.field_of("buffer"));
    return failure(
        ErrorCode::Unusable,
        "no place is as far from the border as the buffer: the largest distance is " + format_distance(farthest),
        request.field_of("buffer"));
}

}  // namespace ccdt::api
