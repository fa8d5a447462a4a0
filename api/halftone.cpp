#include "api/halftone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "api/image/embedded_image.h"
#include "api/image/png_writer.h"
#include "api/image/tiff_writer.h"
#include "api/image/webp_writer.h"
#include "api/input/negotiation.h"
#include "api/input/run_options.h"
#include "api/json/json_writer.h"
#include "api/output/formats.h"
#include "api/output/point_table.h"
#include "api/stopwatch.h"
#include "core/halftone/dots.h"

namespace ccdt::api {
namespace {

constexpr Interval kScales = {.min = 0.1, .max = 16};
constexpr Interval kRadii = {.min = 0, .max = 65536, .above_min = true};

/// In the order of HalftoneFormat, which is the server's preference.
constexpr std::array<Format, 7> kFormats = {kPng, kJson, kSvg, kCsv, kNpy, kWebP, kTiff};

/// Whether an answer is drawn on a canvas.
bool is_drawn(HalftoneFormat format) {
    constexpr std::array kDrawn = {HalftoneFormat::Png, HalftoneFormat::Svg, HalftoneFormat::WebP,
                                   HalftoneFormat::Tiff};
    return std::ranges::find(kDrawn, format) != kDrawn.end();
}

Result<void> read_dot(const Input& input, std::optional<double>& dot) {
    if (const auto text = read_text(input); text && *text == "auto") {
        dot.reset();
        return {};
    }
    auto radius = read_number(input, kRadii);
    if (!radius) radius.error().message += ", or auto";
    return assign(dot, std::move(radius));
}

Result<void> read_tone(const Input& input, Tone& tone) {
    static constexpr std::array<std::string_view, 2> kWords = {"linear", "perceptual"};
    return assign(tone, read_choice(input, kWords));
}

/// A request on its way; the format can only be settled when all options are known.
struct Draft {
    HalftoneRequest request;
    std::optional<std::size_t> format;  ///< index into kFormats
};

constexpr std::array<OptionRule<Draft>, 16> kRules = {{
    {"sites", [](const Input& i, const Limits& l, Draft& d) { return assign(d.request.sites, read_sites(i, l)); }},
    {"seed", [](const Input& i, const Limits&, Draft& d) { return read_seed(i, d.request.run); }},
    {"iterations", [](const Input& i, const Limits&, Draft& d) { return read_iterations(i, d.request.run); }},
    {"passes", [](const Input& i, const Limits&, Draft& d) { return read_passes(i, d.request.run); }},
    {"quality", [](const Input& i, const Limits&, Draft& d) { return read_quality(i, d.request.run); }},
    {"on_deadline", [](const Input& i, const Limits&, Draft& d) { return read_on_deadline(i, d.request.on_deadline); }},
    {"scale", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.scale, read_number(i, kScales)); }},
    {"dot", [](const Input& i, const Limits&, Draft& d) { return read_dot(i, d.request.dot); }},
    {"antialias", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.antialias, read_boolean(i)); }},
    {"invert", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.invert, read_boolean(i)); }},
    {"tone", [](const Input& i, const Limits&, Draft& d) { return read_tone(i, d.request.tone); }},
    {"foreground",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.foreground, read_colour(i)); }},
    {"background",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.background, read_colour_or_none(i)); }},
    {"width_mm", [](const Input& i, const Limits&, Draft& d) { return read_width_mm(i, d.request.drawing); }},
    {"style", [](const Input& i, const Limits&, Draft& d) { return read_style(i, d.request.drawing); }},
    {"format", [](const Input& i, const Limits&, Draft& d) { return assign(d.format, read_format(i, kFormats)); }},
}};

Result<HalftoneRequest> parse_options(HalftoneRequest request, const std::vector<Input>& inputs,
                                      std::string_view accept, const Limits& limits) {
    Draft draft{std::move(request), {}};
    if (auto read = read_options<Draft>(kRules, inputs, limits, draft); !read) {
        return tl::make_unexpected(read.error());
    }
    if (!draft.format) {
        auto chosen = assign(draft.format, negotiate(accept, kFormats));
        if (!chosen) return tl::make_unexpected(chosen.error());
    }
    draft.request.format = static_cast<HalftoneFormat>(*draft.format);
    return std::move(draft.request);
}

