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
#include "api/image/ink_set.h"
#include "api/image/overlay.h"
#include "api/image/srgb.h"
#include "api/output/formats.h"
#include "api/output/json_writer.h"
#include "api/output/point_drawing.h"
#include "api/run/deadline.h"
#include "core/halftone/diffusion.h"
#include "core/halftone/dots.h"
#include "core/halftone/ground_outline.h"
#include "core/halftone/overprint.h"
#include "core/halftone/pixel_ranges.h"
#include "core/halftone/softening.h"

namespace ccdt::api {
namespace {

/// Writes dots in the format of a request. Has an operator for each kind of writer that a format can have.
class Writing {
public:
    Writing(const HalftoneRequest& request, const HalftonePlan& plan, std::span<const SizedDots> sized,
            const Report& report, std::vector<InkDots> inks, Body& body, const Control& control)
        : request_(request),
          plan_(plan),
          sized_(sized),
          report_(report),
          inks_(std::move(inks)),
          body_(body),
          path_stop_(control.stop),
          stop_(stop_of_writing(control, request.on_deadline)),
          executor_(*control.executor) {}

    Result<void> operator()(const ListWriter& writer) {
        describe_two_sides();
        writer.write({inks_}, report_, body_, stop_);
        return {};
    }

    /// Draws shapes. Dots have the same radius as in rasters.
    Result<void> operator()(const VectorWriter& writer) {
        describe_two_sides();
        for (std::size_t ink = 0; ink < inks_.size(); ++ink)
            inks_[ink].radius = plan_.radius ? *plan_.radius : rasterise(ink, true).radius / plan_.canvas.scale;
        const Page page{plan_.box(), false, false, plan_.canvas, request_.drawing.width_mm};
        const double largest = std::ranges::max_element(inks_, {}, &InkDots::radius)->radius;
        if (auto checked =
                writer.check(request_.drawing, largest, page, request_.field_of("pen"), request_.field_of("width_mm"));
            !checked)
            return checked;
        writer.write({inks_}, request_.palette, page, request_.drawing, body_, path_stop_, stop_);
        return {};
    }

    Result<void> operator()(const RasterWriter& writer) {
        return write_pixels(writer).map([&](std::string&& bytes) { body_.text() = std::move(bytes); });
    }

private:
    Result<std::string> write_pixels(const RasterWriter& writer) const {
        if (plan_.two_sides && !plan_.two_sides->is_nested && request_.antialias && writer.write_plates == nullptr)
            return write_picture(writer, mixed_pixels());
        std::vector<Raster> rasters;
        const std::size_t count = plan_.two_sides ? plan_.two_sides->channels.size() : inks_.size();
        for (std::size_t ink = 0; ink < count; ++ink) rasters.push_back(rasterise(ink, request_.antialias));
        if (request_.may_be_scaled) {
            for (Raster& raster : rasters) soften(raster, executor_);
        }
        Palette palette = request_.palette;
        if (writer.write_plates != nullptr && palette.mixing == Mixing::Multiply) {
            if (count < palette.inks.size()) take_black_out(rasters);
            return writer.write_plates(rasters, palette.inks, request_.drawing.width_mm, stop_);
        }
        palette.inks.resize(count);
        return write_picture(writer, overlay(std::move(rasters), palette, request_.antialias, stop_, executor_));
    }

    Result<std::string> write_picture(const RasterWriter& writer, DotImage picture) const {
        if (request_.may_be_scaled) compensate_enlargement(picture, executor_);
        return writer.write(picture, request_.drawing.width_mm, stop_);
    }

    /// Draws antialiased dots on both sides of the tonal scale, in custom inks.
    DotImage mixed_pixels() const {
        std::vector<Raster> flipped, grounds;
        for (std::size_t ink = 0; ink < plan_.two_sides->channels.size(); ++ink) {
            flipped.push_back(rasterise_flipped(ink, true));
            grounds.push_back({flipped.back().width, flipped.back().height, 0, {}});
            grounds.back().coverage.resize(flipped.back().coverage.size());
            apply_ground(ink, true, grounds.back());
            if (!request_.may_be_scaled) continue;
            soften(flipped.back(), executor_);
            soften(grounds.back(), executor_);
        }
        return overlay_flipped(flipped, grounds, request_.palette, stop_, executor_);
    }

    /// Replaces the common part of the cyan, magenta and yellow plates with a black plate.
    void take_black_out(std::vector<Raster>& plates) const {
        Raster black = plates.front();
        for_ranges(executor_, black.coverage.size(), kPixelsOfTask, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                unsigned common = 255;
                for (const Raster& plate : plates) common = std::min<unsigned>(common, plate.coverage[i]);
                black.coverage[i] = static_cast<std::uint8_t>(common);
                for (Raster& plate : plates) plate.coverage[i] = static_cast<std::uint8_t>(plate.coverage[i] - common);
            }
        });
        plates.push_back(std::move(black));
    }

    /// Adds to `inks_` what writers of lists and shapes need for dots on both sides of the tonal scale: the sizes of
    /// the dots, and the outlines of the black grounds. Removes kinds without dots.
    void describe_two_sides() {
        if (!plan_.two_sides) return;
        const auto& channels = plan_.two_sides->channels;
        const Point cell = cell_size();
        grounds_.inks = std::span(request_.palette.inks).first(channels.size());
        for (const TwoSidedChannel& channel : channels) {
            auto& rings = grounds_.rings.emplace_back(outline_of(adds() ? channel.ground.inverse() : channel.ground));
            for (auto& ring : rings) {
                for (Point& point : ring) point = {point.x * cell.x, point.y * cell.y};
            }
        }
        for (std::size_t kind = 0; kind < inks_.size(); ++kind)
            two_sides_.push_back({sized_[kind], plan_.two_sides->kinds[kind].flips, grounds_});
        for (std::size_t kind = 0; kind < inks_.size(); ++kind) inks_[kind].two_sides = &two_sides_[kind];
        std::vector<InkDots> drawn;
        for (const InkDots& each : inks_) {
            if (!each.dots.points.empty()) drawn.push_back(each);
        }
        if (drawn.empty()) drawn.push_back(inks_.front());
        inks_.swap(drawn);
    }

