// SPDX-License-Identifier: GPL-3.0-or-later
// The functions of api that need compiled libraries, none of which the module has. module.cpp refuses the formats of
// their writers.
#include "api/image/colour_tags.h"
#include "api/image/jpeg_writer.h"
#include "api/image/png_writer.h"
#include "api/image/tiff_writer.h"
#include "api/image/webp_writer.h"
#include "api/output/cairo_drawing.h"
#include "api/output/dot_tiles.h"
#include "api/output/letters.h"
#include "api/output/svg_renderer.h"

namespace ccdt::api {
Result<std::string> write_png(const DotImage& /*image*/, std::optional<double> /*width_mm*/,
                              const std::stop_token& /*stop*/) {
    __builtin_trap();
}

Result<std::string> write_greys(std::span<const std::uint16_t> /*greys*/, int /*width*/, int /*height*/, int /*bits*/,
                                const std::stop_token& /*stop*/) {
    __builtin_trap();
}

Result<std::string> write_jpeg(const DotImage& /*image*/, int /*quality*/, std::optional<double> /*width_mm*/,
                               const std::stop_token& /*stop*/) {
    __builtin_trap();
}

Result<std::string> write_tiff(const DotImage& /*image*/, std::optional<double> /*width_mm*/,
                               const std::stop_token& /*stop*/) {
    __builtin_trap();
}

Result<std::string> write_tiff_plates(std::span<const Raster> /*plates*/, std::span<const Ink> /*inks*/,
                                      std::optional<double> /*width_mm*/, const std::stop_token& /*stop*/) {
    __builtin_trap();
}

Result<std::string> write_webp(const DotImage& /*image*/, std::optional<double> /*width_mm*/,
                               const std::stop_token& /*stop*/) {
    __builtin_trap();
}

Result<std::string> render_svg(std::string_view /*svg*/, double /*scale*/) {
    __builtin_trap();
}

bool can_letter() {
    return false;
}

std::vector<Ring> letters(std::string_view /*text*/, double /*size*/) {
    return {};
}

Result<DotImage> picture_of_map(const PointSet& /*points*/, const Palette& /*palette*/, const Page& /*page*/,
                                const std::stop_token& /*stop*/) {
    __builtin_trap();
}

void write_pdf(const PointSet& /*points*/, const Palette& /*palette*/, const Page& /*page*/,
               const DrawingOptions& /*drawing*/, Body& /*body*/, const std::stop_token& /*path_stop*/,
               const std::stop_token& /*stop*/) {
    __builtin_trap();
}

void write_dot_tiles(const PointSet& /*points*/, Body& /*body*/, const std::stop_token& /*stop*/) {
    __builtin_trap();
}

bool may_have_profile(std::string_view /*bytes*/, ImageFormat /*format*/) {
    return false;
}

}  // namespace ccdt::api
