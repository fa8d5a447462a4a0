// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/halftone/halftone_answer.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "api/image/enlargement.h"
#include "api/image/overlay.h"
#include "api/output/formats.h"
#include "api/output/json_writer.h"
#include "api/output/point_drawing.h"
#include "api/output/split.h"
#include "api/run/deadline.h"
#include "core/halftone/dots/dots.h"
#include "core/halftone/dots/softening.h"
#include "core/halftone/field/field_drawing.h"
#include "core/picture/pixel_ranges.h"

namespace ccdt::api {
namespace {

/// Writes dots in the format of a request. Has an operator for each kind of writer that a format can have.
class Writing {
public:
    Writing(const HalftoneRequest& request, const PointFormat& format, const HalftonePlan& plan, const Report& report,
            std::vector<InkDots> inks, Body& body, const Control& control)
        : request_(request),
          format_(format),
          plan_(plan),
          report_(report),
          inks_(std::move(inks)),
          body_(body),
          path_stop_(control.stop),
          stop_(stop_of_writing(control, request.on_deadline)),
          executor_(*control.executor) {}

    Result<void> operator()(const ListWriter& writer) {
        if (plan_.field && writer.has_areas) describe_areas();
        writer.write({inks_}, report_, body_, stop_);
        return {};
    }

    /// Draws shapes. Dots have the same radius as in rasters.
    Result<void> operator()(const VectorWriter& writer) {
        if (plan_.field) describe_areas();
        for (std::size_t ink = 0; ink < inks_.size(); ++ink)
            inks_[ink].radius = plan_.radius ? *plan_.radius : rasterise(ink).radius / plan_.canvas.scale;
        const Page& page = plan_.page;
        const double largest = std::ranges::max_element(inks_, {}, &InkDots::radius)->radius;
        if (auto checked =
                writer.check(request_.drawing, largest, page, request_.field_of("pen"), request_.field_of("width_mm"));
            !checked)
            return checked;
        return about_option(request_, write_drawing(format_, {.layers = inks_, .tone = plan_.tone}, request_.palette,
                                                    page, request_.drawing, body_, path_stop_, stop_));
    }

    Result<void> operator()(const RasterWriter& writer) {
        return write_pixels(writer).map([&](std::string&& bytes) { body_.text() = std::move(bytes); });
    }

private:
    Result<std::string> write_pixels(const RasterWriter& writer) const {
        std::vector<Raster> rasters = draw();
        if (request_.may_be_scaled) {
            // The dots of one field are small, and would be pale if their rims were as soft as those of discs.
            constexpr unsigned kOwnOfDiscs = 2, kOwnOfField = 3;
            for (Raster& raster : rasters) soften(raster, plan_.field ? kOwnOfField : kOwnOfDiscs, executor_);
        }
        const bool has_sets = plan_.field && !plan_.field->sets.empty();
        Palette palette = request_.palette;
        if (palette.paper.transparent && !writer.has_alpha) palette.paper = kWhite;
        if (writer.write_plates != nullptr && palette.mixing == Mixing::Multiply) {
            if (has_sets) rasters = plates_of(rasters);
            if (rasters.size() < palette.inks.size()) take_black_out(rasters);
            return writer.write_plates(rasters, palette.inks, request_.drawing.width_mm, stop_);
        }
        if (has_sets) {
            return write_picture(
                writer, overlay_sets(rasters, plan_.field->sets, palette, request_.antialias, stop_, executor_));
        }
        palette.inks.resize(rasters.size());
        return write_picture(writer, overlay(std::move(rasters), palette, request_.antialias, stop_, executor_));
    }

    Result<std::string> write_picture(const RasterWriter& writer, DotImage picture) const {
        if (request_.may_be_scaled) compensate_enlargement(picture, executor_);
        return writer.write(picture, request_.drawing, stop_);
    }

    /// Draws the coverage of each ink or, for Dots::Both, of each channel of the field.
    std::vector<Raster> draw() const {
        if (plan_.field) {
            std::vector<Raster> rasters = field(CellGrid{plan_.canvas.width, plan_.canvas.height})
                                              .rasters(plan_.canvas.width, plan_.canvas.height, request_.antialias);
            for (Raster& raster : rasters) {
                if (!adds()) break;
                for (std::uint8_t& share : raster.coverage) share = static_cast<std::uint8_t>(255 - share);
            }
            return rasters;
        }
        std::vector<Raster> rasters;
        for (std::size_t ink = 0; ink < inks_.size(); ++ink) rasters.push_back(rasterise(ink));
        return rasters;
    }

    /// Returns the share of each pixel that each ink covers, for the boundaries between sets of inks.
    std::vector<Raster> plates_of(std::span<const Raster> boundaries) const {
        const std::vector<unsigned>& sets = plan_.field->sets;
        std::vector<Raster> plates(request_.palette.inks.size(), boundaries.front());
        for (std::size_t ink = 0; ink < plates.size(); ++ink) {
            std::vector<std::uint8_t>& plate = plates[ink].coverage;
            for_pixels(executor_, plate.size(), [&](std::size_t i) {
                unsigned cover = 0;
                for_sets(boundaries, i, [&](std::size_t set, unsigned share) {
                    if ((sets[set] >> ink & 1) != 0) cover += share;
                });
                plate[i] = static_cast<std::uint8_t>(cover);
            });
        }
        return plates;
    }

