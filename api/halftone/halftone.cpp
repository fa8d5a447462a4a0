// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/halftone/halftone.h"

#include <algorithm>
#include <array>
#include <utility>

#include "api/decode/timed_decode.h"
#include "api/halftone/drawing_size.h"
#include "api/halftone/halftone_answer.h"
#include "api/input/negotiation.h"
#include "api/input/run_options.h"
#include "api/output/formats.h"
#include "api/output/json_writer.h"
#include "api/run/stopwatch.h"
#include "core/halftone/field/field_plan.h"

namespace ccdt::api {
namespace {

constexpr Interval kScales = {.min = 0.1, .max = 16};
constexpr Interval kMinutes = {.min = 0.1, .max = 10'000};
constexpr Interval kDetails = {.min = 0, .max = 1};
constexpr Interval kRadii = {.min = 0, .max = 65536, .above_min = true};

constexpr std::array<Choice<Dots>, 3> kDots = {{{"both", Dots::Both}, {"ink", Dots::Ink}, {"paper", Dots::Paper}}};

constexpr std::array<Choice<Tone>, 3> kTones = {
    {{"linear", Tone::Linear}, {"perceptual", Tone::Perceptual}, {"density", Tone::Density}}};

Result<void> read_dot(const Input& input, std::optional<DotRadius>& dot) {
    constexpr std::string_view kUnit = "mm";
    Input number = input;
    const auto text = read_text(input);
    if (text && *text == "auto") {
        dot.reset();
        return {};
    }
    const bool millimetres = text && text->ends_with(kUnit);
    if (millimetres) number.value = text->substr(0, text->size() - kUnit.size());
    auto radius = read_number(number, kRadii);
    if (!radius) {
        radius.error().message += ", with or without mm, or auto";
        return tl::unexpected(radius.error());
    }
    dot = DotRadius{*radius, millimetres};
    return {};
}

/// A request that is being parsed. Values that depend on several options are determined after all options have been
/// read.
struct Draft {
    HalftoneRequest request;
    std::optional<bool> antialias;
    std::optional<Dots> dots;
    std::optional<bool> invert;
    std::optional<Palette> color;
    std::optional<Palette> palette;
    std::optional<Colour> foreground;
    std::optional<Colour> background;
};

DrawingOptions& drawing_of(Draft& draft) {
    return draft.request.drawing;
}

constexpr auto kPictureRules = std::to_array<OptionRule<Draft>>({
    {"sites", [](const Input& i, const Limits& l, Draft& d) { return assign(d.request.sites, read_sites(i, l)); }},
    {"minutes",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.minutes, read_number(i, kMinutes)); }},
    {"seed", [](const Input& i, const Limits&, Draft& d) { return read_seed(i, d.request.run); }},
    {"iterations", [](const Input& i, const Limits&, Draft& d) { return read_iterations(i, d.request.run); }},
    {"passes", [](const Input& i, const Limits&, Draft& d) { return read_passes(i, d.request.run); }},
    {"quality",
     [](const Input& i, const Limits&, Draft& d) { return read_quality_without_stealthy(i, d.request.run); }},
    {"on_deadline",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.on_deadline, read_on_deadline(i)); }},
    {"scale", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.scale, read_number(i, kScales)); }},
    {"width", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.width, read_side(i)); }},
    {"height", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.height, read_side(i)); }},
    {"fit", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.fit, read_fit(i)); }},
    {"gravity", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.gravity, read_gravity(i)); }},
    {"dot", [](const Input& i, const Limits&, Draft& d) { return read_dot(i, d.request.dot); }},
    {"detail",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.detail, read_number(i, kDetails)); }},
    {"alpha", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.alpha, read_alpha(i)); }},
    {"levels", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.levels, read_levels(i)); }},
    {"antialias", [](const Input& i, const Limits&, Draft& d) { return assign(d.antialias, read_boolean(i)); }},
    {"dots", [](const Input& i, const Limits&, Draft& d) { return assign(d.dots, read_choice<Dots>(i, kDots)); }},
    {"invert", [](const Input& i, const Limits&, Draft& d) { return assign(d.invert, read_boolean(i)); }},
    {"tone",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.tone, read_choice<Tone>(i, kTones)); }},
    {"color", [](const Input& i, const Limits&, Draft& d) { return assign(d.color, read_color(i)); }},
    {"palette", [](const Input& i, const Limits&, Draft& d) { return assign(d.palette, read_palette(i)); }},
    {"foreground", [](const Input& i, const Limits&, Draft& d) { return assign(d.foreground, read_colour(i)); }},
    {"background",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.background, read_colour_or_none(i)); }},
});

