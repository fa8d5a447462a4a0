// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/halftone/halftone_cost.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "api/halftone/drawing_size.h"
#include "api/input/method.h"
#include "api/output/plot.h"
#include "api/output/stage_costs.h"
#include "api/run/estimate.h"
#include "core/base/elementary.h"
#include "core/geometry/hexagonal_spacing.h"
#include "core/halftone/dots/dots.h"
#include "core/halftone/field/dot_plan.h"
#include "core/halftone/field/field_drawing.h"
#include "core/halftone/field/field_plan.h"
#include "core/picture/reduction.h"
#include "core/picture/tone.h"

namespace ccdt::api {
namespace {

/// Estimates the cost of applying levels, which creates a second picture of the decoded size.
Estimate levels_cost(const HalftoneRequest& request) {
    if (request.levels == Levels{}) return {};
    constexpr double kTime = 0.006 * kMicrosecond;
    const double planes = request.palette.mixing == Mixing::Cover ? 1 : 3;
    const auto values = static_cast<double>(request.image.header.pixels()) * planes;
    return {values * sizeof(float), values * kTime};
}

/// Estimates the cost of cropping the picture, which creates a second picture of at most the decoded size.
Estimate cropping_cost(const HalftoneRequest& request) {
    if (request.fit != Fit::Cover) return {};
    constexpr double kTime = 0.002 * kMicrosecond;
    const double planes = request.palette.mixing == Mixing::Cover ? 2 : 4;
    const auto values = static_cast<double>(request.image.header.pixels()) * planes;
    return {values * sizeof(float), values * kTime};
}

/// Returns whether the request is for Dots::Both in several channels.
bool has_channels(const HalftoneRequest& request) {
    return request.dots == Dots::Both && request.palette.mixing != Mixing::Cover;
}

/// Returns the number of inks or, for Dots::Both, the number of channels, which is 3 for CMYK.
double inks_of(const HalftoneRequest& request) {
    const auto inks = static_cast<double>(request.palette.inks.size());
    return request.dots == Dots::Both && is_cmyk(request.palette.inks) ? inks - 1 : inks;
}

/// Returns whether the request is for Dots::Both with several channels that are custom inks.
bool has_ink_channels(const HalftoneRequest& request) {
    return request.dots == Dots::Both && has_sets(request.palette);
}

/// Returns the number of channels of a field.
double channels_of(const HalftoneRequest& request) {
    if (!has_ink_channels(request)) return has_channels(request) ? 3 : 1;
    return std::min(elementary::exp2(inks_of(request)), static_cast<double>(kMaxInkSets)) - 1;
}

/// Returns the maximum number of cells in which a field is planned.
double planned_cells(const HalftoneRequest& request, double sites) {
    const ImageHeader& header = request.image.header;
    const auto pixels = static_cast<double>(header.pixels());
    if (request.fit == Fit::Cover || (request.dot && !request.sites)) {
        // Upper bound. There are about 50 cells per dot. Cells less than two pixels wide are replaced by pixels, of
        // which there are up to four times as many.
        constexpr double kCellsPerDot = 200, kMin = 64 * 64;
        return std::min(pixels, kCellsPerDot * sites + kMin);
    }
    const double radius = std::sqrt(kDrawnShare * pixels / (std::numbers::pi * std::max(sites, 1.0)));
    const CellGrid cells = resolved_cells(static_cast<int>(header.width), static_cast<int>(header.height), radius);
    return static_cast<double>(cells.columns) * cells.rows;
}

/// Estimates the cost of planning a field.
Estimate field_plan_cost(const HalftoneRequest& request, double sites) {
    constexpr Estimate kCell{12, 0}, kChannel{36, 0.12 * kMicrosecond}, kTables{8e6, 0.6};
    constexpr double kReading = 8;
    return (kCell + kChannel * channels_of(request)) * planned_cells(request, sites) +
           (has_ink_channels(request) ? kTables : Estimate{}) +
           Estimate{kReading, 0} * static_cast<double>(request.image.header.pixels());
}

/// Estimates the cost of fitting a field to a drawing, and of drawing it.
/// @param pixels  of the drawing; 0: there are only outlines
Estimate field_cost(const HalftoneRequest& request, double sites, double pixels) {
    constexpr Estimate kBuffers{5e6, 0}, kFit{52, 0.05 * kMicrosecond}, kFitOfChannel{8, 0.2 * kMicrosecond};
    constexpr Estimate kDrawn{6, 0.2 * kMicrosecond}, kDrawnChannel{2, 0.05 * kMicrosecond},
        kSite{400, 4 * kMicrosecond};
    const double cells = std::max(sites * kPixelsOfPitch * kPixelsOfPitch, planned_cells(request, sites));
    const double fitted = pixels > 0 ? std::min(pixels, cells) : cells;
    const double channels = channels_of(request);
    return kBuffers + (kFit + kFitOfChannel * channels) * fitted + (kDrawn + kDrawnChannel * channels) * pixels +
           kSite * sites;
}

/// Estimates the cost of sharpening the coverage, one ink at a time, or of planning a field.
Estimate sharpening_cost(const HalftoneRequest& request, double sites) {
    if (request.dots == Dots::Both) return field_plan_cost(request, sites);
    if (!(request.detail > 0)) return {};
    constexpr double kTime = 0.05 * kMicrosecond;
    const auto pixels = static_cast<double>(request.image.header.pixels());
    return {pixels * (inks_of(request) * 8 + 20), pixels * inks_of(request) * kTime};
}

/// Estimates the cost of decoding and separation. If inks mix, memory holds planes of red, green, blue and alpha, three
/// planes of light, and the coverage of each ink.
Estimate decoding_cost(const HalftoneRequest& request) {
    if (request.palette.mixing == Mixing::Cover) return decoding_cost(request.image);
    constexpr double kSeparating = 0.2 * kMicrosecond;
    if (has_channels(request) && !has_ink_channels(request))
        return decoding_cost(request.image, 28 + 4 * inks_of(request));
    // For a picture that has all colours, filling the table of separations takes as long as separating kTable * inks^2
    // pixels.
    constexpr double kTable = 60'000;
    const auto pixels = static_cast<double>(request.image.header.pixels());
    return decoding_cost(request.image, 28 + 4 * inks_of(request)) +
           Estimate{0, (pixels + kTable * inks_of(request) * inks_of(request)) * kSeparating};
}

/// Estimates the cost of the density grids: one for each ink and, if there are several, one for their sum.
Estimate densities_cost(const HalftoneRequest& request, double sites) {
    const auto pixels = static_cast<double>(request.image.header.pixels());
    if (request.dots == Dots::Both) {
        constexpr Estimate kPlanned{20, 0};  // of the plan's channels, which are kept until the field is drawn
        const double cells = planned_cells(request, sites);
        return density_cost(cells) + kPlanned * (channels_of(request) * cells);
    }
    const double inks = inks_of(request);
    return density_cost(pixels * (inks > 1 ? inks * 1.2 + 1 : 1));
}

/// Estimates the cost of the polishing steps that only several inks need: pushes between dots of different inks, and
/// the comparison of the simulated print with the picture.
Estimate ink_polish_cost(const HalftoneRequest& request, const Options& options) {
    if (inks_of(request) < 2 || request.dots == Dots::Both || options.quality == Quality::Draft ||
        options.iterations == 0)
        return {};
    const auto sites = static_cast<double>(options.sites);
    return {sites * 750, sites * (options.quality == Quality::Best ? 36 : 12) * kMicrosecond};
}

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

/// Returns the maximum number of dots. If the number follows from the radius, the maximum is the number for a picture
/// of solid ink. Dots overlap in such a picture; their total area is twice the area of the picture.
double max_dots(const HalftoneRequest& request, const Limits& limits) {
    if (request.sites) return static_cast<double>(*request.sites);
    const double inks = request.dots == Dots::Both ? 1 : inks_of(request);
    const double ink = static_cast<double>(request.image.header.pixels()) * inks;
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
        return filling(drawn_pixels(request, limits) * inks, radius);
    // If the server chooses the number and the scale, dots have a radius below this limit, in output pixels.
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

/// Estimates the cost of supersampling small dots, which is done band by band. A scale that the server chooses makes
/// dots so large that they need no supersampling.
Estimate supersampling_cost(const HalftoneRequest& request, double sites, double pixels) {
    constexpr double kEach = 226;  // samples per dot, in a picture that is half covered
    const double samples = std::min(sites * kEach, kMaxSamples);
    const bool by_dots = !(request.on_screen || request.width || request.height || request.scale || request.dot);
    if (by_dots || samples < pixels) return {};
    return {sites * 16, samples * 0.02 * kMicrosecond};
}

/// Estimates the cost of drawing dots. The rasters of inks that mix are kept until they are combined.
Estimate rasters_cost(const HalftoneRequest& request, double sites, double pixels, bool antialias) {
    if (request.dots == Dots::Both) return field_cost(request, sites, request.format->raster() != nullptr ? pixels : 0);
    const Estimate one =
        raster_cost(sites, pixels, radius_of(request, pixels), antialias) + supersampling_cost(request, sites, pixels);
    if (request.palette.mixing == Mixing::Cover) return one;
    const double inks = inks_of(request);
    return one + Estimate{pixels * inks, pixels * inks * (antialias ? 0.08 : 0.02) * kMicrosecond};
}

/// Returns the maximum radius of dots in millimetres: the radius for a picture of solid ink. Dots overlap in such a
/// picture; their total area is twice the area of the picture.
double largest_radius(const HalftoneRequest& request, double sites) {
    if (request.dot && request.dot->millimetres) return request.dot->length;
    const double width = request.drawing.width_mm.value_or(1);
    const double height = width * longer_side(request) / shorter_side(request);
    return std::sqrt(2 * width * height / (std::numbers::pi * sites));
}

Estimate writing_cost(const HalftoneRequest& request, double sites, const Limits& limits) {
    const PointFormat& format = *request.format;
    if (!format.is_drawn()) {
        const bool has_areas = request.dots == Dots::Both && std::get<ListWriter>(format.writer).has_areas;
        return format.per_site * sites + (has_areas ? field_cost(request, sites, 0) : Estimate{});
    }
    const double pixels = drawn_pixels(request, limits);
    const bool antialias = request.antialias || format.raster() == nullptr;
    return drawing_cost(format, rasters_cost(request, sites, pixels, antialias), sites, pixels) +
           turns_cost(format, request.drawing, sites, largest_radius(request, sites));
}

}  // namespace

Cost cost_of(const HalftoneRequest& request, const Limits& limits) {
    const double sites = max_dots(request, limits);
    const Estimate read =
        then(decoding_cost(request) + levels_cost(request) + cropping_cost(request), sharpening_cost(request, sites));
    const Estimate densities = densities_cost(request, sites);
    const Estimate timed = request.minutes ? kPathCost * sites : Estimate{};  // the path that keeps to the time
    const Estimate written = then(timed, writing_cost(request, sites, limits));
    Cost all = total_cost(then(then(read, densities + placing_cost(request, sites)), written));
    all.before = read.seconds + densities.seconds;
    all.after = written.seconds;
    all.answer = request.sites.value_or(0) * request.format->least;
    return all;
}

std::size_t largest_answer(const HalftoneRequest& request, const Limits& limits) {
    const PointFormat& format = *request.format;
    const double sites = max_dots(request, limits);
    const double pixels = format.raster() == nullptr ? 0 : drawn_pixels(request, limits) * inks_of(request);
    const Estimate turns = turns_cost(format, request.drawing, sites, largest_radius(request, sites));
    return static_cast<std::size_t>(largest_answer(format, sites, pixels, turns, false));
}

std::size_t usual_sites(const HalftoneRequest& request, PictureSize part, double ink, double fineness,
                        const Limits& limits) {
    constexpr double kMaxSeconds = 2, kMin = 4096, kMany = 1e6;
    // Time per dot for a thin picture, relative to other pictures. The mesh of a thin picture is mostly border.
    constexpr double kThin = 4;
    const double in_time = kMaxSeconds / placing_cost(request, kMany).seconds * kMany;
    const auto max_dots_in = [&](double dots) {
        const auto most = static_cast<std::size_t>(std::max(dots, kMin));
        const std::size_t limit = std::min(most, limits.max_sites);
        if (!request.on_screen) return default_sites(ink, fineness, limit);
        const Canvas canvas = *settled_canvas(request, part, limits);
        const double radius = request.dots == Dots::Both ? kRadiusOfField : kRadiusOfDiscs;
        const double pixels = static_cast<double>(canvas.width) * canvas.height;
        return sites_of_drawing(ink, fineness, canvas.scale, pixels, radius, limit);
    };
    const std::size_t usual = max_dots_in(in_time);
    return is_thin(request, usual) ? std::min(usual, max_dots_in(in_time / kThin)) : usual;
}

std::size_t size_of(const HalftoneRequest& request) {
    return bytes_of(request.image);
}

}  // namespace ccdt::api
