// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/formats.h"

#include <algorithm>
#include <limits>

#include "api/image/jpeg_writer.h"
#include "api/image/png_writer.h"
#include "api/image/tiff_writer.h"
#include "api/image/webp_writer.h"
#include "api/input/file_formats.h"
#include "api/output/cairo_drawing.h"
#include "api/output/dot_tiles.h"
#include "api/output/eps_drawing.h"
#include "api/output/plotter_files.h"
#include "api/output/point_table.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kMinTextBytes = 5;  ///< minimum number of bytes of a site: `1,2` and the end of the line

/// Minimum number of bytes of a site that has its own Feature.
constexpr std::size_t kMinFeatureBytes =
    std::string_view(R"({"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[0,0]}})").size();

constexpr int kJpegQuality = 90;
constexpr int kAnySide = std::numeric_limits<int>::max();

constexpr Estimate kNumbersCost{150, 0.3 * kMicrosecond};   ///< cost of a site, as text or in binary
constexpr Estimate kFeaturesCost{400, 0.5 * kMicrosecond};  ///< cost of a site with its own Feature
constexpr Estimate kTilesCost{250, 4 * kMicrosecond};       ///< cost of a site, in tiles of all zooms
constexpr Estimate kLossyCost{6, 0.02 * kMicrosecond};      ///< cost of a pixel in libjpeg
constexpr Estimate kColoursCost{16, 0.1 * kMicrosecond};    ///< cost of a pixel in libwebp

void list_csv(const PointSet& points, const Report&, Body& body, const std::stop_token& stop) {
    write_csv(points, body, stop);
}

void list_tiles(const PointSet& points, const Report&, Body& body, const std::stop_token& stop) {
    write_dot_tiles(points, body, stop);
}

void list_npy(const PointSet& points, const Report&, Body& body, const std::stop_token& stop) {
    write_npy(points, body, stop);
}

/// Writes the strokes of dots in the language of a plotter.
template <void (&write)(const Plot&, Body&, const std::stop_token&)>
void plot_points(const PointSet& points, const Palette&, const Page& page, const DrawingOptions& drawing, Body& body,
                 const std::stop_token& path_stop, const std::stop_token& stop) {
    const Plot plot = plot_of(points, page, drawing, path_stop, stop);
    body.set_plot(plot.size());
    write(plot, body, stop);
}

/// Writes a picture whose only option is its width.
template <Result<std::string> (&write)(const DotImage&, std::optional<double>, const std::stop_token&)>
Result<std::string> write_pixels(const DotImage& image, const DrawingOptions& drawing, const std::stop_token& stop) {
    return write(image, drawing.width_mm, stop);
}

Result<std::string> write_lossy(const DotImage& image, const DrawingOptions& drawing, const std::stop_token& stop) {
    return write_jpeg(image, drawing.jpeg_quality.value_or(kJpegQuality), drawing.width_mm, stop);
}

constexpr PointFormat kPngPoints{kPng, 0, {}, {}, RasterWriter{kAnySide, false, write_pixels<write_png>, nullptr}};
constexpr PointFormat kJpegPoints{{"jpeg", "JPEG", "jpg", "image/jpeg", ""},
                                  0,
                                  {},
                                  kLossyCost,
                                  RasterWriter{kMaxJpegSide, false, write_lossy, nullptr, false}};
constexpr PointFormat kTiffPoints{{"tiff", "TIFF", "tiff", "image/tiff", ""},
                                  0,
                                  {},
                                  {},
                                  RasterWriter{kAnySide, true, write_pixels<write_tiff>, write_tiff_plates}};
constexpr PointFormat kWebPPoints{{"webp", "WebP", "webp", "image/webp", ""},
                                  0,
                                  {},
                                  kColoursCost,
                                  RasterWriter{kMaxWebPSide, false, write_pixels<write_webp>, nullptr}};
constexpr PointFormat kSvgPoints{kSvg, 0, kPathCost, {}, VectorWriter{write_svg, {24, 0.3 * kMicrosecond}}};
constexpr PointFormat kPdfPoints{{"pdf", "PDF", "pdf", "application/pdf", ""},
                                 0,
                                 kPathCost,
                                 {},
                                 VectorWriter{write_pdf, {40, 0.3 * kMicrosecond}, true}};
constexpr PointFormat kEpsPoints{{"eps", "EPS", "eps", "application/postscript", ""},
                                 0,
                                 kPathCost,
                                 {},
                                 VectorWriter{write_eps, {26, 0.3 * kMicrosecond}, true}};
constexpr PointFormat kHpglPoints{{"hpgl", "HPGL", "plt", "application/vnd.hp-hpgl", ""},
                                  0,
                                  kPathCost,
                                  {},
                                  VectorWriter{plot_points<write_hpgl>, {18, 0.2 * kMicrosecond}, true, true}};
// G-code has no registered media type.
constexpr PointFormat kGcodePoints{{"gcode", "G-code", "gcode", "text/x-gcode", ""},
                                   0,
                                   kPathCost,
                                   {},
                                   VectorWriter{plot_points<write_gcode>, {32, 0.3 * kMicrosecond}, true, true}};
