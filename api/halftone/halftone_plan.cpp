// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/halftone/halftone_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "api/decode/decode.h"
#include "api/halftone/drawing_size.h"
#include "api/halftone/halftone_cost.h"
#include "api/halftone/separated_picture.h"
#include "api/image/ink_set.h"
#include "api/output/plot.h"
#include "api/output/point_drawing.h"
#include "api/run/deadline.h"
#include "core/halftone/field/dot_plan.h"
#include "core/halftone/inks/separation.h"
#include "core/picture/pixel_ranges.h"
#include "core/picture/tone.h"

namespace ccdt::api {
namespace {

/// Returns whether a picture without dots is bare paper everywhere. With Dots::Both, it may also have solid ink.
bool is_paper(const HalftoneRequest& request, const std::vector<std::vector<float>>& coverage, Executor& executor) {
    if (request.dots != Dots::Both) return true;
    const bool is_black = request.palette.mixing == Mixing::Add;
    return std::ranges::all_of(coverage, [&](const std::vector<float>& each) {
        return sum_of(executor, each) == (is_black ? static_cast<double>(each.size()) : 0);
    });
}

tl::unexpected<Error> nothing_to_draw(const HalftoneRequest& request) {
    const std::string looks = request.palette.mixing != Mixing::Cover ? "like its paper"
                              : request.dots == Dots::Paper           ? "black"
                                                                      : "white";
    return failure(ErrorCode::Unusable,
                   "the image is " + looks + " or transparent everywhere: there is nothing to draw",
                   request.image_field);
}

/// Returns the area of ink, in pixels of the picture, as an argument of default_scale(). For Dots::Both, the area is
/// doubled, because the largest dots have about twice the mean area. A lower bound on the area avoids a very large
/// scale if dots have little to draw.
double ink_of_scale(const HalftoneRequest& request, double ink, std::size_t pixels) {
    constexpr double kMean = 2, kMinShare = 0.1;
    return request.dots == Dots::Both ? std::max(kMean * ink, kMinShare * static_cast<double>(pixels)) : ink;
}

/// Returns the canvas of the drawing. If the server chooses the size, the canvas has at most limits.max_pixels. Errors:
/// LimitExceeded if the requested size of a drawing has more pixels.
/// @param preferred_scale  scale of a canvas whose size the server chooses, unless it would have too many pixels
Result<Canvas> plan_canvas(const HalftoneRequest& request, const HalftonePlan& plan, double preferred_scale,
                           const Limits& limits) {
    const auto canvas = settled_canvas(request, plan.picture, limits);
    if (!canvas) return canvas_of(plan.box(), fitting_scale(plan.box(), preferred_scale, limits.max_pixels));
    if (!request.format->is_drawn()) return *canvas;
    if (auto checked = check_pixels(request, *canvas, limits); !checked) return tl::unexpected(checked.error());
    return *canvas;
}

/// Returns the radius that the request gives or that follows from the size of the drawing, in pixels of the picture.
/// Returns none if the radius follows from the number of dots.
std::optional<double> requested_radius(const HalftoneRequest& request, const HalftonePlan& plan, double fineness) {
    if (has_screen_radius(request)) return screen_radius(plan.canvas, fineness);
    const DrawingOptions& drawing = request.drawing;
    if (drawing.style == DotStyle::Path && drawing.is_dot() && drawing.width_mm)
        return drawing.pen_mm / 2 / *drawing.width_mm * plan.picture.width;
    if (!request.dot) return std::nullopt;
    return picture_radius(request, plan.picture, plan.canvas.scale);
}

/// Returns the requested number of sites, or the number of dots that follows from the radius.
/// @param field  Error::field of the error that there would be too many
Result<std::size_t> sites_of(const std::optional<std::size_t>& requested, double dots, const std::string& field,
                             const Limits& limits) {
    if (requested) return *requested;
    const double sum = std::round(dots);
    if (sum <= static_cast<double>(limits.max_sites)) return static_cast<std::size_t>(std::max(sum, 1.0));
    return failure(ErrorCode::LimitExceeded,
                   "the number of dots of this size would exceed this server's limit (max-sites), which is " +
                       std::to_string(limits.max_sites),
                   field);
}

/// Returns whether the number of dots is proportional to the area that dots should cover, without regard to overlaps.
/// Runs without iterations are included, because the overlaps of their random sites are not known.
bool is_proportional(const HalftoneRequest& request) {
    return request.tone == Tone::Density || request.run.iterations == 0;
}

/// Returns what a drawing draws at its sites.
Mark mark_of(const HalftoneRequest& request) {
    return request.drawing.style == DotStyle::Path ? Mark::Line : Mark::Disc;
}

/// Returns the maximum number of dots: the limit of the server or, with the option `minutes`, the number of dots that a
/// plotter draws in the given time.
Result<std::size_t> max_dots(const HalftoneRequest& request, const SeparatedPicture& picture, const Limits& limits,
                             Executor& executor) {
    if (!request.minutes) return limits.max_sites;
    const double unit = *request.drawing.width_mm / picture.size.width;
    const CoverageCurve line(Mark::Line);
    PlotInk ink;
    for (const std::vector<float>& coverage : picture.inks.coverage) {
        const auto density = [&](std::size_t i) {
            const auto share = static_cast<double>(coverage[i]);
            return mark_of(request) == Mark::Line ? line.dots(share) : share;
        };
        ink.area += sum_of_pixels(executor, coverage.size(), density);
        ink.spread += sum_of_pixels(executor, coverage.size(), [&](std::size_t i) { return std::sqrt(density(i)); });
    }
    const double cell = picture.cell_area() * unit * unit;
    std::optional<double> radius;
    if (request.dot && request.dot->millimetres) radius = request.dot->length;
    const double dots = dots_in(60 * *request.minutes, {ink.area * cell, ink.spread * cell}, radius, request.drawing);
    if (dots >= 1) return static_cast<std::size_t>(std::min(dots, static_cast<double>(limits.max_sites)));
    return failure(ErrorCode::Unusable, "minutes is too small to draw this picture: give more minutes or a wider pen",
                   request.field_of("minutes"));
}

/// Rounds HalftonePlan::tone for answers.
double rounded_tone(double tone) {
    constexpr double kDigits = 1e4;
    return std::round(tone * kDigits) / kDigits;
}

/// Determines the number and the radius of the dots of each ink. Replaces the coverage of the picture with the density
/// of dots.
/// @param ink    [inks] area that the dots of each ink should cover, in pixels of the picture
/// @param usual  number of sites to use unless the number follows from the radius
/// @param most   maximum number of sites, from max_dots()
Result<void> settle_dots(const HalftoneRequest& request, HalftonePlan& plan, SeparatedPicture& picture,
                         std::span<const double> ink, std::size_t usual, std::size_t most, const Limits& limits,
                         const Control& control) {
    constexpr double kLowTone = 0.8;  // a lower tone is visibly too light
    plan.radius = requested_radius(request, plan, picture.fineness);
    if (is_proportional(request)) {
        plan.sites = share_sites(ink, usual);
        // Dots that a pen fills take a time that depends on their radius, so it must not change with their number.
        if (request.minutes && request.drawing.has_turns() && !plan.radius)
            plan.radius = covering_radius(std::reduce(ink.begin(), ink.end()), static_cast<double>(usual));
        return {};
    }
    const double side = std::sqrt(picture.cell_area());
    const bool has_pen = request.drawing.width_mm.has_value();
    DotRequest wanted{request.sites, plan.radius, request.detail, mark_of(request), has_pen};
    if (!plan.radius) wanted.sites = usual;
    if (plan.radius) wanted.radius = *plan.radius / side;
    // Number of dots if none overlapped; overlaps make the number larger.
    const double fewest =
        plan.radius ? std::reduce(ink.begin(), ink.end()) / std::numbers::pi / *plan.radius / *plan.radius : 0;
    if (request.minutes && fewest > static_cast<double>(most)) wanted.sites = most;
    DotPlan dots = plan_dots(std::move(picture.inks.coverage), picture.cells.columns, picture.cells.rows, wanted,
                             control.stop, *control.executor);
    if (auto going = check_stop(control.stop); !going) return going;
    picture.inks.coverage = std::move(dots.density);
    plan.radius = dots.radius * side;
    const double needed = std::reduce(dots.dots.begin(), dots.dots.end());
    const double drawn = request.minutes ? std::min(needed, static_cast<double>(most)) : needed;
    const double share = drawn < needed ? drawn / needed : 1;
    plan.tone = rounded_tone(dots.tone * share);
    plan.samples = samples_for(*plan.radius * plan.canvas.scale, plan.canvas, request.antialias);
    auto sites = sites_of(wanted.sites, drawn, request.drawing.is_dot() ? "pen" : "dot", limits);
    if (!sites) return tl::unexpected(sites.error());
    plan.sites = share_sites(dots.dots, *sites);
    if (dots.shows_contrast) {
        plan.warnings.push_back({request.field_of("sites"),
                                 "so few small dots cannot reach half of the tone: they show local contrast instead"});
    } else if (!request.minutes && *plan.tone < kLowTone) {
        plan.warnings.push_back({request.field_of("sites"), "so few small dots cover only " +
                                                                std::to_string(std::lround(100 * *plan.tone)) +
                                                                " % of what they should: the drawing is too light"});
    }
    return {};
}

/// Plans a drawing by one field.
FieldPlan plan_field(const HalftoneRequest& request, SeparatedPicture& picture, const FieldOptions& options,
                     const Control& control) {
    std::vector<std::vector<float>> light = std::move(picture.inks.coverage);
    Light paper{1, 1, 1};
    InkSet inks;
    if (has_sets(request.palette)) {
        inks = toned(ink_set(request.palette), request.tone);
        paper = inks.paper;
    }
    const std::array<float, 3> full{paper.red, paper.green, paper.blue};
    for (std::size_t c = 0; c < light.size(); ++c) {
        for_pixels(*control.executor, light[c].size(),
                   [&](std::size_t i) { light[c][i] = full[c] * (1 - light[c][i]); });
    }
    if (!has_sets(request.palette))
        return plan_field(std::move(light), picture.cells, options, control.stop, *control.executor);
    return plan_field({std::move(light[0]), std::move(light[1]), std::move(light[2])}, inks, picture.cells, options,
                      control.stop, *control.executor);
}

/// Returns the smallest area of a dot or a hole that a drawing shows well, in pixels of the picture.
double least_area(const HalftoneRequest& request, const HalftonePlan& plan) {
    constexpr double kPixels = 2, kDiameter = 0.1;  // pixels of a drawing without antialiasing; millimetres of a print
    const double pixel = 1 / plan.canvas.scale;
    if (request.format->raster() != nullptr) return request.antialias ? 0 : kPixels * pixel * pixel;
    if (!request.drawing.width_mm) return 0;
    const double diameter = kDiameter / *request.drawing.width_mm * plan.picture.width;
    return std::numbers::pi / 4 * diameter * diameter;
}

/// Plans a drawing by one field, and determines the number of its sites. If every part of the picture is bare paper or
/// solid ink, there are no sites.
/// @param usual  number of sites to use unless the number follows from the radius
Result<void> settle_field(const HalftoneRequest& request, HalftonePlan& plan, SeparatedPicture& picture,
                          std::size_t usual, const Limits& limits, const Control& control) {
    const double cell = picture.cell_area();
    FieldOptions options{request.sites, {}, request.detail, least_area(request, plan) / cell};
    if (const auto radius = requested_radius(request, plan, picture.fineness))
        options.radius = *radius / std::sqrt(cell);
    if (!options.radius) options.sites = usual;
    if (has_screen_radius(request))  // at most as many dots as in a picture of solid ink
        options.max_sites = usual_sites(request, plan.picture, all_pixels(plan.picture), 1, limits);
    plan.field = plan_field(request, picture, options, control);
    if (auto going = check_stop(control.stop); !going) return going;
    const bool is_drawn = plan.field->sites > 0;
    auto sites = sites_of(options.sites, plan.field->sites, "dot", limits);
    if (!sites) return tl::unexpected(sites.error());
    plan.sites = {is_drawn ? *sites : 0};
    plan.field->sites = static_cast<double>(plan.sites.front());
    plan.radius = plan.field->radius * std::sqrt(cell);
    if (is_drawn) plan.tone = 1;
    return {};
}

/// Creates the simulated print that the polish compares with the picture, in order to move the dots of all inks
/// together. Returns none if the polish does not need it.
/// @param light  wanted light of each cell
std::optional<PrintProof> make_proof(const HalftoneRequest& request, const HalftonePlan& plan, const CellGrid& cells,
                                     const LightPlanes& light, Executor& executor) {
    const bool polished = request.run.iterations > 0 && request.run.quality != Quality::Draft;
    if (request.palette.mixing == Mixing::Cover || request.dots == Dots::Both || !polished || !plan.radius)
        return std::nullopt;
    const std::size_t sites = std::accumulate(plan.sites.begin(), plan.sites.end(), std::size_t{0});
    return PrintProof(light, cells, plan.picture.width, plan.picture.height,
                      toned(ink_set(request.palette), request.tone), *plan.radius, sites, executor);
}

/// Removes points at regular steps along a path. The others keep their order.
/// @param path   indices of the points; a closed path repeats the first one
/// @param share  share of the points that stay, below 1; at least one point is removed if there is any
std::vector<Point> thinned(std::span<const Point> points, std::span<const std::uint32_t> path, double share) {
    const std::size_t count = points.size();
    const auto removed =
        std::min(count, static_cast<std::size_t>(std::ceil((1 - std::max(share, 0.0)) * static_cast<double>(count))));
    std::vector<bool> stays(count, true);
    for (std::size_t i = 0; i < removed; ++i) stays[path[(2 * i + 1) * count / (2 * removed)]] = false;
    std::vector<Point> rest;
    for (std::size_t i = 0; i < count; ++i) {
        if (stays[i]) rest.push_back(points[i]);
    }
    return rest;
}

/// Returns the warning that only one frame is drawn, if the file has several frames.
std::vector<Warning> warnings_of(const HalftoneRequest& request) {
    std::string frame = describe_frame(request.image.header);
    if (frame.empty()) return {};
    return {{request.image_field, std::move(frame)}};
}

/// Creates a density for each ink that has sites. Any other ink gets a uniform density. Frees the coverage of each ink.
Result<std::vector<Density>> make_densities(HalftonePlan& plan, SeparatedPicture& picture) {
    std::vector<Density> densities(plan.sites.size(), Density::uniform());
    for (std::size_t ink = 0; ink < plan.sites.size(); ++ink) {
        const auto values = plan.field ? std::vector<float>{} : std::exchange(picture.inks.coverage[ink], {});
        if (plan.sites[ink] == 0) continue;
        auto density = Density::grid(picture.cells.columns, picture.cells.rows,
                                     std::span<const float>(plan.field ? plan.field->density : values));
        if (!density) return tl::unexpected(density.error());
        densities[ink] = *std::move(density);
    }
    return densities;
}

/// Removes dots, at regular steps along the path of each ink, until a plotter draws the rest in the requested time. The
/// plan estimates the length of the path, so there are few to remove.
void keep_to_time(const HalftoneRequest& request, HalftonePlan& plan, std::vector<Distribution>& dots,
                  const std::stop_token& stop) {
    constexpr double kMargin = 1e-3;
    while (!stop.stop_requested()) {
        std::vector<InkDots> inks;
        for (std::size_t ink = 0; ink < dots.size(); ++ink)
            inks.push_back({request.palette.inks[ink], dots[ink], plan.radius.value_or(0)});
        Plot plot = plot_of({inks}, plan.page, request.drawing, stop);
        const double share = 60 * *request.minutes / plot.size().seconds;
        if (!(share < 1)) {
            if (stop.stop_requested()) return;  // the paths may not be short
            for (Pen& pen : plot.pens) plan.paths.push_back(std::move(pen.runs.front().path));
            return;
        }
        std::size_t before = 0, after = 0;
        for (std::size_t ink = 0; ink < dots.size(); ++ink) {
            std::vector<Point>& points = dots[ink].points;
            before += points.size();
            points = thinned(points, plot.pens[ink].runs.front().path, share - kMargin);
            after += points.size();
        }
        if (plan.tone) plan.tone = rounded_tone(*plan.tone * static_cast<double>(after) / static_cast<double>(before));
    }
}

}  // namespace

Result<HalftonePlan> plan_halftone(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                                   const Control& control) {
    auto picture = separate_picture(request, limits, decode, control);
    if (!picture) return tl::unexpected(picture.error());
    Separation& separation = picture->inks;
    HalftonePlan plan;
    plan.picture = picture->size;
    plan.warnings = warnings_of(request);
    std::vector<double> ink;
    for (const auto& each : separation.coverage) ink.push_back(sum_of(*control.executor, each) * picture->cell_area());
    const double all_ink = drawn_share(separation.coverage, request, *control.executor) * picture->cell_area();
    if (!(all_ink > 0) && is_paper(request, separation.coverage, *control.executor)) return nothing_to_draw(request);
    const std::size_t pixels =
        static_cast<std::size_t>(plan.picture.width) * static_cast<std::size_t>(plan.picture.height);
    for (const double each : ink) plan.cover.push_back(each / static_cast<double>(pixels));
    const auto most = max_dots(request, *picture, limits, *control.executor);
    if (!most) return tl::unexpected(most.error());
    const std::size_t usual =
        request.sites ? *request.sites
                      : std::min(usual_sites(request, plan.picture, all_ink, picture->fineness, limits), *most);
    const double scale = default_scale(ink_of_scale(request, all_ink, pixels), pixels, usual);
    auto canvas = plan_canvas(request, plan, scale, limits);
    if (!canvas) return tl::unexpected(canvas.error());
    plan.canvas = *canvas;
    plan.page = Page{plan.box(), false, false, plan.canvas};
    if (auto placed = place_on_paper(request, plan.page); !placed) return tl::unexpected(placed.error());
    const std::string option = size_option(request);
    if (auto checked = request.format->check_side(*canvas, option, option); !checked)
        return tl::unexpected(checked.error());
    auto settled = request.dots == Dots::Both
                       ? settle_field(request, plan, *picture, usual, limits, control)
                       : settle_dots(request, plan, *picture, ink, usual, *most, limits, control);
    if (!settled) return tl::unexpected(settled.error());
    plan.proof = make_proof(request, plan, picture->cells, std::exchange(separation.light, {}), *control.executor);
    auto densities = make_densities(plan, *picture);
    if (!densities) return about_image(densities.error(), request);
    plan.densities = *std::move(densities);
    return plan;
}

Result<std::vector<Distribution>> place_dots(const HalftoneRequest& request, HalftonePlan& plan,
                                             const Control& control) {
    const std::vector<Density> densities = std::exchange(plan.densities, {});
    const auto domain = Domain::rectangle(plan.picture.width, plan.picture.height);
    if (!domain) return tl::unexpected(domain.error());
    if (plan.field && plan.sites.front() == 0) {
        std::vector<Distribution> none(1);
        none.front().trace = {0};
        return none;
    }
    Retouch retouch;
    if (plan.proof) {
        retouch = [&](std::span<const std::vector<Point>> sites) {
            return plan.proof->moves(sites, control.stop, *control.executor);
        };
    }
    Options run = request.run;
    run.keep_steps = false;
    auto dots = distribute_inks(*domain, densities, plan.sites, run, control, retouch);
    if (!dots) return about_image(dots.error(), request);
    for (const Distribution& each : *dots) {
        if (auto whole = check_whole(each.stopped, request.on_deadline); !whole)
            return about_image(whole.error(), request);
    }
    if (request.minutes) keep_to_time(request, plan, *dots, control.stop);
    return dots;
}

}  // namespace ccdt::api
