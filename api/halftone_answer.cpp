#include "api/halftone_answer.h"

#include <cstddef>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "api/image/overlay.h"
#include "api/output/formats.h"
#include "api/output/json_writer.h"
#include "api/output/point_drawing.h"
#include "api/run/deadline.h"
#include "core/halftone/diffusion.h"
#include "core/halftone/dots.h"
#include "core/halftone/ground_outline.h"
#include "core/halftone/softening.h"

namespace ccdt::api {
namespace {

/// Writes the dots in the way that a format's writer takes them.
class Writing {
public:
    Writing(const HalftoneRequest& request, const HalftonePlan& plan, const SidedDots& sided, const Report& report,
            std::vector<InkDots> inks, Body& body, const Control& control)
        : request_(request),
          plan_(plan),
          sided_(sided),
          report_(report),
          inks_(std::move(inks)),
          body_(body),
          hurry_(control.stop),
          stop_(stop_of_writing(control, request.on_deadline)),
          team_(*control.team) {}

    Result<void> operator()(const ListWriter& writer) {
        const std::optional<TwoSidedDots> two_sides = describe_two_sides();
        if (two_sides) inks_.front().two_sides = &*two_sides;
        writer.write(inks_, report_, body_, stop_);
        return {};
    }

    /// Draws shapes with the radius that rasters have.
    Result<void> operator()(const VectorWriter& writer) {
        const std::optional<TwoSidedDots> two_sides = describe_two_sides();
        if (two_sides) inks_.front().two_sides = &*two_sides;
        for (std::size_t ink = 0; ink < inks_.size(); ++ink)
            inks_[ink].radius = plan_.radius ? *plan_.radius : rasterise(ink, true).radius / plan_.canvas.scale;
        const Page page{plan_.box(), false, false, plan_.canvas, request_.drawing.width_mm};
        writer.write(inks_, request_.palette, page, request_.drawing.style, body_, hurry_, stop_);
        return {};
    }

    Result<void> operator()(const RasterWriter& writer) {
        return write_pixels(writer).map([&](std::string&& bytes) { body_.text() = std::move(bytes); });
    }

private:
    Result<std::string> write_pixels(const RasterWriter& writer) const {
        std::vector<Raster> rasters;
        for (std::size_t ink = 0; ink < inks_.size(); ++ink) rasters.push_back(rasterise(ink, request_.antialias));
        if (may_be_scaled()) {
            for (Raster& raster : rasters) soften(raster, team_);
        }
        const Palette& palette = request_.palette;
        const auto width_mm = request_.drawing.width_mm;
        if (writer.write_plates != nullptr && palette.mixing == Mixing::Multiply)
            return writer.write_plates(rasters, palette.inks, width_mm, stop_);
        return writer.write(overlay(std::move(rasters), palette, request_.antialias, stop_, team_), width_mm, stop_);
    }

    /// Tells whether a browser may show the drawing in another size, which nobody has asked for.
    bool may_be_scaled() const {
        return request_.on_screen && request_.antialias && !request_.width && !request_.height;
    }

    /// Describes the dots and the ground of both sides for writers of lists and shapes.
    std::optional<TwoSidedDots> describe_two_sides() {
        if (!plan_.two_sides) return std::nullopt;
        std::optional<TwoSidedDots> two_sides{{sided_, outline_of(plan_.two_sides->ground)}};
        const Point cell = cell_size();
        for (auto& ring : two_sides->ground) {
            for (Point& point : ring) point = {point.x * cell.x, point.y * cell.y};
        }
        return two_sides;
    }

    /// Size of the cells of the ground, in pixels of the picture.
    Point cell_size() const {
        const CellGrid& cells = plan_.two_sides->cells;
        return {static_cast<double>(plan_.picture.width) / cells.columns,
                static_cast<double>(plan_.picture.height) / cells.rows};
    }

    /// Draws the ink of a halftone with dots on both sides.
    Raster rasterise_both(bool antialias) const {
        const bool soft = antialias || plan_.samples > 1;
        const std::vector<Point> places = canvas_places(inks_.front().dots.points);
        Raster raster = draw_dots(places, sided_.radii, plan_.canvas, antialias, plan_.samples, stop_, team_);
        const CellGrid& cells = plan_.two_sides->cells;
        const Point scale{static_cast<double>(raster.width) / cells.columns,
                          static_cast<double>(raster.height) / cells.rows};
        plan_.two_sides->ground.apply(raster, scale, soft, team_);
        if (soft && !antialias) diffuse(raster.coverage, raster.width, raster.height);
        return raster;
    }

    Raster rasterise(std::size_t ink, bool antialias) const {
        if (plan_.two_sides) return rasterise_both(antialias);
        std::optional<double> radius;
        if (plan_.radius) radius = *plan_.radius * plan_.canvas.scale;
        const DotOptions options{radius, plan_.cover[ink], antialias, plan_.samples};
        return draw_dots(canvas_places(inks_[ink].dots.points), plan_.canvas, options, stop_, team_);
    }

    /// Moves points such that the canvas' scale puts the corners of the picture on its own.
    std::vector<Point> canvas_places(std::span<const Point> points) const {
        const auto [width, height, scale] = plan_.canvas;
        const double across = width / (scale * plan_.picture.width), down = height / (scale * plan_.picture.height);
        std::vector<Point> places;
        places.reserve(points.size());
        for (const Point& point : points) places.push_back({across * point.x, down * point.y});
        return places;
    }

    const HalftoneRequest& request_;
    const HalftonePlan& plan_;
    const SidedDots& sided_;
    const Report& report_;
    std::vector<InkDots> inks_;
    Body& body_;
    std::stop_token hurry_;
    std::stop_token stop_;
    Team& team_;
};

}  // namespace

Result<void> write_halftone(const HalftoneRequest& request, const HalftonePlan& plan, const PlacedDots& dots,
                            double elapsed, const Control& control, Body& body) {
    const Report report{request.run.seed, elapsed, plan.picture, "ccdt", {}, plan.size(), plan.warnings};
    std::vector<InkDots> inks;
    for (std::size_t ink = 0; ink < dots.inks.size(); ++ink)
        inks.push_back({request.palette.inks[ink], dots.inks[ink]});
    auto written =
        std::visit(Writing(request, plan, dots.sided, report, std::move(inks), body, control), request.format->writer);
    if (auto going = check_stop(stop_of_writing(control, request.on_deadline)); !going) return going;
    return written;
}

}  // namespace ccdt::api
