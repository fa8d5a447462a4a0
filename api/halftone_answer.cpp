#include "api/halftone_answer.h"

#include <cstddef>
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

Inks inks_of(const HalftoneRequest& request) {
    return {request.foreground.value_or(request.invert ? kWhite : kBlack),
            request.background.value_or(request.invert ? kBlack : kWhite)};
}

Result<std::string> write_raster(const HalftoneRequest& request, const Raster& raster, const std::stop_token& stop) {
    const Inks inks = inks_of(request);
    const auto width_mm = request.drawing.width_mm;
    if (request.format == HalftoneFormat::WebP) return write_webp(raster, inks, stop);
    if (request.format == HalftoneFormat::Tiff) return write_tiff(raster, request.antialias, inks, width_mm, stop);
    return write_png(raster, request.antialias, inks, width_mm);
}

Result<std::string> write_raster(const HalftoneRequest& request, const ColourRaster& raster,
                                 const std::stop_token& stop) {
    const auto width_mm = request.drawing.width_mm;
    if (request.format == HalftoneFormat::WebP) return write_webp(raster, stop);
    if (request.format == HalftoneFormat::Tiff) return write_tiff(raster, width_mm, stop);
    return write_png(raster, width_mm);
}

Result<std::string> write_rasters(const HalftoneRequest& request, std::vector<Raster> rasters,
                                  const std::stop_token& stop) {
    if (!request.print) return write_raster(request, rasters.front(), stop);
    const ColourRaster picture = overlay(rasters, *request.print, request.antialias, stop);
    rasters.clear();
    return write_raster(request, picture, stop);
}

/// @param radii  [inks] in pixels of the picture
std::string write_vectors(const HalftoneRequest& request, const HalftonePlan& plan, std::span<const Distribution> dots,
                          const std::vector<double>& radii, const std::stop_token& hurry, const std::stop_token& stop) {
    const Page page{plan.box(), false, false, plan.canvas, request.drawing.width_mm};
    const DotStyle style = request.drawing.style;
    if (!request.print)
        return write_svg(dots.front().points, page, radii.front(), style, inks_of(request), hurry, stop);
    std::vector<DotLayer> layers;
    for (std::size_t ink = 0; ink < dots.size(); ++ink) {
        const auto& [name, colour] = request.print->inks[ink];
        layers.push_back({name, colour, dots[ink].points, radii[ink]});
    }
    return write_svg(layers, page, style, {request.print->paper, request.print->additive}, hurry, stop);
}

Result<std::string> draw(const HalftoneRequest& request, const HalftonePlan& plan, std::span<const Distribution> dots,
                         const Control& control) {
    const std::stop_token stop = stop_of_writing(control, request.on_deadline);
    const bool is_vector = request.format == HalftoneFormat::Svg;
    std::vector<Raster> rasters;
    std::vector<double> radii;
    for (std::size_t ink = 0; ink < dots.size(); ++ink) {
        const DotOptions options{request.dot, plan.cover[ink], request.antialias || is_vector};
        rasters.push_back(draw_dots(dots[ink].points, plan.canvas, options, stop));
        radii.push_back(rasters.back().radius / plan.canvas.scale);
        if (is_vector) rasters.clear();  // only the radius is of use
    }
    if (!is_vector) return write_rasters(request, std::move(rasters), stop);
    return write_vectors(request, plan, dots, radii, control.stop, stop);
}

std::string list(HalftoneFormat format, const Distribution& dots, const Report& report, const std::stop_token& stop) {
    if (format == HalftoneFormat::Json) return write_distribution(dots, report, stop);
    if (format == HalftoneFormat::Csv) return write_csv(dots.points, stop);
    return write_npy(dots.points);
}

std::string list(HalftoneFormat format, const Print& print, std::span<const Distribution> dots, const Report& report,
                 const std::stop_token& stop) {
    std::vector<InkReport> reports;
    std::vector<InkPoints> points;
    for (std::size_t ink = 0; ink < dots.size(); ++ink) {
        const auto& [name, colour] = print.inks[ink];
        reports.push_back({name, colour, dots[ink]});
        points.push_back({name, dots[ink].points});
    }
    if (format == HalftoneFormat::Json) return write_inks(reports, report, stop);
    if (format == HalftoneFormat::Csv) return write_ink_csv(points, stop);
    return write_ink_npy(points);
}

}  // namespace

Result<std::string> write_halftone(const HalftoneRequest& request, const HalftonePlan& plan,
                                   std::span<const Distribution> dots, double elapsed, const Control& control) {
    const std::stop_token stop = stop_of_writing(control, request.on_deadline);
    const Report report{request.run.seed, elapsed, plan.picture};
    auto body = is_drawn(request.format) ? draw(request, plan, dots, control)
                : request.print          ? Result<std::string>(list(request.format, *request.print, dots, report, stop))
                                         : Result<std::string>(list(request.format, dots.front(), report, stop));
    if (auto going = check_stop(stop); !going) return tl::make_unexpected(going.error());
    return body;
}

}  // namespace ccdt::api