/// Where the dots go in the picture, and how many there are.
struct Plan {
    PictureSize picture;
    double ink = 0;  ///< mean coverage
    std::size_t sites = 0;
    Canvas canvas;  ///< of an answer that is drawn
    Density density = Density::uniform();
};

double mean(const std::vector<float>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

Box box_of(PictureSize picture) {
    return {{0, 0}, {static_cast<double>(picture.width), static_cast<double>(picture.height)}};
}

/// Errors: LimitExceeded for a canvas that is larger than what the format holds.
Result<void> check_side(HalftoneFormat format, const Canvas& canvas) {
    if (format != HalftoneFormat::WebP || std::max(canvas.width, canvas.height) <= kMaxWebPSide) return {};
    return failure(ErrorCode::LimitExceeded,
                   "the output would have " + std::to_string(canvas.width) + " x " + std::to_string(canvas.height) +
                       " pixels; WebP holds at most " + std::to_string(kMaxWebPSide) +
                       " a side: take a smaller scale or another format",
                   "scale");
}

/// A chosen scale gives way to the limit; one that was asked for does not.
Result<Canvas> plan_canvas(const HalftoneRequest& request, PictureSize picture, double preferred_scale,
                           const Limits& limits) {
    if (request.scale) {
        const Canvas canvas = canvas_of(box_of(picture), *request.scale);
        if (fits(canvas, limits.max_pixels)) return canvas;
        return failure(ErrorCode::LimitExceeded,
                       "scale makes an output of " + std::to_string(canvas.width) + " x " +
                           std::to_string(canvas.height) + " pixels; this server's limit (max-pixels) is " +
                           std::to_string(limits.max_pixels),
                       "scale");
    }
    const Box box = box_of(picture);
    return canvas_of(box, fitting_scale(box, preferred_scale, limits.max_pixels));
}

Result<Plan> plan_dots(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                       const Control& control) {
    auto decoded = decode.grey(request.image.bytes, limits.max_pixels, control.stop);
    if (!decoded) return failure(decoded.error().code, decoded.error().message, request.image_field);
    Plan plan;
    plan.picture = {decoded->width, decoded->height};
    const std::vector<float> coverage = ink_coverage(*decoded, request.tone, request.invert);
    *decoded = {};  // megabytes a megapixel, no longer needed
    plan.ink = mean(coverage);
    if (!(plan.ink > 0)) {
        return failure(ErrorCode::Unusable,
                       request.invert ? "the image is black or transparent all over: there is nothing to draw"
                                      : "the image is white or transparent all over: there is nothing to draw",
                       request.image_field);
    }
    plan.sites = request.sites ? *request.sites : default_sites(coverage, limits.max_sites);
    if (is_drawn(request.format)) {
        const double scale = default_scale(coverage, plan.sites);
        auto planned = assign(plan.canvas, plan_canvas(request, plan.picture, scale, limits));
        if (!planned) return tl::make_unexpected(planned.error());
        if (auto checked = check_side(request.format, plan.canvas); !checked) {
            return tl::make_unexpected(checked.error());
        }
    }
    auto density = Density::grid(plan.picture.width, plan.picture.height, std::span<const float>(coverage));
    if (!density) return failure(density.error().code, density.error().message, request.image_field);
    plan.density = *std::move(density);
    return plan;
}

/// The density is taken and given back as soon as the sites lie.
Result<Distribution> place_dots(const HalftoneRequest& request, Plan& plan, const Control& control) {
    const Density density = std::exchange(plan.density, Density::uniform());
    const auto domain = Domain::rectangle(plan.picture.width, plan.picture.height);
    if (!domain) return tl::make_unexpected(domain.error());
    Options options = request.run;
    options.sites = plan.sites;
    auto distribution = distribute_all(*domain, density, options, control, request.on_deadline);
    if (!distribution) return failure(distribution.error().code, distribution.error().message, request.image_field);
    return distribution;
}

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

Result<std::string> draw(const HalftoneRequest& request, const Plan& plan, std::span<const Point> points,
                         const Control& control) {
    const std::stop_token stop = stop_of_writing(control, request.on_deadline);
    const bool is_vector = request.format == HalftoneFormat::Svg;
    const bool antialias = request.antialias || is_vector;
    Raster raster = draw_dots(points, plan.canvas, {request.dot, plan.ink, antialias}, stop);
    if (!is_vector) return write_raster(request, raster, stop);
    raster.coverage = {};  // only the radius is of use
    const Page page{box_of(plan.picture), false, false, plan.canvas, request.drawing.width_mm};
    return write_svg(points, page, raster.radius / plan.canvas.scale, request.drawing.style, inks_of(request),
                     control.stop, stop);
}

std::string write(HalftoneFormat format, const Distribution& distribution, const Report& report,
                  const std::stop_token& stop) {
    switch (format) {
        case HalftoneFormat::Json:
            return write_distribution(distribution, report, stop);
        case HalftoneFormat::Csv:
            return write_csv(distribution.points, stop);
        case HalftoneFormat::Npy:
            return write_npy(distribution.points);
        case HalftoneFormat::Png:
        case HalftoneFormat::Svg:
        case HalftoneFormat::WebP:
        case HalftoneFormat::Tiff:
            break;
    }
    return {};
}

Result<std::string> encode(const HalftoneRequest& request, const Plan& plan, const Distribution& distribution,
                           double elapsed, const Control& control) {
    const std::stop_token stop = stop_of_writing(control, request.on_deadline);
    const Report report{request.run.seed, elapsed, plan.picture};
    auto body = is_drawn(request.format) ? draw(request, plan, distribution.points, control)
                                         : Result<std::string>(write(request.format, distribution, report, stop));
    if (auto going = check_stop(stop); !going) return tl::make_unexpected(going.error());
    return body;
}

}  // namespace

