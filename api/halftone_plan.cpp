#include "api/halftone_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "api/cost.h"
#include "api/image/ink_set.h"
#include "api/output/point_drawing.h"
#include "api/run/deadline.h"
#include "core/halftone/dot_plan.h"
#include "core/halftone/fineness.h"
#include "core/halftone/levels.h"
#include "core/halftone/separation.h"
#include "core/halftone/tone.h"

namespace ccdt::api {
namespace {

struct SeparatedPicture {
    PictureSize size;
    Separation inks;      ///< without light if there is one ink, which covers
    double fineness = 0;  ///< of the picture
};

double sum(const std::vector<float>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

tl::unexpected<Error> about_image(const Error& error, const HalftoneRequest& request) {
    return failure(error.code, error.message, request.image_field);
}

/// Decodes, and separates into inks; one that covers needs no colours of the picture, which take three times the
/// memory. The decoded picture is gone once this returns.
Result<SeparatedPicture> separate_picture(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                                          const std::stop_token& stop) {
    if (request.palette.mixing == Mixing::Cover) {
        auto picture = decode.grey(request.image.bytes, limits.max_pixels, stop);
        if (!picture) return about_image(picture.error(), request);
        picture = with_levels(*picture, request.levels);
        return SeparatedPicture{{picture->width, picture->height},
                                {{ink_coverage(*picture, request.tone, request.invert)}, {}},
                                fineness(*picture)};
    }
    auto picture = decode.colour(request.image.bytes, limits.max_pixels, stop);
    if (!picture) return about_image(picture.error(), request);
    picture = with_levels(*picture, request.levels);
    auto inks = separate(*picture, ink_set(request.palette), request.tone, stop);
    if (auto going = check_stop(stop); !going) return tl::unexpected(going.error());
    return SeparatedPicture{{picture->width, picture->height}, std::move(inks), fineness(*picture)};
}

tl::unexpected<Error> nothing_to_draw(const HalftoneRequest& request) {
    const std::string looks = request.palette.mixing != Mixing::Cover ? "like its paper"
                              : request.invert                        ? "black"
                                                                      : "white";
    return failure(ErrorCode::Unusable, "the image is " + looks + " or transparent all over: there is nothing to draw",
                   request.image_field);
}

/// Makes the canvas. A chosen scale gives way to the limit; one that was asked for does not, unless nothing is drawn.
Result<Canvas> plan_canvas(const HalftoneRequest& request, const Box& box, double preferred_scale,
                           const Limits& limits) {
    if (!request.scale) return canvas_of(box, fitting_scale(box, preferred_scale, limits.max_pixels));
    const Canvas canvas = canvas_of(box, *request.scale);
    if (!request.format->is_drawn() || fits(canvas, limits.max_pixels)) return canvas;
    return failure(ErrorCode::LimitExceeded,
                   "scale makes an output of " + std::to_string(canvas.width) + " x " + std::to_string(canvas.height) +
                       " pixels; this server's limit (max-pixels) is " + std::to_string(limits.max_pixels),
                   "scale");
}

/// Radius that is asked for, in pixels of the picture.
std::optional<double> wished_radius(const HalftoneRequest& request, const HalftonePlan& plan) {
    if (!request.dot) return std::nullopt;
    if (request.dot->millimetres) return request.dot->length / *request.drawing.width_mm * plan.picture.width;
    return request.dot->length / plan.canvas.scale;
}

/// Number of sites: a radius alone decides on it.
Result<std::size_t> sites_of(const DotWish& wish, const DotPlan& dots, const Limits& limits) {
    if (wish.sites) return *wish.sites;
    const double sum = std::round(std::reduce(dots.dots.begin(), dots.dots.end()));
    if (sum <= static_cast<double>(limits.max_sites)) return static_cast<std::size_t>(std::max(sum, 1.0));
    return failure(ErrorCode::LimitExceeded,
                   "dots of this radius would be more than this server's limit (max-sites), which is " +
                       std::to_string(limits.max_sites),
                   "dot");
}

/// Says whether dots are in proportion to what they are to cover, whatever overlaps. The start of a run has no pattern
/// whose overlaps are known.
bool is_proportional(const HalftoneRequest& request) {
    return request.tone == Tone::Density || request.run.iterations == 0;
}

/// Settles how many dots each ink has, and how large they are; what is to be covered becomes what dots are wanted.
/// @param usual  number of sites, unless their radius decides on it
Result<void> settle_dots(const HalftoneRequest& request, HalftonePlan& plan, Separation& separation,
                         std::span<const double> ink, std::size_t usual, const Limits& limits,
                         const std::stop_token& stop) {
    constexpr double kToneDigits = 1e4;
    plan.radius = wished_radius(request, plan);
    if (is_proportional(request)) {
        plan.sites = share_sites(ink, usual);
        return {};
    }
    DotWish wish{request.sites, plan.radius, request.detail};
    if (!plan.radius) wish.sites = usual;
    DotPlan dots = plan_dots(std::move(separation.coverage), plan.picture.width, plan.picture.height, wish, stop);
    if (auto going = check_stop(stop); !going) return going;
    separation.coverage = std::move(dots.density);
    plan.radius = dots.radius;
    plan.tone = std::round(dots.tone * kToneDigits) / kToneDigits;
    plan.samples = samples_for(dots.radius * plan.canvas.scale, plan.canvas, request.antialias);
    auto sites = sites_of(wish, dots, limits);
    if (!sites) return tl::unexpected(sites.error());
    plan.sites = share_sites(dots.dots, *sites);
    return {};
}

/// Makes what dots of several inks are compared with, if they are polished.
/// @param light  what shall be seen
std::optional<PrintProof> make_proof(const HalftoneRequest& request, const HalftonePlan& plan,
                                     const LightPlanes& light) {
    const bool polished = request.run.iterations > 0 && request.run.quality != Quality::Draft;
    if (request.palette.mixing == Mixing::Cover || !polished || !plan.radius) return std::nullopt;
    const std::size_t sites = std::accumulate(plan.sites.begin(), plan.sites.end(), std::size_t{0});
    return PrintProof(light, plan.picture.width, plan.picture.height, toned(ink_set(request.palette), request.tone),
                      *plan.radius, sites);
}

/// Finds what is not as its sender may think: of a film that moves, one picture is taken.
std::vector<Warning> warnings_of(const HalftoneRequest& request) {
    std::string frame = describe_frame(request.image.header);
    if (frame.empty()) return {};
    return {{request.image_field, std::move(frame)}};
}

/// Makes a density for each ink that has sites. Coverages go as they are taken.
Result<std::vector<Density>> make_densities(SeparatedPicture& picture, const std::vector<std::size_t>& sites) {
    std::vector<Density> densities(sites.size(), Density::uniform());
    for (std::size_t ink = 0; ink < sites.size(); ++ink) {
        const std::vector<float> coverage = std::exchange(picture.inks.coverage[ink], {});
        if (sites[ink] == 0) continue;
        auto density = Density::grid(picture.size.width, picture.size.height, std::span(coverage));
        if (!density) return tl::unexpected(density.error());
        densities[ink] = *std::move(density);
    }
    return densities;
}

}  // namespace

Result<HalftonePlan> plan_halftone(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                                   const Control& control) {
    auto picture = separate_picture(request, limits, decode, control.stop);
    if (!picture) return tl::unexpected(picture.error());
    Separation& separation = picture->inks;
    HalftonePlan plan;
    plan.picture = picture->size;
    plan.warnings = warnings_of(request);
    std::vector<double> ink(separation.coverage.size());
    std::ranges::transform(separation.coverage, ink.begin(), sum);
    const double all_ink = std::accumulate(ink.begin(), ink.end(), 0.0);
    if (!(all_ink > 0)) return nothing_to_draw(request);
    const std::size_t pixels = separation.coverage.front().size();
    for (const double each : ink) plan.cover.push_back(each / static_cast<double>(pixels));
    const std::size_t usual = request.sites ? *request.sites : usual_sites(request, all_ink, picture->fineness, limits);
    auto canvas = plan_canvas(request, plan.box(), default_scale(all_ink, pixels, usual), limits);
    if (!canvas) return tl::unexpected(canvas.error());
    plan.canvas = *canvas;
    if (auto checked = request.format->check_side(*canvas, "scale", "scale"); !checked)
        return tl::unexpected(checked.error());
    auto settled = settle_dots(request, plan, separation, ink, usual, limits, control.stop);
    if (!settled) return tl::unexpected(settled.error());
    plan.proof = make_proof(request, plan, std::exchange(separation.light, {}));
    auto densities = make_densities(*picture, plan.sites);
    if (!densities) return about_image(densities.error(), request);
    plan.densities = *std::move(densities);
    return plan;
}

Result<std::vector<Distribution>> place_dots(const HalftoneRequest& request, HalftonePlan& plan,
                                             const Control& control) {
    const std::vector<Density> densities = std::exchange(plan.densities, {});
    const auto domain = Domain::rectangle(plan.picture.width, plan.picture.height);
    if (!domain) return tl::unexpected(domain.error());
    Retouch retouch;
    if (plan.proof) {
        retouch = [&](std::span<const std::vector<Point>> sites) { return plan.proof->moves(sites, control.stop); };
    }
    auto dots = distribute_inks(*domain, densities, plan.sites, request.run, control, retouch);
    if (!dots) return about_image(dots.error(), request);
    for (const Distribution& each : *dots) {
        if (auto whole = check_whole(each, request.on_deadline); !whole) return about_image(whole.error(), request);
    }
    return dots;
}

}  // namespace ccdt::api