    bool adds() const { return request_.palette.mixing == Mixing::Add; }

    /// Returns the size of the cells of the ground, in pixels of the picture.
    Point cell_size() const {
        const CellGrid& cells = plan_.two_sides->cells;
        return {static_cast<double>(plan_.picture.width) / cells.columns,
                static_cast<double>(plan_.picture.height) / cells.rows};
    }

    /// Draws the coverage of one channel for Dots::Both: the channel's ground, and the dots that flip the channel.
    Raster rasterise_both(std::size_t channel, bool antialias) const {
        const bool soft = antialias || plan_.samples > 1;
        Raster raster = rasterise_flipped(channel, antialias);
        apply_ground(channel, soft, raster);
        if (adds()) {
            for (std::uint8_t& share : raster.coverage) share = static_cast<std::uint8_t>(255 - share);
        }
        if (soft && !antialias) diffuse(raster.coverage, raster.width, raster.height);
        return raster;
    }

    /// Computes the share of each pixel that ink covers. The raster initially holds the share that dots flip.
    /// @param soft  whether edges of the ground are antialiased
    void apply_ground(std::size_t channel, bool soft, Raster& raster) const {
        const CellGrid& cells = plan_.two_sides->cells;
        const Point scale{static_cast<double>(raster.width) / cells.columns,
                          static_cast<double>(raster.height) / cells.rows};
        plan_.two_sides->channels[channel].ground.apply(raster, scale, soft, executor_);
    }

    /// Draws the dots that flip a channel.
    Raster rasterise_flipped(std::size_t channel, bool antialias) const {
        std::vector<Point> places;
        std::vector<float> radii;
        for (std::size_t kind = 0; kind < inks_.size(); ++kind) {
            if ((plan_.two_sides->kinds[kind].flips >> channel & 1) == 0) continue;
            const std::vector<Point> own = canvas_places(inks_[kind].dots.points);
            places.insert(places.end(), own.begin(), own.end());
            radii.insert(radii.end(), sized_[kind].radii.begin(), sized_[kind].radii.end());
        }
        return draw_dots(places, radii, plan_.canvas, antialias, plan_.samples, stop_, executor_);
    }

    /// Draws the coverage of one ink or, for dots on both sides of the tonal scale, of one channel.
    Raster rasterise(std::size_t ink, bool antialias) const {
        if (plan_.two_sides) return rasterise_both(ink, antialias);
        std::optional<double> radius;
        if (plan_.radius) radius = *plan_.radius * plan_.canvas.scale;
        const DotOptions options{radius, plan_.cover[ink], antialias, plan_.samples};
        return draw_dots(canvas_places(inks_[ink].dots.points), plan_.canvas, options, stop_, executor_);
    }

    /// Stretches points so that, multiplied by the scale of the canvas, the corners of the picture become exactly the
    /// corners of the canvas.
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
    std::span<const SizedDots> sized_;
    const Report& report_;
    std::vector<InkDots> inks_;
    Grounds grounds_;
    std::vector<TwoSidedDots> two_sides_;  ///< [kinds]
    Body& body_;
    std::stop_token path_stop_;
    std::stop_token stop_;
    Executor& executor_;
};

/// Returns the names and colours under which the answer lists dots. For dots on both sides of the tonal scale, there is
/// one entry for each kind of dots, named after the channels that the kind flips.
std::vector<Ink> inks_of_answer(const HalftoneRequest& request, const HalftonePlan& plan) {
    const std::vector<Ink>& inks = request.palette.inks;
    if (!plan.two_sides || inks.size() == 1) return inks;
    const InkSet set = ink_set(request.palette);
    std::vector<Ink> kinds;
    for (const KindOfDots& kind : plan.two_sides->kinds) {
        Ink& ink = kinds.emplace_back();
        std::vector<float> cover(inks.size(), 0);
        for_channels(kind.flips, [&](std::size_t channel) {
            ink.name.append(ink.name.empty() ? "" : "+").append(inks[channel].name);
            cover[channel] = 1;
        });
        const Light light = printed({set.inks, set.additive ? Light{} : Light{1, 1, 1}, set.additive}, cover);
        ink.colour = {to_srgb(static_cast<double>(light.red)), to_srgb(static_cast<double>(light.green)),
                      to_srgb(static_cast<double>(light.blue))};
    }
    return kinds;
}

}  // namespace

Result<void> write_halftone(const HalftoneRequest& request, const PointFormat& format, const HalftonePlan& plan,
                            const PlacedDots& dots, double elapsed, const Control& control, Body& body) {
    const Report report{request.run.seed, elapsed, plan.picture, "ccdt", {}, plan.size(), plan.warnings};
    const std::vector<Ink> all = inks_of_answer(request, plan);
    std::vector<InkDots> inks;
    for (std::size_t ink = 0; ink < dots.inks.size(); ++ink) inks.push_back({all[ink], dots.inks[ink]});
    auto written =
        std::visit(Writing(request, plan, dots.sized, report, std::move(inks), body, control), format.writer);
    if (auto going = check_stop(stop_of_writing(control, request.on_deadline)); !going) return going;
    return written;
}

}  // namespace ccdt::api