Result<HalftoneRequest> parse_halftone(std::string image, const std::vector<TextOption>& options,
                                       std::string_view accept, const Limits& limits) {
    HalftoneRequest request;
    auto parsed = parse_options(std::move(request), inputs_of(options), accept, limits);
    if (!parsed) return parsed;
    const auto header = read_image_header(image, limits.max_pixels);
    if (!header) return tl::make_unexpected(header.error());
    parsed->image = {std::move(image), *header};
    return parsed;
}

Result<HalftoneRequest> parse_halftone_json(std::string_view body, const std::vector<TextOption>& options,
                                            std::string_view accept, const Limits& limits) {
    const auto document = JsonDocument::parse(body);
    if (!document) return tl::make_unexpected(document.error());
    auto inputs = inputs_of(document->root(), "");
    if (!inputs) return tl::make_unexpected(inputs.error());
    const auto image = std::find_if(inputs->begin(), inputs->end(), [](const Input& i) { return i.name == "image"; });
    if (image == inputs->end()) return failure(ErrorCode::Malformed, "image is missing", "/image");
    auto file = read_embedded_image(*image, limits);
    if (!file) return tl::make_unexpected(file.error());

    HalftoneRequest request;
    request.image_field = image->field;
    request.image = *std::move(file);
    inputs->erase(image);
    for (auto& input : inputs_of(options)) inputs->push_back(std::move(input));
    return parse_options(std::move(request), *inputs, accept, limits);
}

Result<Answer> run_halftone(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                            const Control& control, Timings& timings) {
    Stopwatch watch;
    auto plan = plan_dots(request, limits, decode, control);
    timings.decode = watch.lap();
    if (!plan) return tl::make_unexpected(plan.error());
    if (auto going = check_stop(control.stop); !going) return tl::make_unexpected(going.error());

    const auto distribution = place_dots(request, *plan, control);
    timings.optimise = watch.lap();
    if (!distribution) return tl::make_unexpected(distribution.error());

    auto body = encode(request, *plan, *distribution, timings.decode + timings.optimise, control);
    timings.encode = watch.lap();
    if (!body) return tl::make_unexpected(body.error());
    Answer answer;
    answer.media_type = kFormats[static_cast<std::size_t>(request.format)].content_type();
    answer.body = *std::move(body);
    answer.sites = plan->sites;
    answer.pixels = static_cast<std::size_t>(plan->picture.width) * static_cast<std::size_t>(plan->picture.height);
    answer.partial = distribution->stopped;
    // A stop may have made the path of a drawing longer.
    answer.repeats = request.format != HalftoneFormat::Json && !control.stop.stop_requested();
    return answer;
}

}  // namespace ccdt::api
