// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/sample_writer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "api/image/overlay.h"
#include "api/output/cairo_drawing.h"
#include "api/output/formats.h"
#include "api/output/point_drawing.h"
#include "api/output/point_set.h"
#include "api/output/split.h"
#include "api/run/deadline.h"
#include "core/picture/tone.h"

namespace ccdt::api {
namespace {

/// Returns the radius of the dots, in the units of the drawing. The radius is at most twice the longer side of the
/// drawing; a dot of that size covers the drawing wherever its centre lies.
double radius_of(const SampleRequest& request, const SampleDrawing& drawn, const Page& page) {
    const double largest = 2 * std::max(drawn.box.width(), drawn.box.height());
    const DrawingOptions& drawing = request.output.drawing;
    if (drawing.is_dot() && page.width_mm) return std::min(drawing.pen_mm / 2 / page.unit(), largest);
    return std::min(request.output.dot.value_or(drawn.pitch / (drawn.figure ? 3 : 4)), largest);
}

/// Writes points in the format of a request. Has an operator for each kind of writer that a format can have.
class Writing {
public:
    Writing(const SampleRequest& request, const PointFormat& format, const Page& page, const Report& report,
            const Palette& palette, const PointSet& points, Body& body, const Control& control)
        : request_(request),
          format_(format),
          page_(page),
          report_(report),
          palette_(palette),
          points_(points),
          body_(body),
          path_stop_(control.stop),
          stop_(stop_of_writing(control, request.on_deadline)) {}

    Result<void> operator()(const ListWriter& writer) const {
        writer.write(points_, report_, body_, stop_);
        return {};
    }

    Result<void> operator()(const VectorWriter&) const {
        return request_.about_option(
            write_drawing(format_, points_, palette_, page_, request_.output.drawing, body_, path_stop_, stop_));
    }

    Result<void> operator()(const RasterWriter& writer) const {
        auto picture =
            draw().and_then([&](const DotImage& image) { return writer.write(image, request_.output.drawing, stop_); });
        return std::move(picture).map([&](std::string&& bytes) { body_.text() = std::move(bytes); });
    }

private:
    Result<DotImage> draw() const {
        if (points_.figure != nullptr) return picture_of_map(points_, palette_, page_, stop_);
        std::vector<Raster> rasters;
        for (const InkDots& layer : points_.layers)
            rasters.push_back(draw_points(layer.dots.points, page_, layer.radius, stop_));
        return overlay(std::move(rasters), palette_, true, stop_);
    }

    const SampleRequest& request_;
    const PointFormat& format_;
    const Page& page_;
    const Report& report_;
    const Palette& palette_;
    const PointSet& points_;
    Body& body_;
    std::stop_token path_stop_;
    std::stop_token stop_;
};

}  // namespace

Result<Page> plan_page(const SampleRequest& request, const PointFormat& format, const SampleDrawing& drawn,
                       const Limits& limits) {
    const DrawingOptions& drawing = request.output.drawing;
    const std::optional<int>& width = request.output.width;
    const auto* rectangle = std::get_if<Rectangle>(&request.region.domain);
    Page page{drawn.box, true, rectangle != nullptr && rectangle->periodic};
    page.along_path = request.output.order.value_or(PointOrder::Path) == PointOrder::Path;
    if (auto placed = request.about_option(place_on_paper(drawing, page)); !placed)
        return tl::unexpected(placed.error());
    if (const VectorWriter* const shapes = format.vector()) {
        const double radius = radius_of(request, drawn, page);
        auto checked = shapes->check(drawing, radius, page, request.field_of("pen"), request.field_of("width_mm"));
        if (!checked) return tl::unexpected(checked.error());
    }
    const Box& box = page.box;
    const double longer = std::max(box.width(), box.height());
    const RasterWriter* const pixels = format.raster();
    const double max_side = pixels == nullptr ? kMaxDrawingSide : std::min<double>(kMaxDrawingSide, pixels->max_side);
    const double wished = std::clamp(kPixelPitch / drawn.pitch, kMinDrawingSide / longer, max_side / longer);
    const std::size_t most = std::min(limits.max_pixels, static_cast<std::size_t>(kMaxCanvasPixels));
    page.canvas = canvas_of(box, width ? *width / box.width() : fitting_scale(box, wished, most));
    const std::string field = request.field_of("width");
    if (auto checked = format.check_side(page.canvas, "width", field); !checked) return tl::unexpected(checked.error());
    if (pixels == nullptr || fits(page.canvas, limits.max_pixels)) return page;
    return failure(ErrorCode::LimitExceeded,
                   "width makes a picture of " + std::to_string(page.canvas.width) + " x " +
                       std::to_string(page.canvas.height) + " pixels; this server's limit (max-pixels) is " +
                       std::to_string(limits.max_pixels),
                   field);
}

Result<void> write_sample(const SampleRequest& request, const PointFormat& format, const SampleDrawing& drawn,
                          const Page& page, std::span<const ClassDots> dots, const Report& report,
                          const Control& control, Body& body) {
    const Palette palette = palette_of(request);
    std::vector<InkDots> layers;
    for (std::size_t i = 0; i < dots.size(); ++i)
        layers.push_back({palette.inks[i], dots[i].dots, radius_of(request, drawn, page), nullptr, dots[i].feature_of});
    PointSet points{layers};
    points.tiles = request.output.tiles;
    if (drawn.figure) points.figure = &*drawn.figure;
    if (request.features) {
        points.feature_ids = request.features->ids;
        if (!request.features->carried.of_feature.empty()) points.properties = &request.features->carried;
    }
    const Writing writing(request, format, page, report, palette, points, body, control);
    auto written = std::visit(writing, format.writer);
    if (auto going = check_stop(stop_of_writing(control, request.on_deadline)); !going) return going;
    return written;
}

}  // namespace ccdt::api