    /// Replaces the common part of the cyan, magenta and yellow plates with a black plate.
    void take_black_out(std::vector<Raster>& plates) const {
        Raster black = plates.front();
        for_pixels(executor_, black.coverage.size(), [&](std::size_t i) {
            unsigned common = 255;
            for (const Raster& plate : plates) common = std::min<unsigned>(common, plate.coverage[i]);
            black.coverage[i] = static_cast<std::uint8_t>(common);
            for (Raster& plate : plates) plate.coverage[i] = static_cast<std::uint8_t>(plate.coverage[i] - common);
        });
        plates.push_back(std::move(black));
    }

    /// Fits the field to a canvas or, without one, to outlines.
    FieldDrawing field(const std::optional<CellGrid>& canvas) const {
        const Point cell = cell_size();
        std::vector<Point> sites;
        for (const Point& p : inks_.front().dots.points) sites.push_back({p.x / cell.x, p.y / cell.y});
        return {*plan_.field, sites, canvas, stop_, executor_};
    }

    /// Gives writers of lists and shapes the outlines of the inks.
    void describe_areas() {
        const FieldPlan& plan = *plan_.field;
        auto outlines = field({}).outlines(adds());
        for (auto& rings : outlines) {
            for (auto& ring : rings) {
                for (Point& p : ring) p = {p.x * plan_.picture.width, p.y * plan_.picture.height};
            }
        }
        areas_.inks = std::span(request_.palette.inks).first(std::min(request_.palette.inks.size(), outlines.size()));
        if (plan.sets.empty()) {
            areas_.rings = std::move(outlines);
        } else {
            areas_.inks = request_.palette.inks;
            areas_.rings = rings_of_inks(outlines);
        }
        inks_.front().areas = &areas_;
    }

    /// Returns the outlines of each ink: those of all boundaries between a set with the ink and a set without it.
    std::vector<std::vector<std::vector<Point>>> rings_of_inks(
        std::span<const std::vector<std::vector<Point>>> boundaries) const {
        const std::vector<unsigned>& sets = plan_.field->sets;
        std::vector<std::vector<std::vector<Point>>> rings(areas_.inks.size());
        const double right = plan_.picture.width, bottom = plan_.picture.height;
        for (std::size_t ink = 0; ink < rings.size(); ++ink) {
            if ((sets.back() >> ink & 1) != 0) rings[ink].push_back({{0, 0}, {right, 0}, {right, bottom}, {0, bottom}});
            for (std::size_t b = 0; b < boundaries.size(); ++b) {
                if (((sets[b] ^ sets[b + 1]) >> ink & 1) == 0) continue;
                rings[ink].insert(rings[ink].end(), boundaries[b].begin(), boundaries[b].end());
            }
        }
        return rings;
    }

    bool adds() const { return request_.palette.mixing == Mixing::Add; }

    /// Returns the size of the cells of the field, in pixels of the picture.
    Point cell_size() const {
        const CellGrid& cells = plan_.field->cells;
        return {static_cast<double>(plan_.picture.width) / cells.columns,
                static_cast<double>(plan_.picture.height) / cells.rows};
    }

    /// Draws the discs of an ink.
    Raster rasterise(std::size_t ink) const {
        std::optional<double> radius;
        if (plan_.radius) radius = *plan_.radius * plan_.canvas.scale;
        const bool antialias = request_.antialias || request_.format->raster() == nullptr;
        const DotOptions options{radius, plan_.cover[ink], antialias, plan_.samples};
        return draw_dots(canvas_positions(inks_[ink].dots.points), plan_.canvas, options, stop_, executor_);
    }

    /// Stretches points so that, multiplied by the scale of the canvas, the corners of the picture become exactly the
    /// corners of the canvas.
    std::vector<Point> canvas_positions(std::span<const Point> points) const {
        const auto [width, height, scale] = plan_.canvas;
        const double across = width / (scale * plan_.picture.width), down = height / (scale * plan_.picture.height);
        std::vector<Point> positions;
        positions.reserve(points.size());
        for (const Point& point : points) positions.push_back({across * point.x, down * point.y});
        return positions;
    }

    const HalftoneRequest& request_;
    const PointFormat& format_;
    const HalftonePlan& plan_;
    const Report& report_;
    std::vector<InkDots> inks_;
    InkAreas areas_;
    Body& body_;
    std::stop_token path_stop_;
    std::stop_token stop_;
    Executor& executor_;
};

}  // namespace

Result<void> write_halftone(const HalftoneRequest& request, const PointFormat& format, const HalftonePlan& plan,
                            std::span<const Distribution> dots, double elapsed, const Control& control, Body& body) {
    const Report report{request.run.seed, elapsed, plan.picture, "ccdt", {}, plan.size(), plan.warnings};
    const Ink sites{};  // of one field, which have no ink
    std::vector<InkDots> inks;
    for (std::size_t ink = 0; ink < dots.size(); ++ink)
        inks.push_back({plan.field ? sites : request.palette.inks[ink], dots[ink]});
    for (std::size_t ink = 0; ink < plan.paths.size(); ++ink) inks[ink].path = plan.paths[ink];
    auto written = std::visit(Writing(request, format, plan, report, std::move(inks), body, control), format.writer);
    if (auto going = check_stop(stop_of_writing(control, request.on_deadline)); !going) return going;
    return written;
}

}  // namespace ccdt::api
