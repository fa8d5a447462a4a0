#include "api/halftone_answer.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "api/image/overlay.h"
#include "api/image/png_writer.h"
#include "api/image/tiff_writer.h"
#include "api/image/webp_writer.h"
#include "api/input/run_options.h"
#include "api/json/json_writer.h"
#include "api/output/point_drawing.h"
#include "api/output/point_table.h"
#include "core/halftone/dots.h"

namespace ccdt::api {
namespace {

Result<std::string> write_raster(const HalftoneRequest& request, const DotImage& image, const std::stop_token& stop) {
    const auto width_mm = request.drawing.width_mm;
    if (request.format == HalftoneFormat::WebP) return write_webp(image, width_mm, stop);
    if (request.format == HalftoneFormat::Tiff) return write_tiff(image, width_mm, stop);
    return write_png(image, width_mm, stop);
}

/// @param inks  whose radii are found
Result<std::string> draw(const HalftoneRequest& request, const HalftonePlan& plan, std::vector<InkDots> inks,
                         const Control& control) {
    const std::stop_token stop = stop_of_writing(control, request.on_deadline);
    const bool is_vector = request.format == HalftoneFormat::Svg;
    std::vector<Raster> rasters;
    for (std::size_t ink = 0; ink < inks.size(); ++ink) {
        const DotOptions options{request.dot, plan.cover[ink], request.antialias || is_vector};
        rasters.push_back(draw_dots(inks[ink].dots.points, plan.canvas, options, stop));
        inks[ink].radius = rasters.back().radius / plan.canvas.scale;
        if (is_vector) rasters.clear();  // only the radius is of use
    }
    if (!is_vector)
        return write_raster(request, overlay(std::move(rasters), request.palette, request.antialias, stop), stop);
    const Page page{plan.box(), false, false, plan.canvas, request.drawing.width_mm};
    return write_svg(inks, request.palette, page, request.drawing.style, control.stop, stop);
}

std::string list(HalftoneFormat format, std::span<const InkDots> inks, const Report& report,
                 const std::stop_token& stop) {
    if (format == HalftoneFormat::Json) return write_json(inks, report, stop);
    if (format == HalftoneFormat::Csv) return write_csv(inks, stop);
    return write_npy(inks);
}

}  // namespace

Result<std::string> write_halftone(const HalftoneRequest& request, const HalftonePlan& plan,
                                   std::span<const Distribution> dots, double elapsed, const Control& control) {
    const std::stop_token stop = stop_of_writing(control, request.on_deadline);
    const Report report{request.run.seed, elapsed, plan.picture};
    std::vector<InkDots> inks;
    for (std::size_t ink = 0; ink < dots.size(); ++ink) inks.push_back({request.palette.inks[ink], dots[ink]});
    auto body = is_drawn(request.format) ? draw(request, plan, std::move(inks), control)
                                         : Result<std::string>(list(request.format, inks, report, stop));
    if (auto going = check_stop(stop); !going) return tl::unexpected(going.error());
    return body;
}

}  // namespace ccdt::api