constexpr PointFormat kDxfPoints{{"dxf", "DXF", "dxf", "image/vnd.dxf", ""},
                                 0,
                                 kPathCost,
                                 {},
                                 VectorWriter{plot_points<write_dxf>, {80, 0.3 * kMicrosecond}, true, true}};
constexpr PointFormat kJsonPoints{kJson, kMinTextBytes, kNumbersCost, {}, ListWriter{false, write_json, true}};
constexpr PointFormat kGeoJsonSinglePoints{
    kGeoJson, kMinFeatureBytes, kFeaturesCost, {}, ListWriter{true, write_point_features}, true};
constexpr PointFormat kGeoJsonPoints{kGeoJson, kMinTextBytes,        kNumbersCost, {}, ListWriter{true, write_geojson},
                                     false,    &kGeoJsonSinglePoints};
constexpr PointFormat kJsonLines{
    kGeoJsonLines, kMinFeatureBytes, kFeaturesCost, {}, ListWriter{true, write_point_lines}, true};
constexpr PointFormat kJsonSequence{
    kGeoJsonSequence, kMinFeatureBytes, kFeaturesCost, {}, ListWriter{true, write_point_sequence}, true};
constexpr PointFormat kCsvPoints{kCsv, kMinTextBytes, kNumbersCost, {}, ListWriter{true, list_csv}, true};
// The media type is the usual one, but not registered.
constexpr PointFormat kTilesOfPoints{{"pmtiles", "PMTiles, vector tiles", "pmtiles", "application/vnd.pmtiles", ""},
                                     1,
                                     kTilesCost,
                                     {},
                                     ListWriter{true, list_tiles, false, true}};
constexpr PointFormat kNpyPoints{kNpy, 2 * sizeof(double), kNumbersCost, {}, ListWriter{true, list_npy}};

constexpr const PointFormat* kHalftoneFormats[] = {&kPngPoints,  &kJsonPoints,  &kSvgPoints,  &kCsvPoints, &kNpyPoints,
                                                   &kWebPPoints, &kJpegPoints,  &kTiffPoints, &kPdfPoints, &kEpsPoints,
                                                   &kHpglPoints, &kGcodePoints, &kDxfPoints};
constexpr const PointFormat* kSampleFormats[] = {
    &kJsonPoints, &kCsvPoints, &kGeoJsonPoints, &kJsonLines,  &kJsonSequence, &kNpyPoints, &kSvgPoints,    &kPngPoints,
    &kJpegPoints, &kPdfPoints, &kEpsPoints,     &kHpglPoints, &kGcodePoints,  &kDxfPoints, &kTilesOfPoints};

}  // namespace

bool PointFormat::repeats() const {
    const auto* list = std::get_if<ListWriter>(&writer);
    return list == nullptr || list->repeats;
}

Result<void> VectorWriter::check(const DrawingOptions& drawing, double radius, const Page& page,
                                 const std::string& pen_field, const std::string& width_field) const {
    auto fills = check_pen(drawing, radius, page, pen_field);
    return fills && in_millimetres ? check_sides(page, width_field) : fills;
}

Result<void> PointFormat::check_kind(const DrawingOptions& drawing) const {
    const auto fault = [](std::string_view option, const char* message) {
        return failure(ErrorCode::Malformed, std::string(option) + message, std::string(option));
    };
    constexpr const char* kShapes = " is an option of drawings of shapes only, such as svg and pdf";
    if (raster() != nullptr && drawing.paper) return fault("paper", kShapes);
    if (vector() == nullptr && drawing.is_split) return fault("split", kShapes);
    if (raster() == nullptr && drawing.dpi)
        return fault("dpi", " is an option of drawings of pixels only, such as png");
    if (drawing.jpeg_quality && file.media_type != "image/jpeg")
        return fault("jpeg_quality", " is an option of jpeg only");
    return {};
}

Result<void> PointFormat::check_drawing(const DrawingOptions& drawing) const {
    const std::string field = "width_mm";
    if (vector() == nullptr || drawing.has_width()) return {};
    const std::string what = "width_mm (the width of the drawing in millimetres) or paper is missing; ";
    if (vector()->in_millimetres)
        return failure(ErrorCode::Malformed, what + "format=" + std::string(file.name) + " needs one of them", field);
    if (drawing.has_pen_width())
        return failure(ErrorCode::Malformed,
                       what + "style=" + std::string(name_of(drawing.style)) + " needs one of them", field);
    return {};
}

Result<void> PointFormat::check_side(const Canvas& canvas, const std::string& option, const std::string& field) const {
    const RasterWriter* const pixels = raster();
    if (pixels == nullptr || std::max(canvas.width, canvas.height) <= pixels->max_side) return {};
    return failure(ErrorCode::LimitExceeded,
                   "the output would have " + std::to_string(canvas.width) + " x " + std::to_string(canvas.height) +
                       " pixels; a side of a " + std::string(file.title) + " file has at most " +
                       std::to_string(pixels->max_side) + ": choose a smaller " + option + " or another format",
                   field);
}

std::span<const PointFormat* const> halftone_formats() {
    return kHalftoneFormats;
}

std::span<const PointFormat* const> sample_formats() {
    return kSampleFormats;
}

}  // namespace ccdt::api