constexpr auto kFormatRules = std::to_array<OptionRule<Draft>>({
    {"format", [](const Input& i, const Limits&,
                  Draft& d) { return assign(d.request.format, read_format(i, halftone_formats())); }},
});

constexpr auto kRules = joined(kPictureRules, drawing_rules<Draft, drawing_of>(), kFormatRules);

/// Checks that a request for inks with the mixing Multiply or Add gives no `foreground` and, with Add, no `background`.
Result<void> check_colours(const Palette& palette, const HalftoneInput& input) {
    for (const Input& option : input.options) {
        if (option.name == "foreground") return malformed(option, "is an option of color=gray only");
        if (option.name == "background" && palette.mixing == Mixing::Add)
            return malformed(option, "is not an option of color=rgb, whose background is black");
    }
    return {};
}

/// Sets the colours of ink and paper, for a single opaque ink.
void colour_ink(Draft& draft) {
    Palette& palette = draft.request.palette;
    const bool invert = draft.request.dots == Dots::Paper;
    palette.inks.front().colour = draft.foreground.value_or(invert ? kWhite : kBlack);
    palette.paper = draft.background.value_or(invert ? kBlack : kWhite);
}

Result<void> settle_palette(Draft& draft, const HalftoneInput& input) {
    if (draft.palette && draft.color)
        return malformed(input.option("palette"), "replaces color: give only one of them");
    Palette& palette = draft.request.palette;
    if (draft.color) palette = *std::move(draft.color);
    if (draft.palette) palette = *std::move(draft.palette);
    if (palette.mixing == Mixing::Cover) {
        colour_ink(draft);
        return {};
    }
    palette.paper = draft.background.value_or(palette.paper);
    return check_colours(palette, input);
}

/// Returns whether a format cannot draw holes in ink.
bool needs_pen(const PointFormat& format) {
    const VectorWriter* const shapes = format.vector();
    return shapes != nullptr && shapes->by_pen;
}

constexpr std::string_view kPenObstacle = "cannot be both in formats for plotters: a pen can only add ink";

/// Returns the reason why Dots::Both is not available; empty if it is.
std::string_view obstacle_to_both(const HalftoneRequest& request) {
    if (request.tone == Tone::Density) return "cannot be both with tone=density, whose dots are ink";
    if (request.drawing.is_stroked()) return "can be both only with style=fill: a pen can only add ink";
    if (request.minutes || request.drawing.part_minutes)
        return "cannot be both with minutes, the time of a plotter: a pen can only add ink";
    return needs_pen(*request.format) ? kPenObstacle : std::string_view{};
}

/// Chooses the shapes of the dots. By default, drawings have Dots::Both, and lists have Dots::Ink. Must be called after
/// the format is known.
Result<void> settle_sides(Draft& draft, const HalftoneInput& input) {
    if (draft.dots && draft.invert && *draft.invert != (*draft.dots == Dots::Paper))
        return malformed(input.option("invert"), "contradicts dots: invert=true means dots=paper");
    const std::string_view obstacle = obstacle_to_both(draft.request);
    Dots& dots = draft.request.dots;
    const Dots usual = obstacle.empty() && draft.request.format->is_drawn() ? Dots::Both : Dots::Ink;
    dots = draft.dots.value_or(draft.invert ? *draft.invert ? Dots::Paper : Dots::Ink : usual);
    if (dots == Dots::Both && !obstacle.empty()) return malformed(input.option("dots"), std::string(obstacle));
    const bool is_grey = draft.color.value_or(Palette{}).mixing == Mixing::Cover && !draft.palette;
    if (dots == Dots::Paper && !is_grey)
        return malformed(input.option(draft.dots ? "dots" : "invert"),
                         "makes light dots on black, which are available with color=gray only");
    return {};
}

