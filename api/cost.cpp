#include "api/cost.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "api/json/json_document.h"
#include "core/baselines/ccvt.h"
#include "core/baselines/cvt.h"
#include "core/baselines/odt.h"
#include "core/halftone/tone.h"

namespace ccdt::api {
namespace {

constexpr double kMicrosecond = 1e-6;
constexpr double kFixedBytes = 6 << 20;

/// Of what is there at the same time.
struct Estimate {
    double bytes = 0;
    double seconds = 0;

    Estimate operator+(const Estimate& other) const { return {bytes + other.bytes, seconds + other.seconds}; }
};

/// One stage after the other, each giving its memory back.
Estimate then(const Estimate& a, const Estimate& b) {
    return {std::max(a.bytes, b.bytes), a.seconds + b.seconds};
}

Cost cost(const Estimate& estimate) {
    return {static_cast<std::size_t>(estimate.bytes + kFixedBytes), estimate.seconds};
}

/// Bytes a pixel: luminance, alpha, coverage and a copy turned over.
constexpr double kGreyPlanes = 16;

Estimate decoding(const ImageFile& file, double planes = kGreyPlanes) {
    constexpr double kTime = 0.03 * kMicrosecond;
    const auto pixels = static_cast<double>(file.header.pixels());
    const double decoder = static_cast<double>(file.header.decoder_bytes) + static_cast<double>(file.bytes.size());
    return {pixels * planes + decoder, pixels * kTime};
}

double inks_of(const HalftoneRequest& request) {
    return static_cast<double>(request.palette.inks.size());
}

/// Of inks that mix: four planes, and the coverage of each ink.
Estimate decoding(const HalftoneRequest& request) {
    if (request.palette.mixing == Mixing::Cover) return decoding(request.image);
    constexpr double kSeparating = 0.2 * kMicrosecond;
    constexpr double kTable = 300'000;  // takes as long as so many pixels
    const auto pixels = static_cast<double>(request.image.header.pixels());
    return decoding(request.image, 16 + 4 * inks_of(request)) + Estimate{0, (pixels + kTable) * kSeparating};
}

/// The triangulation, its passes and the polish.
Estimate triangulating(const Options& options, bool is_uniform) {
    const auto sites = static_cast<double>(options.sites);
    const bool polished = options.quality != Quality::Draft && options.iterations > 0;
    const double pass = is_uniform ? 0.06 : 0.22;
    double microseconds = 1 + pass * options.iterations * options.passes;
    if (polished && options.quality == Quality::Standard) microseconds += is_uniform ? 2.6 : 7;
    if (polished && options.quality == Quality::Best) microseconds += is_uniform ? 12.5 : 22;
    const double bytes = (is_uniform ? 450 : 700) + (polished ? 330 : 0) + (options.keep_mesh ? 150 : 0);
    return {sites * bytes, sites * microseconds * kMicrosecond};
}

Estimate distributing(Method method, const Options& options, bool is_uniform) {
    const auto sites = static_cast<double>(options.sites);
    const auto all = [&](double bytes, double microseconds_each) {
        return Estimate{sites * bytes, sites * microseconds_each * options.iterations * kMicrosecond};
    };
    switch (method) {
        case Method::Ccdt:
            return triangulating(options, is_uniform);
        case Method::Cvt:
            return all(1600, 560.0 / kCvtIterations);
        case Method::Odt:
            return all(400, 45.0 / kOdtIterations);
        case Method::Ccvt:
            return all(9500, 850.0 / kCcvtIterations);
        case Method::Random:
            return {sites * 290, sites * 2.5 * kMicrosecond};
    }
    return {};
}

Estimate bounding(const std::variant<PolygonInput, Rectangle>& domain) {
    constexpr double kBytes = 420;
    constexpr double kTime = 2.5 * kMicrosecond;
    const auto* polygon = std::get_if<PolygonInput>(&domain);
    if (polygon == nullptr) return {};
    const auto corners = static_cast<double>(polygon->corner_count());
    return {corners * kBytes, corners * kTime};
}

/// A grid's integrals, and the passes that walk over its cells.
Estimate weighing(double cells) {
    return {cells * 20, cells * 0.03 * kMicrosecond};
}

/// Of several inks there is one grid each, and one of all together.
Estimate weighing(const HalftoneRequest& request) {
    const auto pixels = static_cast<double>(request.image.header.pixels());
    const double inks = inks_of(request);
    return weighing(pixels * (inks > 1 ? inks * 1.2 + 1 : 1));
}

/// What keeps dots of different inks apart.
Estimate parting(const HalftoneRequest& request, const Options& options) {
    if (inks_of(request) < 2 || options.quality == Quality::Draft || options.iterations == 0) return {};
    const auto sites = static_cast<double>(options.sites);
    return {sites * 400, sites * (options.quality == Quality::Best ? 30 : 10) * kMicrosecond};
}

/// Pixels of the output at most: the chosen scale stops at 16 million.
double drawn_pixels(const HalftoneRequest& request, const Limits& limits) {
    const auto pixels = static_cast<double>(request.image.header.pixels());
    const auto most = static_cast<double>(limits.max_pixels);
    if (request.scale) return std::min(pixels * *request.scale * *request.scale, most);
    return std::min({pixels * kLargestScale * kLargestScale, kMostCanvasPixels, most});
}

/// Ordering dots along a short path, and writing them.
Estimate plotting(double sites) {
    return {sites * 500, sites * 3.5 * kMicrosecond};
}

/// @param radius  of the dots, in pixels; each may cover all
Estimate rasterising(double sites, double pixels, std::optional<double> radius, bool antialias) {
    const double covered = sites * std::min(pixels, radius ? 4 * *radius * *radius : 0);
    return {sites * 150 + pixels * 6, (pixels * (antialias ? 0.04 : 0.005) + covered * 0.001) * kMicrosecond};
}

/// The rasters of inks that mix stay until they are laid over each other.
Estimate rasterising(const HalftoneRequest& request, double sites, double pixels, bool antialias) {
    const Estimate one = rasterising(sites, pixels, request.dot, antialias);
    if (request.palette.mixing == Mixing::Cover) return one;
    const double inks = inks_of(request);
    return one + Estimate{pixels * inks, pixels * inks * (antialias ? 0.08 : 0.02) * kMicrosecond};
}

Estimate drawing(const HalftoneRequest& request, double sites, const Limits& limits) {
    const double pixels = drawn_pixels(request, limits);
    const auto raster = [&](bool antialias) { return rasterising(request, sites, pixels, antialias); };
    switch (request.format) {
        case HalftoneFormat::Png:
        case HalftoneFormat::Tiff:
            return raster(request.antialias);
        case HalftoneFormat::WebP:
            return raster(request.antialias) + Estimate{pixels * 16, pixels * 0.1 * kMicrosecond};
        case HalftoneFormat::Svg:
            return then(raster(true), plotting(sites));
        case HalftoneFormat::Json:
        case HalftoneFormat::Csv:
        case HalftoneFormat::Npy:
            break;
    }
    return {sites * 150, sites * 0.3 * kMicrosecond};
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

/// Pixels at most: a chosen width depends on the area, which of a polygon is not known yet.
/// @param box  of positive, finite sides
double drawn_pixels(const SampleRequest& request, const Box& box, const Limits& limits) {
    const auto most = static_cast<double>(limits.max_pixels);
    if (request.width) return std::min(*request.width * (*request.width * box.height() / box.width() + 1), most);
    const double chosen =
        std::holds_alternative<PolygonInput>(request.domain)
            ? kMostCanvasPixels
            : std::max(kLeastSide * kLeastSide, static_cast<double>(request.run.sites) * kPixelPitch * kPixelPitch);
    return std::min({chosen, kMostCanvasPixels, most});
}

Estimate drawing(const SampleRequest& request, const Limits& limits) {
    const auto sites = static_cast<double>(request.run.sites);
    if (request.format == SampleFormat::Svg) return plotting(sites);
    if (request.format != SampleFormat::Png) return {sites * 150, sites * 0.3 * kMicrosecond};
    const Box box = bounds_of(request.domain);
    // Of other boxes there is no domain, and nothing is drawn.
    const auto is_length = [](double side) { return side > 0 && std::isfinite(side); };
    if (!is_length(box.width()) || !is_length(box.height())) return {};
    const double pixels = drawn_pixels(request, box, limits);
    const double scale = request.width ? *request.width / box.width() : std::sqrt(pixels / box.width() / box.height());
    const auto radius = request.dot ? std::optional(*request.dot * scale) : std::nullopt;
    return rasterising(sites, pixels, radius, true);
}

std::size_t bytes_of(const PolygonInput& polygon) {
    return polygon.corner_count() * sizeof(Point);
}

std::size_t bytes_of(const ImageFile& file) {
    return file.decoded ? file.decoded->size() : 0;
}

}  // namespace

Cost cost_of(const HalftoneRequest& request, const Limits& limits) {
    const auto pixels = static_cast<double>(request.image.header.pixels());
    Options options = request.run;
    options.sites = request.sites.value_or(default_sites(pixels * inks_of(request), limits.max_sites));
    const Estimate placing = weighing(request) + triangulating(options, false) + parting(request, options);
    const Estimate drawn = drawing(request, static_cast<double>(options.sites), limits);
    return cost(then(then(decoding(request), placing), drawn));
}

Cost cost_of(const SampleRequest& request, const Limits& limits) {
    const auto* image = std::get_if<DensityImage>(&request.density);
    const auto* grid = std::get_if<DensityGrid>(&request.density);
    Estimate density;
    if (image != nullptr) density = weighing(static_cast<double>(image->file.header.pixels()));
    if (grid != nullptr) density = weighing(static_cast<double>(grid->values.size()));
    const bool is_uniform = image == nullptr && grid == nullptr;
    const Estimate placing = bounding(request.domain) + density + distributing(request.method, request.run, is_uniform);
    const Estimate made = then(placing, drawing(request, limits));
    return cost(image != nullptr ? then(decoding(image->file), made) : made);
}

Cost cost_of(const AnalyzeRequest& request) {
    const auto sets = static_cast<double>(request.sets.size());
    const double points = request.sets.empty() ? 0 : static_cast<double>(request.sets.front().size());
    const double cells = points * request.options.max_frequency * request.options.max_frequency;
    constexpr double kPlot = 32 << 20;
    const Estimate transforms{cells * 360, cells * sets * 0.4 * kMicrosecond};
    const Estimate others{points * sets * 64, points * sets * kMicrosecond};
    const Estimate plot{request.format == AnalyzeFormat::Json ? 0 : kPlot,
                        request.format == AnalyzeFormat::Png ? 0.1 : 0};
    return cost(transforms + others + plot);
}

Cost cost_of_parsing(std::string_view body) {
    const auto count = [body](char c) { return static_cast<double>(std::ranges::count(body, c)); };
    // Every value but the first follows one of these, and texts are between two quotes.
    const double values = 1 + count(',') + count(':') + count('[') + count('{');
    const double quotes = count('"');
    const auto size = static_cast<double>(body.size());
    return cost({size * 2 + std::min(values, static_cast<double>(JsonDocument::kMaxValues)) * 64 + quotes / 2 * 96,
                 size * 0.02 * kMicrosecond});
}

std::size_t size_of(const HalftoneRequest& request) {
    return bytes_of(request.image);
}

std::size_t size_of(const SampleRequest& request) {
    std::size_t size = 0;
    if (const auto* polygon = std::get_if<PolygonInput>(&request.domain)) size += bytes_of(*polygon);
    if (const auto* grid = std::get_if<DensityGrid>(&request.density)) size += grid->values.size() * sizeof(double);
    if (const auto* image = std::get_if<DensityImage>(&request.density)) size += bytes_of(image->file);
    return size;
}

std::size_t size_of(const AnalyzeRequest& request) {
    std::size_t points = 0;
    for (const auto& set : request.sets) points += set.size();
    return points * sizeof(Point);
}

}  // namespace ccdt::api
