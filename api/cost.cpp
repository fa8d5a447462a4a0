// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/cost.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "api/drawing_size.h"
#include "api/json/json_document.h"
#include "api/output/plot.h"
#include "api/run/estimate.h"
#include "core/geometry/hexagonal_spacing.h"
#include "core/geometry/repair.h"
#include "core/halftone/dot_plan.h"
#include "core/halftone/dots.h"
#include "core/halftone/reduction.h"
#include "core/halftone/tone.h"
#include "core/halftone/two_sided.h"

namespace ccdt::api {
namespace {

constexpr double kFixedBytes = 6 << 20;

Cost cost(const Estimate& estimate) {
    return {static_cast<std::size_t>(estimate.bytes + kFixedBytes), estimate.seconds};
}

/// Estimates the application of levels. Its result is a second picture of the decoded size.
Estimate levels_cost(const HalftoneRequest& request) {
    if (request.levels == Levels{}) return {};
    constexpr double kTime = 0.006 * kMicrosecond;
    const double planes = request.palette.mixing == Mixing::Cover ? 1 : 3;
    const auto values = static_cast<double>(request.image.header.pixels()) * planes;
    return {values * sizeof(float), values * kTime};
}

/// Estimates the cropping of the picture. Its result is a second picture, at most of the decoded size.
Estimate cropping_cost(const HalftoneRequest& request) {
    if (request.fit != Fit::Cover) return {};
    constexpr double kTime = 0.002 * kMicrosecond;
    const double planes = request.palette.mixing == Mixing::Cover ? 2 : 4;
    const auto values = static_cast<double>(request.image.header.pixels()) * planes;
    return {values * sizeof(float), values * kTime};
}

/// Bytes per pixel: luminance, alpha, coverage and a vertically flipped copy, 4 bytes each.
constexpr double kGreyPlanes = 16;

Estimate decoding_cost(const ImageFile& file, double planes = kGreyPlanes) {
    constexpr double kTime = 0.03 * kMicrosecond;
    const auto pixels = static_cast<double>(file.header.pixels());
    const double decoder = static_cast<double>(file.header.decoder_bytes) + static_cast<double>(file.bytes.size());
    return {pixels * planes + decoder, pixels * kTime};
}

/// Returns whether the request is for dots on both sides of the tonal scale, in several channels.
bool has_channels(const HalftoneRequest& request) {
    return request.dots == Dots::Both && request.palette.mixing != Mixing::Cover;
}

/// Returns the number of inks. For dots on both sides, the number of channels, which is 3 for CMYK.
double inks_of(const HalftoneRequest& request) {
    const auto inks = static_cast<double>(request.palette.inks.size());
    return request.dots == Dots::Both && is_cmyk(request.palette.inks) ? inks - 1 : inks;
}

/// Returns whether dots on both sides have several channels that are custom inks.
bool has_ink_channels(const HalftoneRequest& request) {
    return has_channels(request) && request.palette.mixing == Mixing::Multiply && !is_cmyk(request.palette.inks);
}

/// Returns the number of kinds of dots, for dots on both sides in several channels.
double kinds_of_dots(const HalftoneRequest& request) {
    const std::size_t kinds = kinds_of(static_cast<std::size_t>(inks_of(request)));
    return static_cast<double>(std::min(kinds, kMaxInkKinds));
}

/// Returns the maximum number of cells in which dots on both sides of the tonal scale are planned.
double planned_cells(const HalftoneRequest& request, double sites) {
    // Assumes that dots draw a quarter of the picture, like rough_radius().
    constexpr double kShare = 0.25;
    const ImageHeader& header = request.image.header;
    const auto pixels = static_cast<double>(header.pixels());
    if (request.fit == Fit::Cover || (request.dot && !request.sites)) {
        // Upper bound. There are about 50 cells per dot; but where cells would be less than two pixels wide, pixels are
        // used instead, which makes up to four times as many.
        constexpr double kCellsPerDot = 200, kFewest = 64 * 64;
        return std::min(pixels, kCellsPerDot * sites + kFewest);
    }
    const double radius = std::sqrt(kShare * pixels / (std::numbers::pi * std::max(sites, 1.0)));
    const CellGrid cells = resolved_cells(static_cast<int>(header.width), static_cast<int>(header.height), radius);
    return static_cast<double>(cells.columns) * cells.rows;
}

/// Estimates the division of the picture into white and black ground, and the planning of dots on both.
Estimate grounds_cost(const HalftoneRequest& request, double sites) {
    constexpr Estimate kGrey{54, 0.3 * kMicrosecond}, kColour{200, 1.2 * kMicrosecond};
    constexpr Estimate kInk{48, 0.5 * kMicrosecond}, kKind{8, 0.05 * kMicrosecond}, kInks{80, 1.5 * kMicrosecond};
    constexpr double kReading = 8;
    const Estimate cell = has_ink_channels(request) ? kInk * inks_of(request) + kKind * kinds_of_dots(request) + kInks
                          : has_channels(request)   ? kColour
                                                    : kGrey;
    // Upper bound: two tables for each possible combination of grounds.
    constexpr Estimate kTable{1.4e6, 5'000 * kMicrosecond};
    const Estimate tables = has_ink_channels(request) ? kTable * std::exp2(inks_of(request) + 1) : Estimate{};
    return cell * planned_cells(request, sites) + tables +
           Estimate{kReading, 0} * static_cast<double>(request.image.header.pixels());
}

/// Estimates the fitting of the sizes of dots on both sides of the tonal scale.
Estimate dot_sizes_cost(const HalftoneRequest& request, double sites) {
    constexpr Estimate kPixel{36, 0.2 * kMicrosecond}, kSite{48, 5 * kMicrosecond};
    constexpr Estimate kPixelOfChannels{120, 0.6 * kMicrosecond}, kSiteOfChannels{220, 12 * kMicrosecond};
    if (request.dots != Dots::Both) return {};
    if (has_channels(request)) {
        const double channels = std::max(inks_of(request) / 3, 1.0);
        return (kPixelOfChannels * planned_cells(request, sites) + kSiteOfChannels * sites) * channels;
    }
    return kPixel * planned_cells(request, sites) + kSite * sites;
}

/// Estimates the sharpening of the coverage, one ink at a time. For dots on both sides of the tonal scale, the planning
/// of dots takes its place.
Estimate sharpening_cost(const HalftoneRequest& request, double sites) {
    if (request.dots == Dots::Both) return grounds_cost(request, sites);
    if (!(request.detail > 0)) return {};
    constexpr double kTime = 0.05 * kMicrosecond;
    const auto pixels = static_cast<double>(request.image.header.pixels());
    return {pixels * (inks_of(request) * 8 + 20), pixels * inks_of(request) * kTime};
}

/// Estimates decoding and separation. If inks mix, there are planes of red, green, blue and alpha, three planes of
/// light, and the coverage of each ink.
Estimate decoding_cost(const HalftoneRequest& request) {
    if (request.palette.mixing == Mixing::Cover) return decoding_cost(request.image);
    constexpr double kSeparating = 0.2 * kMicrosecond;
    if (has_channels(request) && !has_ink_channels(request))
        return decoding_cost(request.image, 28 + 4 * inks_of(request));
    // For a picture that has all colours, filling the table of separations takes as long as separating this number of
    // pixels, times the square of the number of inks.
    constexpr double kTable = 60'000;
    const auto pixels = static_cast<double>(request.image.header.pixels());
    return decoding_cost(request.image, 28 + 4 * inks_of(request)) +
           Estimate{0, (pixels + kTable * inks_of(request) * inks_of(request)) * kSeparating};
}

/// Estimates the validation of a polygon.
Estimate domain_cost(std::size_t corner_count) {
    constexpr double kBytes = 420, kPieceBytes = 160;
    constexpr double kTime = 2.5 * kMicrosecond;
    if (corner_count == 0) return {};
    const auto corners = static_cast<double>(corner_count);
    // It is not known yet how many edges cross. In the worst case, each edge crosses all others, but few polygons are
    // like that, so the time is limited. The limit is just large enough that a polygon that may have many crossings is
    // not treated as a short request.
    constexpr double kPieceTime = 6 * kMicrosecond, kMaxTime = 25'000 * kMicrosecond;
    const double pieces = std::min(2 * corners * corners, static_cast<double>(max_pieces(corner_count)));
    return {corners * kBytes + pieces * kPieceBytes, corners * kTime + std::min(pieces * kPieceTime, kMaxTime)};
}

std::size_t corners_of(const std::variant<PolygonInput, Rectangle>& domain) {
    const auto* polygon = std::get_if<PolygonInput>(&domain);
    return polygon == nullptr ? 0 : polygon->corner_count();
}

/// Estimates the erosion of a domain by the buffer.
Estimate buffer_cost(double corners) {
    constexpr double kBytes = 3'000, kTime = 100 * kMicrosecond;
    return {corners * kBytes, corners * kTime};
}

/// Returns the maximum number of corners of the outline of a mask. Most outlines have less than a tenth of this number.
std::size_t mask_corners(const SampleRequest& request) {
    return request.mask ? std::min(kMaxMaskCorners, 4 * request.mask->header.pixels()) : 0;
}

/// Estimates the creation of the domain: validating the polygons, validating the avoided areas, and subtracting the
/// exclusions.
Estimate domain_cost(const SampleRequest& request) {
    const std::size_t corners = corners_of(request.domain), avoided = request.avoid.corner_count();
    const Estimate made = then(domain_cost(corners), domain_cost(avoided));
    const Estimate left = avoided == 0 ? made : then(made, domain_cost(corners + avoided));
    const std::size_t masked = mask_corners(request);
    const Estimate seen = masked == 0 ? left : then(left, domain_cost(corners + avoided + masked));
    return request.buffer > 0 ? then(seen, buffer_cost(static_cast<double>(corners + avoided + masked))) : seen;
}

/// Estimates the integrals of a density grid.
Estimate density_cost(double cells) {
    return {cells * 20, cells * 0.03 * kMicrosecond};
}

/// Estimates the projection of a region onto the charts of the globe, and the densities on the charts.
Estimate charts_cost(const SampleRequest& request) {
    if (request.coordinates == Coordinates::Plane) return {};
    constexpr double kCells = 1'024 * 1'024, kCellsOfDensity = 2'048 * 2'048, kTime = 0.2 * kMicrosecond;
    const bool is_even = std::holds_alternative<std::monostate>(request.density);
    const double cells = is_even ? kCells : kCellsOfDensity;
    return domain_cost(corners_of(request.domain) + request.avoid.corner_count() + mask_corners(request)) * 2 +
           density_cost(cells) + Estimate{cells * sizeof(double), cells * kTime};
}

/// Estimates the subtraction of exclusions from each feature of a dot map. With a buffer, exclusions have the corners
/// of all features.
Estimate exclusions_cost(const SampleRequest& request) {
    if (!request.has_exclusions()) return {};
    constexpr double kFeature = 60 * kMicrosecond, kCornerSeen = 0.01 * kMicrosecond, kBytes = 420;
    const auto features = static_cast<double>(request.counts->features());
    const std::size_t own = request.buffer > 0 ? corners_of(request.domain) : 0;
    const auto corners = static_cast<double>(own + request.avoid.corner_count() + mask_corners(request));
    return {corners * kBytes, features * (kFeature + corners * kCornerSeen)};
}

/// Estimates the computation of the areas that fixed points take in the features.
Estimate fixed_areas_cost(const SampleRequest& request) {
    constexpr double kFeature = 900 * kMicrosecond;
    return {0, kFeature * static_cast<double>(std::min(request.run.fixed.size(), request.counts->features()))};
}

/// Estimates the areas of the features of a dot map, and the steps that keep dots inside their features.
Estimate dot_map_cost(const SampleRequest& request) {
    if (!request.counts) return {};
    constexpr Estimate kFeature{4'096, 25 * kMicrosecond}, kCorner{600, 2.5 * kMicrosecond};
    constexpr Estimate kDot{600, 3 * kMicrosecond};
    const auto features = static_cast<double>(request.counts->features());
    const auto corners = static_cast<double>(corners_of(request.domain));
    const auto classes = static_cast<double>(request.counts->classes.size());
    return exclusions_cost(request) + (kFeature * features + kCorner * corners + fixed_areas_cost(request)) * classes +
           kDot * static_cast<double>(request.run.sites);
}

/// Estimates the search for the feature of each point, and the sorting of points by feature.
Estimate features_cost(const SampleRequest& request) {
    if (!request.features || request.counts) return {};
    constexpr Estimate kFeature{4'096, 25 * kMicrosecond}, kCorner{300, 0.5 * kMicrosecond};
    constexpr Estimate kSite{80, 0.5 * kMicrosecond};
    const std::size_t corners = corners_of(request.domain);
    return domain_cost(corners) + kFeature * static_cast<double>(request.features->size()) +
           kCorner * static_cast<double>(corners) + kSite * static_cast<double>(request.run.sites);
}

/// Estimates the removal of long waves in a polygon, on the polygon's mesh. Returns nothing for dot maps, since
/// dot_map_cost() includes this step.
Estimate long_waves_cost(const SampleRequest& request) {
    const Options& run = request.run;
    const bool is_polygon = std::holds_alternative<PolygonInput>(request.domain) && !request.counts;
    if (!is_polygon || run.quality == Quality::Draft || run.iterations == 0) return {};
    constexpr double kBytes = 200;
    return {static_cast<double>(run.sites) * kBytes, 0};
}

/// Estimates the density grids: one for each ink or kind of dots. If there are several, there is also one for their
/// sum.
Estimate density_cost(const HalftoneRequest& request, double sites) {
    const auto pixels = static_cast<double>(request.image.header.pixels());
    if (has_channels(request)) return density_cost(planned_cells(request, sites) * (kinds_of_dots(request) * 1.2 + 1));
    const double inks = inks_of(request);
    return density_cost(pixels * (inks > 1 ? inks * 1.2 + 1 : 1));
}

/// Estimates the steps of the polish that several inks need: pushes between dots of different inks, and the comparison
/// of the printed appearance with the picture.
Estimate ink_polish_cost(const HalftoneRequest& request, const Options& options) {
    if (inks_of(request) < 2 || options.quality == Quality::Draft || options.iterations == 0) return {};
    const auto sites = static_cast<double>(options.sites);
    return {sites * 750, sites * (options.quality == Quality::Best ? 36 : 12) * kMicrosecond};
}

/// Estimates the placing of the dots of all inks.
Estimate placing_cost(const HalftoneRequest& request, double sites) {
    Options options = request.run;
    options.sites = static_cast<std::size_t>(sites);
    return methods().front().cost(options, false) + ink_polish_cost(request, options);
}

/// Returns the size of the picture as stored. Decoding may rotate it by 90 degrees.
PictureSize header_size(const HalftoneRequest& request) {
    return {static_cast<int>(request.image.header.width), static_cast<int>(request.image.header.height)};
}

/// Returns the maximum number of pixels of the output. If the server chooses the scale, there are at most 16 million.
double drawn_pixels(const HalftoneRequest& request, const Limits& limits) {
    const auto pixels = static_cast<double>(request.image.header.pixels());
    const auto most = static_cast<double>(limits.max_pixels);
    const auto [width, height] = header_size(request);
    const auto drawn = [&](PictureSize picture) {
        const auto canvas = settled_canvas(request, drawn_part(request, picture), limits);
        return canvas ? static_cast<double>(canvas->width) * canvas->height : 0.0;
    };
    const double settled = std::max(drawn({width, height}), drawn({height, width}));
    if (settled > 0) return std::min(settled, most);
    return std::min({pixels * kLargestScale * kLargestScale, kMaxCanvasPixels, most});
}

/// @param radius  radius of the dots, in pixels; a dot may cover the whole drawing
Estimate raster_cost(double sites, double pixels, std::optional<double> radius, bool antialias) {
    const double covered = sites * std::min(pixels, radius ? 4 * *radius * *radius : 0);
    return {sites * 166 + pixels * 6, (pixels * (antialias ? 0.04 : 0.005) + covered * 0.001) * kMicrosecond};
}

double shorter_side(const HalftoneRequest& request) {
    return static_cast<double>(std::min(request.image.header.width, request.image.header.height));
}

double longer_side(const HalftoneRequest& request) {
    return static_cast<double>(std::max(request.image.header.width, request.image.header.height));
}

/// Returns whether the shorter side of the picture is below two spacings of the dots.
bool is_thin(const HalftoneRequest& request, std::size_t dots) {
    const double density = static_cast<double>(dots) / static_cast<double>(request.image.header.pixels());
    return shorter_side(request) < 2 * hexagonal_spacing(density);
}

/// Returns the maximum number of dots. If the number follows from the radius, the maximum is the number for a solid
/// picture: the total area of these dots, which overlap, is twice the area of the picture.
double max_dots(const HalftoneRequest& request, const Limits& limits) {
    if (request.sites) return static_cast<double>(*request.sites);
    const double ink = static_cast<double>(request.image.header.pixels()) * inks_of(request);
    const auto usual = static_cast<double>(usual_sites(request, header_size(request), ink, 1, limits));
    if (!request.dot) return usual;
    const auto filling = [&](double pixels, double radius) {
        constexpr double kOverlaps = 2;
        const double area = std::max(std::numbers::pi * radius * radius, kMinDotArea);
        return std::clamp(kOverlaps * pixels / area, 1.0, static_cast<double>(limits.max_sites));
    };
    const double radius = request.dot->length;
    if (request.dot->millimetres) return filling(ink, radius / *request.drawing.width_mm * shorter_side(request));
    if (request.scale) return filling(ink, radius / *request.scale);
    if (request.on_screen || request.width || request.height)
        return filling(drawn_pixels(request, limits) * inks_of(request), radius);
    // If the server chooses the scale, the usual number of dots has a radius below this limit, in output pixels.
    constexpr double kLargest = 6;
    return filling(std::max(usual * kLargest * kLargest * std::numbers::pi, ink), radius);
}

/// Returns the requested radius, in output pixels.
std::optional<double> radius_of(const HalftoneRequest& request, double drawn_pixels) {
    if (!request.dot || !request.dot->millimetres)
        return request.dot ? std::optional(request.dot->length) : std::nullopt;
    const double scale = std::sqrt(drawn_pixels / static_cast<double>(request.image.header.pixels()));
    return request.dot->length / *request.drawing.width_mm * longer_side(request) * scale;
}

/// Estimates the supersampling of small dots, which is done band by band. A scale that the server chooses for the dots
/// needs no supersampling.
Estimate supersampling_cost(const HalftoneRequest& request, double sites, double pixels) {
    constexpr double kEach = 226;  // samples per dot, in a picture that is half covered
    const double samples = std::min(sites * kEach, kMaxSamples);
    const bool by_dots = !(request.on_screen || request.width || request.height || request.scale || request.dot);
    if (by_dots || samples < pixels) return {};
    return {sites * 16, samples * 0.02 * kMicrosecond};
}

/// Estimates the drawing of dots. The rasters of inks that mix are kept until they are combined.
Estimate raster_cost(const HalftoneRequest& request, double sites, double pixels, bool antialias) {
    const Estimate one =
        raster_cost(sites, pixels, radius_of(request, pixels), antialias) + supersampling_cost(request, sites, pixels);
    if (request.palette.mixing == Mixing::Cover) return one;
    const double inks = inks_of(request);
    return one + Estimate{pixels * inks, pixels * inks * (antialias ? 0.08 : 0.02) * kMicrosecond};
}

/// Estimates the writing of the circles or spirals that fill dots.
/// @param radius  radius of the dots, in millimetres
Estimate turns_cost(const PointFormat& format, const DrawingOptions& drawing, double sites, double radius) {
    const VectorWriter* const shapes = format.vector();
    if (shapes == nullptr) return {};
    const std::vector<Point> stroke =
        dot_stroke(drawing.style, std::min(kMaxTurns * drawing.pen_mm, radius), drawing.pen_mm);
    return shapes->per_turn_point * (static_cast<double>(stroke.size() - 1) * sites);
}

/// Returns the maximum radius of dots in millimetres. It is the radius for a solid picture: the total area of the dots,
/// which overlap, is then twice the area of the picture.
double largest_radius(const HalftoneRequest& request, double sites) {
    if (request.dot && request.dot->millimetres) return request.dot->length;
    const double width = request.drawing.width_mm.value_or(1);
    const double height = width * longer_side(request) / shorter_side(request);
    return std::sqrt(2 * width * height / (std::numbers::pi * sites));
}

/// Estimates the writing of a drawing. The radius of shapes is determined with a raster, which is freed before the
/// shapes are written. A drawing in pixels keeps the raster while it is written.
Estimate drawing_cost(const PointFormat& format, const Estimate& raster, double sites, double pixels) {
    const Estimate writing = format.per_site * sites + format.per_pixel * pixels;
    return format.raster() == nullptr ? then(raster, writing) : raster + writing;
}

Estimate writing_cost(const HalftoneRequest& request, double sites, const Limits& limits) {
    const PointFormat& format = *request.format;
    if (!format.is_drawn()) return format.per_site * sites;
    const double pixels = drawn_pixels(request, limits);
    const bool antialias = request.antialias || format.raster() == nullptr;
    return drawing_cost(format, raster_cost(request, sites, pixels, antialias), sites, pixels) +
           turns_cost(format, request.drawing, sites, largest_radius(request, sites));
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

/// Returns the maximum number of pixels. If the server chooses the width, it depends on the area, which is not known
/// yet for a polygon.
/// @param box  its sides must be positive and finite
double drawn_pixels(const SampleRequest& request, const Box& box, const Limits& limits) {
    const auto most = static_cast<double>(limits.max_pixels);
    if (request.width) return std::min(*request.width * (*request.width * box.height() / box.width() + 1), most);
    const double chosen = std::holds_alternative<PolygonInput>(request.domain)
                              ? kMaxCanvasPixels
                              : std::max(kMinDrawingSide * kMinDrawingSide,
                                         static_cast<double>(request.run.sites) * kPixelPitch * kPixelPitch);
    return std::min({chosen, kMaxCanvasPixels, most});
}

/// Estimates the ordering of points. Returns nothing for a path in a drawing of shapes, because the estimate of writing
/// includes this path.
Estimate ordering_cost(const SampleRequest& request) {
    constexpr Estimate kPath{500, 3.5 * kMicrosecond}, kProgressive{290, 6 * kMicrosecond};
    const PointOrder order = request.order.value_or(PointOrder::None);
    if (order == PointOrder::None) return {};
    return (order == PointOrder::Path ? kPath : kProgressive) * static_cast<double>(request.run.sites);
}

Estimate writing_cost(const SampleRequest& request, const Limits& limits) {
    const PointFormat& format = *request.format;
    const auto sites = static_cast<double>(request.run.sites);
    const Box box = bounds_of(request.domain);
    // If the box has no area or is infinite, the domain is rejected and nothing is written.
    const auto is_length = [](double side) { return side > 0 && std::isfinite(side); };
    if (!is_length(box.width()) || !is_length(box.height())) return {};
    if (format.raster() == nullptr) {
        const double unit = request.drawing.width_mm.value_or(1) / box.width();
        const double radius = request.dot.value_or(std::sqrt(box.width() * box.height() / sites) / 4);
        return format.per_site * sites + turns_cost(format, request.drawing, sites, unit * radius);
    }
    const double pixels = drawn_pixels(request, box, limits);
    const double scale = request.width ? *request.width / box.width() : std::sqrt(pixels / box.width() / box.height());
    const auto radius = request.dot ? std::optional(*request.dot * scale) : std::nullopt;
    return drawing_cost(format, raster_cost(sites, pixels, radius, true), sites, pixels);
}

std::size_t bytes_of(const PolygonInput& polygon) {
    return polygon.corner_count() * sizeof(Point);
}

std::size_t bytes_of(const FeatureList& features) {
    std::size_t size = features.first_part.size() * sizeof(std::size_t);
    for (const std::string& id : features.ids) size += sizeof(std::string) + id.size();
    for (const auto& values : features.carried.of_feature) {
        size += sizeof(values);
        for (const auto& each : values) size += sizeof(each) + each.value.size();
    }
    return size;
}

std::size_t bytes_of(const ImageFile& file) {
    return file.decoded ? file.decoded->size() : 0;
}

}  // namespace

Cost cost_of(const HalftoneRequest& request, const Limits& limits) {
    const double sites = max_dots(request, limits);
    const Estimate read =
        then(decoding_cost(request) + levels_cost(request) + cropping_cost(request), sharpening_cost(request, sites));
    const Estimate placed =
        density_cost(request, sites) + placing_cost(request, sites) + dot_sizes_cost(request, sites);
    Cost all = cost(then(then(read, placed), writing_cost(request, sites, limits)));
    all.answer = request.sites.value_or(0) * request.format->least;
    return all;
}

std::size_t usual_sites(const HalftoneRequest& request, PictureSize part, double ink, double fineness,
                        const Limits& limits) {
    constexpr double kMaxSeconds = 2, kFewest = 4096, kMany = 1e6;
    // Time per dot for a thin picture, relative to other pictures. The mesh of a thin picture is mostly border.
    constexpr double kThin = 4;
    const double in_time = kMaxSeconds / placing_cost(request, kMany).seconds * kMany;
    const auto max_dots_in = [&](double dots) {
        const auto most = static_cast<std::size_t>(std::max(dots, kFewest));
        const std::size_t limit = std::min(most, limits.max_sites);
        if (!request.on_screen) return default_sites(ink, fineness, limit);
        const Canvas canvas = *settled_canvas(request, part, limits);
        return sites_of_drawing(ink, fineness, canvas.scale, static_cast<double>(canvas.width) * canvas.height, limit);
    };
    const std::size_t usual = max_dots_in(in_time);
    return is_thin(request, usual) ? std::min(usual, max_dots_in(in_time / kThin)) : usual;
}

Cost cost_of(const SampleRequest& request, const Limits& limits) {
    if (request.mask_format != nullptr) return cost(cost_of_mask(request));
    const auto* image = std::get_if<DensityImage>(&request.density);
    const auto* grid = std::get_if<DensityGrid>(&request.density);
    Estimate density;
    if (image != nullptr) density = density_cost(static_cast<double>(image->file.header.pixels()));
    if (grid != nullptr) density = density_cost(static_cast<double>(grid->values.size()));
    const bool is_uniform = image == nullptr && grid == nullptr && request.coordinates == Coordinates::Plane;
    const Estimate placing = domain_cost(request) + charts_cost(request) + dot_map_cost(request) + density +
                             request.method->cost(request.run, is_uniform) + long_waves_cost(request);
    const Estimate made =
        then(then(placing, ordering_cost(request)), features_cost(request) + writing_cost(request, limits));
    const Estimate read = image != nullptr ? decoding_cost(image->file) : Estimate{};
    Cost all = cost(then(request.mask ? then(decoding_cost(*request.mask), read) : read, made));
    all.answer = request.run.sites * request.format->least;
    return all;
}

Cost cost_of(const AnalyzeRequest& request) {
    const auto sets = static_cast<double>(request.sets.size());
    const double points = request.sets.empty() ? 0 : static_cast<double>(request.sets.front().size());
    const double cells = points * request.options.max_frequency * request.options.max_frequency;
    const bool in_parts = cells * 16 > static_cast<double>(kMaxCells);
    constexpr double kParts = 600e6, kSpectrum = 40;
    const Estimate transforms{in_parts ? kParts + cells * kSpectrum : cells * 360,
                              cells * sets * (in_parts ? 0.7 : 0.4) * kMicrosecond};
    const Estimate others{points * sets * 64, points * sets * kMicrosecond};
    return cost(transforms + others + request.format->cost);
}

Cost cost_of_parsing(std::string_view body) {
    const auto count = [body](char c) { return static_cast<double>(std::ranges::count(body, c)); };
    // Upper bounds: each value except the first follows one of these characters, and each text is between two quotes.
    const double values = 1 + count(',') + count(':') + count('[') + count('{');
    const double quotes = count('"');
    const auto size = static_cast<double>(body.size());
    // Rings of TopoJSON may use the same arcs many times.
    const double corners = body.find("\"Topology\"") == std::string_view::npos ? 0 : PolygonInput::kMaxCorners;
    return cost({corners * 2 * sizeof(Point) + size * 2 +
                     std::min(values, static_cast<double>(JsonDocument::kMaxValues)) * 64 + quotes / 2 * 96,
                 size * 0.02 * kMicrosecond});
}

std::size_t size_of(const HalftoneRequest& request) {
    return bytes_of(request.image);
}

std::size_t size_of(const SampleRequest& request) {
    std::size_t size = bytes_of(request.avoid) + request.run.fixed.size() * sizeof(Point);
    if (const auto* polygon = std::get_if<PolygonInput>(&request.domain)) size += bytes_of(*polygon);
    if (request.features) size += bytes_of(*request.features);
    if (request.counts) size += request.counts->counts.size() * sizeof(std::size_t);
    if (const auto* grid = std::get_if<DensityGrid>(&request.density)) size += grid->values.size() * sizeof(double);
    if (const auto* image = std::get_if<DensityImage>(&request.density)) size += bytes_of(image->file);
    if (request.mask) size += bytes_of(*request.mask);
    return size;
}

std::size_t size_of(const AnalyzeRequest& request) {
    std::size_t points = 0;
    for (const auto& set : request.sets) points += set.size();
    return points * sizeof(Point);
}

}  // namespace ccdt::api
