// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/sample_cost.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <variant>

#include "api/json/json_document.h"
#include "api/output/stage_costs.h"
#include "api/run/estimate.h"
#include "api/sample/plane/exclusions.h"
#include "api/sample/plane/sample_writer.h"
#include "core/geometry/repair.h"
#include "core/picture/tone.h"

namespace ccdt::api {
namespace {

/// Estimates the cost of validating a polygon.
Estimate domain_cost(std::size_t corner_count) {
    constexpr double kBytes = 420, kPieceBytes = 210;
    constexpr double kTime = 2.5 * kMicrosecond;
    if (corner_count == 0) return {};
    const auto corners = static_cast<double>(corner_count);
    // The number of crossings of edges is not known yet. The worst case, in which each edge crosses all others, is
    // rare, so the time is limited. The limit is just large enough that a polygon that may have many crossings does not
    // count as a short request.
    constexpr double kPieceTime = 6 * kMicrosecond, kMaxTime = 25'000 * kMicrosecond;
    const double pieces = std::min(2 * corners * corners, static_cast<double>(max_pieces(corner_count)));
    return {corners * kBytes + pieces * kPieceBytes, corners * kTime + std::min(pieces * kPieceTime, kMaxTime)};
}

std::size_t corners_of(const std::variant<PolygonInput, Rectangle>& domain) {
    const auto* polygon = std::get_if<PolygonInput>(&domain);
    return polygon == nullptr ? 0 : polygon->corner_count();
}

Estimate buffer_cost(double corners) {
    constexpr double kBytes = 3'000, kTime = 100 * kMicrosecond;
    return {corners * kBytes, corners * kTime};
}

/// Returns the maximum number of corners of the outline of an excluded picture. Most outlines have less than a tenth of
/// this number.
std::size_t dark_corners(const SampleRequest& request) {
    return request.region.exclude
               ? std::min<std::size_t>(kMaxExcludedCorners, 4 * request.region.exclude->header.pixels())
               : 0;
}

/// Estimates the cost of creating the domain: validating the polygons and the avoided areas, and subtracting the
/// exclusions.
Estimate domain_cost(const SampleRequest& request) {
    const std::size_t corners = corners_of(request.region.domain), avoided = request.region.avoid.corner_count();
    const Estimate made = then(domain_cost(corners), domain_cost(avoided));
    const Estimate remaining = avoided == 0 ? made : then(made, domain_cost(corners + avoided));
    const std::size_t dark = dark_corners(request);
    const Estimate seen = dark == 0 ? remaining : then(remaining, domain_cost(corners + avoided + dark));
    return request.region.buffer > 0 ? then(seen, buffer_cost(static_cast<double>(corners + avoided + dark))) : seen;
}

/// Estimates the cost of projecting a region onto the charts of the globe, and of the densities on the charts.
Estimate charts_cost(const SampleRequest& request) {
    if (!request.region.is_on_globe()) return {};
    constexpr double kCells = 1'024 * 1'024, kCellsOfDensity = 2'048 * 2'048, kTime = 0.2 * kMicrosecond;
    const bool is_even = std::holds_alternative<std::monostate>(request.density);
    const double cells = is_even ? kCells : kCellsOfDensity;
    return domain_cost(corners_of(request.region.domain) + request.region.avoid.corner_count() +
                       dark_corners(request)) *
               2 +
           density_cost(cells) + Estimate{cells * sizeof(double), cells * kTime};
}

/// Estimates the cost of subtracting exclusions from each feature of a dot map. With a buffer, each feature is
/// intersected with an area that has the corners of all features.
Estimate exclusions_cost(const SampleRequest& request) {
    if (!request.region.has_exclusions()) return {};
    constexpr double kFeature = 60 * kMicrosecond, kCornerSeen = 0.01 * kMicrosecond, kBytes = 420;
    const auto features = static_cast<double>(request.counts->features());
    const std::size_t own = request.region.buffer > 0 ? corners_of(request.region.domain) : 0;
    const auto corners = static_cast<double>(own + request.region.avoid.corner_count() + dark_corners(request));
    return {corners * kBytes, features * (kFeature + corners * kCornerSeen)};
}

/// Estimates the cost of computing, for one class of a dot map, the area of each feature that fixed points occupy. The
/// dots of the feature share the remaining area.
Estimate fixed_areas_cost(const SampleRequest& request) {
    constexpr double kFeature = 900 * kMicrosecond;
    return {0, kFeature * static_cast<double>(std::min(request.run.fixed.size(), request.counts->features()))};
}

/// Estimates the cost of computing the areas of the features of a dot map, and of keeping dots inside their features.
Estimate dot_map_cost(const SampleRequest& request) {
    if (!request.counts) return {};
    constexpr Estimate kFeature{4'096, 25 * kMicrosecond}, kCorner{600, 2.5 * kMicrosecond};
    constexpr Estimate kDot{600, 3 * kMicrosecond};
    const auto features = static_cast<double>(request.counts->features());
    const auto corners = static_cast<double>(corners_of(request.region.domain));
    const auto classes = static_cast<double>(request.counts->classes.size());
    return exclusions_cost(request) + (kFeature * features + kCorner * corners + fixed_areas_cost(request)) * classes +
           kDot * static_cast<double>(request.run.sites);
}

/// Estimates the cost of finding the feature of each point, and of sorting points by feature.
Estimate features_cost(const SampleRequest& request) {
    if (!request.features || request.counts) return {};
    constexpr Estimate kFeature{4'096, 25 * kMicrosecond}, kCorner{300, 0.5 * kMicrosecond};
    constexpr Estimate kSite{80, 0.5 * kMicrosecond};
    const std::size_t corners = corners_of(request.region.domain);
    return domain_cost(corners) + kFeature * static_cast<double>(request.features->size()) +
           kCorner * static_cast<double>(corners) + kSite * static_cast<double>(request.run.sites);
}

/// Estimates the cost of removing long waves in a polygon, on the mesh of the polygon. Returns an empty estimate for
/// dot maps, because dot_map_cost() includes this step.
Estimate long_waves_cost(const SampleRequest& request) {
    const Options& run = request.run;
    const bool is_polygon = std::holds_alternative<PolygonInput>(request.region.domain) && !request.counts;
    if (!is_polygon || run.quality == Quality::Draft || run.iterations == 0) return {};
    constexpr double kBytes = 200;
    return {static_cast<double>(run.sites) * kBytes, 0};
}

Box bounds_of(const std::variant<PolygonInput, Rectangle>& domain) {
    if (const auto* rectangle = std::get_if<Rectangle>(&domain)) return {{0, 0}, {rectangle->width, rectangle->height}};
    constexpr double kFar = std::numeric_limits<double>::max();
    Box box{{kFar, kFar}, {-kFar, -kFar}};
    for (const auto& part : std::get<PolygonInput>(domain).parts) {
        for (const Point& p : part.outer) box.include(p);
    }
    return box;
}

/// Returns the maximum number of pixels of a drawing. If the server chooses the width, the width depends on the area of
/// the domain, which is not known yet for a polygon.
/// @param box  bounding box of the domain; its sides must be positive and finite
double drawn_pixels(const SampleRequest& request, const Box& box, const Limits& limits) {
    const auto most = static_cast<double>(limits.max_pixels);
    if (request.output.width)
        return std::min(*request.output.width * (*request.output.width * box.height() / box.width() + 1), most);
    const double chosen = std::holds_alternative<PolygonInput>(request.region.domain)
                              ? kMaxCanvasPixels
                              : std::max(kMinDrawingSide * kMinDrawingSide,
                                         static_cast<double>(request.run.sites) * kPixelPitch * kPixelPitch);
    return std::min({chosen, kMaxCanvasPixels, most});
}

/// Estimates the cost of ordering points by the option `order`. The estimate does not include the path that drawings of
/// shapes have without this option; writing_cost() includes it.
Estimate ordering_cost(const SampleRequest& request) {
    constexpr Estimate kPath{500, 3.5 * kMicrosecond}, kProgressive{290, 6 * kMicrosecond};
    const PointOrder order = request.output.order.value_or(PointOrder::None);
    if (order == PointOrder::None) return {};
    return (order == PointOrder::Path ? kPath : kProgressive) * static_cast<double>(request.run.sites);
}

/// Whether a box has an area and is finite. Otherwise, the domain is rejected and nothing is written.
bool is_drawable(const Box& box) {
    const auto is_length = [](double side) { return side > 0 && std::isfinite(side); };
    return is_length(box.width()) && is_length(box.height());
}

Estimate turns_cost(const SampleRequest& request, const Box& box) {
    const auto sites = static_cast<double>(request.run.sites);
    Page page{box};
    if (!place_on_paper(request.output.drawing, page)) return {};  // nothing is written
    const double radius = request.output.dot.value_or(std::sqrt(box.width() * box.height() / sites) / 4);
    const double unit = page.width_mm ? page.unit() : 1 / box.width();
    return turns_cost(*request.output.format, request.output.drawing, sites, unit * radius);
}

Estimate writing_cost(const SampleRequest& request, const Limits& limits) {
    const PointFormat& format = *request.output.format;
    const auto sites = static_cast<double>(request.run.sites);
    const Box box = bounds_of(request.region.domain);
    if (!is_drawable(box)) return {};
    if (format.raster() == nullptr) return format.per_site * sites + turns_cost(request, box);
    const double pixels = drawn_pixels(request, box, limits);
    const double scale =
        request.output.width ? *request.output.width / box.width() : std::sqrt(pixels / box.width() / box.height());
    const auto radius = request.output.dot ? std::optional(*request.output.dot * scale) : std::nullopt;
    constexpr Estimate kMapPixel{4, 0.01 * kMicrosecond}, kMapDot{0, 3 * kMicrosecond};
    const Estimate map = request.counts ? kMapPixel * pixels + kMapDot * sites : Estimate{};
    return drawing_cost(format, raster_cost(sites, pixels, radius, true) + map, sites, pixels);
}

std::size_t bytes_of(const PolygonInput& polygon) {
    return polygon.corner_count() * sizeof(Point);
}

std::size_t bytes_of(const FeatureList& features) {
    std::size_t size = features.first_part.size() * sizeof(std::size_t);
    for (const std::string& id : features.ids) size += sizeof(std::string) + id.size();
    for (const auto& values : features.carried.of_feature) {
        size += sizeof(values);  // NOLINT(bugprone-sizeof-container): without its elements
        for (const auto& each : values) size += sizeof(each) + each.value.size();
    }
    return size;
}

/// Returns an upper estimate of the bytes that ids and properties take in an answer.
/// @param rows  number of points that repeat the properties of their features
double largest_features(const FeatureList& features, double rows) {
    std::size_t largest = 0;
    for (const std::string& id : features.ids) largest = std::max(largest, id.size());
    std::size_t properties = 0;
    for (std::size_t i = 0; i < features.carried.of_feature.size(); ++i)
        properties = std::max(properties, features.carried.size_of(i));
    constexpr double kEscapes = 2, kPunctuation = 16;  // of usual texts
    const double row = kEscapes * static_cast<double>(largest + properties) + kPunctuation;
    return static_cast<double>(bytes_of(features)) + rows * row;
}

}  // namespace

Cost cost_of(const SampleRequest& request, const Limits& limits) {
    if (request.threshold_mask) return total_cost(cost_of_mask(*request.threshold_mask));
    const bool is_uniform = std::holds_alternative<std::monostate>(request.density) && !request.region.is_on_globe();
    const Estimate placing = domain_cost(request) + charts_cost(request) + dot_map_cost(request) +
                             density_cost(cells_of(request.density)) + zones_cost(cells_of(request.density)) +
                             request.method->cost(request.run, is_uniform) + long_waves_cost(request);
    const Estimate made =
        then(then(placing, ordering_cost(request)), features_cost(request) + writing_cost(request, limits));
    const Estimate read = decoding_cost(request.density);
    Cost all =
        total_cost(then(request.region.exclude ? then(decoding_cost(*request.region.exclude), read) : read, made));
    all.answer = request.run.sites * request.output.format->least;
    return all;
}

std::size_t largest_answer(const SampleRequest& request, const Limits& limits) {
    if (request.threshold_mask) {
        const ThresholdMask& mask = *request.threshold_mask;
        constexpr double kHead = 16'384, kPixel = 2;  // the largest grey values have 16 bits
        return static_cast<std::size_t>(kHead + kPixel * mask.torus.width * mask.torus.height * mask.depth.value_or(1));
    }
    const Box box = bounds_of(request.region.domain);
    if (!is_drawable(box)) return 0;
    const PointFormat& format = *request.output.format;
    const auto sites = static_cast<double>(request.run.sites);
    const double pixels = format.raster() == nullptr ? 0 : drawn_pixels(request, box, limits);
    double bytes = largest_answer(format, sites, pixels, turns_cost(request, box), request.run.keep_mesh);
    if (request.features) bytes += largest_features(*request.features, format.repeats_properties ? sites : 0);
    return static_cast<std::size_t>(bytes);
}

Cost cost_of_parsing(std::string_view body) {
    const auto count = [body](char c) { return static_cast<double>(std::ranges::count(body, c)); };
    // Upper bounds: each value except the first follows one of these characters, and each text is between two quotes.
    const double values = 1 + count(',') + count(':') + count('[') + count('{');
    const double quotes = count('"');
    const auto size = static_cast<double>(body.size());
    // Rings of TopoJSON may use the same arcs many times, so a short body can have many corners.
    const double corners = body.find("\"Topology\"") == std::string_view::npos ? 0 : PolygonInput::kMaxCorners;
    return total_cost({corners * 2 * sizeof(Point) + size * 2 +
                           std::min(values, static_cast<double>(JsonDocument::kMaxValues)) * 64 + quotes / 2 * 96,
                       size * 0.02 * kMicrosecond});
}

std::size_t size_of(const SampleRequest& request) {
    std::size_t size =
        bytes_of(request.region.avoid) + bytes_of(request.density) + request.run.fixed.size() * sizeof(Point);
    if (const auto* polygon = std::get_if<PolygonInput>(&request.region.domain)) size += bytes_of(*polygon);
    if (request.features) size += bytes_of(*request.features);
    if (request.counts) size += request.counts->counts.size() * sizeof(std::size_t);
    if (request.region.exclude) size += bytes_of(*request.region.exclude);
    return size;
}

}  // namespace ccdt::api