/// Checks that a size in pixels is given for drawings only, and not by two options that contradict each other.
Result<void> check_size(const HalftoneRequest& request, const HalftoneInput& input) {
    const bool is_sized = request.width || request.height;
    for (const Input& option : input.options) {
        const bool is_side = option.name == "width" || option.name == "height";
        if ((is_side || option.name == "fit") && !request.format->is_drawn())
            return malformed(option, "is an option of drawings only; lists of dots are in pixels of the picture");
        if ((is_side || option.name == "scale") && request.drawing.dpi)
            return malformed(option, "replaces dpi: give only one of them");
        if (is_side && request.scale) return malformed(option, "replaces scale: give only one of them");
        if (option.name == "fit" && !(request.width && request.height))
            return malformed(option, is_sized ? "needs both width and height" : "needs width and height");
    }
    return check_gravity(input.options, request.fit);
}

/// Decides whether the drawing is for a screen or for print. Drawings for print are by default not antialiased.
Result<void> settle_size(Draft& draft, const HalftoneInput& input) {
    HalftoneRequest& request = draft.request;
    const RasterWriter* const raster = request.format->raster();
    const bool is_sized = request.width || request.height;
    const bool is_print = request.scale || request.drawing.has_width();
    request.on_screen = !is_print && (is_sized || (raster != nullptr && !raster->is_for_print));
    request.antialias = draft.antialias.value_or(request.on_screen);
    request.may_be_scaled = request.on_screen && !is_sized && !draft.antialias;
    return check_size(request, input);
}

/// Sets the detail to 0 for tone=density, whose dots follow the picture without sharpening.
Result<void> settle_detail(HalftoneRequest& request, const HalftoneInput& input) {
    if (request.tone != Tone::Density) return {};
    if (input.has("detail") && request.detail > 0)
        return malformed(input.option("detail"),
                         "is not an option of tone=density, whose dots follow the picture without sharpening");
    request.detail = 0;
    return {};
}

/// Checks that the request gives width_mm if it gives the radius in millimetres. Checks that sizes of dots that follow
/// from the tones are not also given.
Result<void> check_dot(const HalftoneRequest& request, const HalftoneInput& input) {
    if (request.dot && request.sites && request.dots == Dots::Both)
        return malformed(input.option("dot"),
                         "cannot be given together with sites if dots=both: leave one of them out");
    if (!request.dot || !request.dot->millimetres || request.drawing.has_width()) return {};
    return malformed(input.option("dot"), "in mm " + std::string(kNeedsWidth));
}

/// Checks the option `minutes`, the drawing time of a plotter, which limits the number of dots.
Result<void> check_minutes(const HalftoneRequest& request, const HalftoneInput& input) {
    if (!request.minutes) return {};
    if (request.sites) return malformed(input.option("minutes"), "replaces sites: give only one of them");
    if (request.drawing.has_width()) return {};
    return malformed(input.option("minutes"), std::string(kNeedsWidth));
}

Result<void> check_drawing(const HalftoneRequest& request, const PointFormat& format) {
    return about_option(request, format.check_drawing(request.drawing));
}

Result<HalftoneRequest> parse_options(const HalftoneInput& input, std::string_view accept, const Limits& limits) {
    Draft draft;
    draft.request.image_field = input.image_field;
    if (auto read = read_options<Draft>(kRules, input.options, limits, draft); !read)
        return tl::unexpected(read.error());
    ErrorList errors;
    errors.add(settle_format(accept, halftone_formats(), draft.request.format));
    if (draft.request.format != nullptr) {
        errors.add(settle_sides(draft, input));
        errors.add(settle_size(draft, input));
        draft.request.drawing.pen_follows = draft.request.drawing.style == DotStyle::Path && !input.has("pen");
        errors.add(about_option(draft.request, draft.request.format->check_kind(draft.request.drawing)));
        errors.add(check_drawing(draft.request, *draft.request.format));
    }
    errors.add(about_option(draft.request, check_effects(draft.request.drawing, draft.request.dot.has_value())));
    errors.add(settle_palette(draft, input));
    errors.add(check_dot(draft.request, input));
    errors.add(check_minutes(draft.request, input));
    errors.add(settle_detail(draft.request, input));
    if (auto settled = errors.result(); !settled) return tl::unexpected(settled.error());
    const DrawingOptions& drawing = draft.request.drawing;
    if (drawing.is_dot() && drawing.style == DotStyle::Stroke) draft.request.dot = DotRadius{drawing.pen_mm / 2, true};
    if (draft.request.dots == Dots::Both) draft.request.run.quality = quality_of_sites(draft.request.run.quality);
    return std::move(draft.request);
}

