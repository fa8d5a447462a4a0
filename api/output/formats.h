// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <variant>

#include "api/image/overlay.h"
#include "api/input/drawing_options.h"
#include "api/input/file_formats.h"
#include "api/input/palette.h"
#include "api/output/ink_dots.h"
#include "api/output/json_writer.h"
#include "api/output/map_dots.h"
#include "api/output/plot.h"
#include "api/output/point_drawing.h"
#include "api/run/estimate.h"
#include "core/result.h"

namespace ccdt::api {

/// Writer of points as numbers. Stopped, it ends early, with nothing of use.
struct ListWriter {
    bool repeats;  ///< the same bytes each time; not so if it tells how long computing took
    void (&write)(std::span<const InkDots> inks, const Report& report, Body& body, const std::stop_token& stop);
    void (&write_map)(const MapOfDots& map, const Report& report, Body& body, const std::stop_token& stop);
};

/// Writer of drawings as shapes; its parameters are those of write_svg() and write_map_svg().
struct VectorWriter {
    void (&write)(std::span<const InkDots> inks, const Palette& palette, const Page& page,
                  const DrawingOptions& drawing, Body& body, const std::stop_token& hurry, const std::stop_token& stop);
    void (&write_map)(const MapOfDots& map, const Palette& palette, const Page& page, const DrawingOptions& drawing,
                      Body& body, const std::stop_token& hurry, const std::stop_token& stop);
    Estimate per_turn_point;  ///< of a point of the circles or the spiral that fill a dot

    bool in_millimetres = false;  ///< its pages have a width in millimetres
    bool by_pen = false;          ///< a pen draws, which can only add ink

    /// Checks that the pen and the page suit the dots, as check_pen() and check_sides() do.
    /// @param request  has `drawing` and `field_of(option)`
    /// @param radius   of the largest dots, in the points' units
    /// Errors: Unusable.
    template <class Request>
    Result<void> check(const Request& request, double radius, const Page& page) const {
        auto fills = check_pen(request.drawing, radius, page, request.field_of("pen"));
        if (!fills || !in_millimetres) return fills;
        return check_sides(page, request.field_of("width_mm"));
    }
};

/// Writer of drawings as pixels. Errors: Stopped; Internal if memory runs out.
struct RasterWriter {
    int max_side;       ///< pixels
    bool is_for_print;  ///< drawings are for printers unless a request says otherwise; else for screens
    Result<std::string> (&write)(const DotImage& image, std::optional<double> width_mm, const std::stop_token& stop);

    /// Writes inks that multiply apart from each other, as they are printed; null: the format holds but what is seen.
    Result<std::string> (*write_plates)(std::span<const Raster> plates, std::span<const Ink> inks,
                                        std::optional<double> width_mm, const std::stop_token& stop);
};

/// Format that points are answered in: a row of the table in formats.cpp. Writers are references, lest a row without
/// one compile.
struct PointFormat {
    FileFormat file;
    std::size_t least;   ///< bytes that a site has at least
    Estimate per_site;   ///< of writing
    Estimate per_pixel;  ///< of writing, besides the raster
    std::variant<ListWriter, VectorWriter, RasterWriter> writer;

    bool repeats_properties = false;  ///< of a feature, for each of its points

    /// The same with a GeoJSON Feature for each point; null: there is none, or each has one already.
    const PointFormat* single_points = nullptr;

    bool is_drawn() const { return !std::holds_alternative<ListWriter>(writer); }
    const RasterWriter* raster() const { return std::get_if<RasterWriter>(&writer); }
    const VectorWriter* vector() const { return std::get_if<VectorWriter>(&writer); }

    /// Tells whether the same request gets the same bytes each time.
    bool repeats() const;

    /// Checks that a drawing has a width in millimetres if its format or its style needs one.
    /// @param field  of that option
    /// Errors: Malformed.
    Result<void> check_drawing(const DrawingOptions& drawing, const std::string& field) const;

    /// Checks the size of a canvas, which `option` makes smaller.
    /// Errors: LimitExceeded for one that is larger than what the format holds.
    Result<void> check_side(const Canvas& canvas, const std::string& option, const std::string& field) const;
};

/// Formats of /halftone and /sample, in the server's order of preference.
std::span<const PointFormat* const> halftone_formats();
std::span<const PointFormat* const> sample_formats();

}  // namespace ccdt::api
