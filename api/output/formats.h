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
#include "api/output/archive.h"
#include "api/output/json_writer.h"
#include "api/output/plot.h"
#include "api/output/point_drawing.h"
#include "api/output/point_set.h"
#include "api/run/estimate.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Cost of writing a site, including the search for a short path.
inline constexpr Estimate kPathCost{360, 3.5 * kMicrosecond};

/// Writer of points as numbers. After a stop, the output is incomplete.
struct ListWriter {
    /// Whether the same points always give the same bytes. False if the output contains the computing time.
    bool repeats;
    void (&write)(const PointSet& points, const Report& report, Body& body, const std::stop_token& stop);
    bool has_areas = false;  ///< whether the list has InkDots::areas
    bool is_tiled = false;   ///< whether points must be degrees with ranks: see write_dot_tiles()
};

/// Writer of drawings as shapes. `write` has the parameters of write_svg().
struct VectorWriter {
    void (&write)(const PointSet& points, const Palette& palette, const Page& page, const DrawingOptions& drawing,
                  Body& body, const std::stop_token& path_stop, const std::stop_token& stop);
    Estimate per_turn_point;  ///< cost of writing a point of the circles or of the spiral that fill a dot

    bool in_millimetres = false;  ///< whether pages must have a width in millimetres
    bool by_pen = false;          ///< whether drawings are made by pens, which can only add ink

    /// Checks the pen with check_pen(), and a page in millimetres with check_sides().
    /// @param radius  radius of the largest dots, in the units of the points
    /// @param pen_field, width_field  Error::field of errors about the options pen and width_mm
    /// Errors: Unusable.
    Result<void> check(const DrawingOptions& drawing, double radius, const Page& page, const std::string& pen_field,
                       const std::string& width_field) const;
};

/// Writer of drawings as pixels. Errors: Stopped; Internal if memory runs out.
struct RasterWriter {
    int max_side;       ///< maximum length of a side, in pixels
    bool is_for_print;  ///< whether drawings are by default for printers instead of screens
    Result<std::string> (&write)(const DotImage& image, const DrawingOptions& drawing, const std::stop_token& stop);

    /// Writes a printing plate for each ink, if the inks have the mixing Multiply. Null: the format stores only the
    /// visible colours.
    Result<std::string> (*write_plates)(std::span<const Raster> plates, std::span<const Ink> inks,
                                        std::optional<double> width_mm, const std::stop_token& stop);

    bool has_alpha = true;  ///< whether paper can be transparent; if not, transparent paper is white
};

/// Format of an answer with points: a row of the table in formats.cpp. Functions are references, so that a row without
/// a function does not compile.
struct PointFormat {
    FileFormat file;
    std::size_t least;   ///< minimum number of bytes that a site takes in the output
    Estimate per_site;   ///< cost of writing a site
    Estimate per_pixel;  ///< cost of writing a pixel, in addition to the cost of the raster
    std::variant<ListWriter, VectorWriter, RasterWriter> writer;

    bool repeats_properties = false;  ///< whether each point repeats its feature's properties

    /// Variant of this GeoJSON format that writes a Feature for each point. Null: there is no such variant, or this
    /// format itself writes a Feature for each point.
    const PointFormat* single_points = nullptr;

    bool is_drawn() const { return !std::holds_alternative<ListWriter>(writer); }
    bool is_tiled() const {
        const auto* list = std::get_if<ListWriter>(&writer);
        return list != nullptr && list->is_tiled;
    }
    const RasterWriter* raster() const { return std::get_if<RasterWriter>(&writer); }
    const VectorWriter* vector() const { return std::get_if<VectorWriter>(&writer); }

    /// Returns the media type of an answer, which may be an archive of several files.
    std::string media_type(const DrawingOptions& drawing) const {
        return vector() != nullptr && drawing.is_split ? std::string(kZipType) : file.content_type();
    }

    /// Whether the same request always gets the same bytes.
    bool repeats() const;

    /// Checks that a request for this format has no options of other kinds of formats: of paper, pixels and files, and
    /// of JPEG. Errors: Malformed; Error::field is the name of an option.
    Result<void> check_kind(const DrawingOptions& drawing) const;

    /// Checks that a drawing has a width in millimetres if its format or its style needs one.
    /// Errors: Malformed; Error::field is the name of the option width_mm.
    Result<void> check_drawing(const DrawingOptions& drawing) const;

    /// Checks the size of a canvas. The error message recommends a smaller value of `option`.
    /// @param field  Error::field of the error
    /// Errors: LimitExceeded if a side is longer than the format allows.
    Result<void> check_side(const Canvas& canvas, const std::string& option, const std::string& field) const;
};

/// Returns the formats of an endpoint, in the server's order of preference.
std::span<const PointFormat* const> halftone_formats();
std::span<const PointFormat* const> sample_formats();

}  // namespace ccdt::api