/// Checks that placed dots can be written in a format that is not the format of their request. Errors: Malformed;
/// LimitExceeded.
Result<void> check_format(const HalftoneRequest& request, const Canvas& canvas, const PointFormat& format,
                          const Limits& limits) {
    if (request.dots == Dots::Both && needs_pen(format))
        return failure(ErrorCode::Malformed, std::string("dots ").append(kPenObstacle), request.field_of("dots"));
    if (format.is_drawn()) {
        if (auto sized = check_pixels(request, canvas, limits); !sized) return sized;
    }
    const std::string option = size_option(request);
    if (auto sized = format.check_side(canvas, option, option); !sized) return sized;
    return check_drawing(request, format);
}

/// Sets the width of the drawing, if it follows from the paper, and the number of pixels that follows from it.
Result<HalftoneRequest> settle_width(HalftoneRequest request) {
    const ImageFile& image = request.image;
    auto width = static_cast<int>(image.header.width), height = static_cast<int>(image.header.height);
    if (shown_orientation(image.bytes, image.header) > 4) std::swap(width, height);
    const PictureSize part = drawn_part(request, {width, height});
    Page page{{{0, 0}, {static_cast<double>(part.width), static_cast<double>(part.height)}}};
    if (auto placed = place_on_paper(request, page); !placed) return tl::unexpected(placed.error());
    request.drawing.width_mm = page.width_mm;
    if (!request.drawing.dpi) return request;
    if (auto set = about_option(request, assign(request.width, width_in_pixels(request.drawing))); !set)
        return tl::unexpected(set.error());
    return request;
}

}  // namespace

std::string HalftoneRequest::field_of(std::string_view option) const {
    return image_field.empty() ? std::string(option) : pointer_below("", option);
}

std::vector<std::string_view> halftone_options() {
    return names_of<Draft>(kRules);
}

Result<HalftoneRequest> parse_halftone(const HalftoneInput& input, std::string_view accept, const Limits& limits) {
    return with_image(parse_options(input, accept, limits), input).and_then(settle_width);
}

Result<PlacedHalftone> place_halftone(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                                      const Control& control, Timings& timings) {
    Stopwatch watch;
    auto plan = plan_halftone(request, limits, timed(decode, timings.decode), control);
    timings.prepare = watch.lap() - timings.decode;
    if (!plan) return tl::unexpected(plan.error());
    if (auto going = check_stop(control.stop); !going) return tl::unexpected(going.error());

    auto dots = place_dots(request, *plan, control);
    timings.optimise = watch.lap();
    if (!dots) return tl::unexpected(dots.error());
    return PlacedHalftone{*std::move(plan), *std::move(dots), timings.before_encoding()};
}

Result<Answer> write_answer(const HalftoneRequest& request, const PlacedHalftone& placed, const PointFormat& format,
                            const Limits& limits, const Control& control, Timings& timings, BodySink* sink) {
    Stopwatch watch;
    const auto& [plan, dots, elapsed] = placed;
    if (&format != request.format) {
        if (auto can = check_format(request, plan.canvas, format, limits); !can) return tl::unexpected(can.error());
    }
    Answer answer;
    answer.media_type = format.media_type(request.drawing);
    answer.dots = plan.size();
    if (format.file.name != "json" && !plan.warnings.empty()) answer.warnings = write_warnings(plan.warnings);
    for (const Distribution& each : dots) answer.sites += each.points.size();
    answer.pixels = static_cast<std::size_t>(plan.picture.width) * static_cast<std::size_t>(plan.picture.height);
    answer.partial = std::ranges::any_of(dots, &Distribution::stopped);
    answer.repeats = format.repeats();
    Body body(answer, sink, control.stop);
    auto written = write_halftone(request, format, plan, dots, elapsed, control, body);
    timings.encode = watch.lap();
    if (!written) return tl::unexpected(written.error());
    return body.finish(std::move(answer));
}

Result<Answer> run_halftone(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                            const Control& control, Timings& timings, BodySink* sink) {
    const auto placed = place_halftone(request, limits, decode, control, timings);
    if (!placed) return tl::unexpected(placed.error());
    return write_answer(request, *placed, *request.format, limits, control, timings, sink);
}

}  // namespace ccdt::api
