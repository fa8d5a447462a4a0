#include "api/halftone_plan.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

#include "api/image/ink_set.h"
#include "api/output/point_drawing.h"
#include "api/run/deadline.h"
#include "core/halftone/separation.h"
#include "core/halftone/tone.h"

namespace ccdt::api {
namespace {

/// Share of each pixel that each ink covers.
struct Separation {
    PictureSize picture;
    std::vector<std::vector<float>> coverage;  ///< [inks][width * height]
};

double sum(const std::vector<float>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

tl::unexpected<Error> about_image(const Error& error, const HalftoneRequest& request) {
    return failure(error.code, error.message, request.image_field);
}

/// Decodes, and separates into inks; one that covers needs no colours of the picture, which take three times the
/// memory. The decoded picture is gone once this returns.
Result<Separation> separate_picture(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                                    const std::stop_token& stop) {
    if (request.palette.mixing == Mixing::Cover) {
        const auto picture = decode.grey(request.image.bytes, limits.max_pixels, stop);
        if (!picture) return about_image(picture.error(), request);
        return Separation{{picture->width, picture->height}, {ink_coverage(*picture, request.tone, request.invert)}};
    }
    const auto picture = decode.colour(request.image.bytes, limits.max_pixels, stop);
    if (!picture) return about_image(picture.error(), request);
    auto coverage = separate(*picture, ink_set(request.palette), request.tone, stop);
    if (auto going = check_stop(stop); !going) return tl::unexpected(going.error());
    return Separation{{picture->width, picture->height}, std::move(coverage)};
}

tl::unexpected<Error> nothing_to_draw(const HalftoneRequest& request) {
    const std::string looks = request.palette.mixing != Mixing::Cover ? "like its paper"
                              : request.invert                        ? "black"
                                                                      : "white";
    return failure(ErrorCode::Unusable, "the image is " + looks + " or transparent all over: there is nothing to draw",
                   request.image_field);
}

/// Makes the canvas. A chosen scale gives way to the limit; one that was asked for does not.
Result<Canvas> plan_canvas(const HalftoneRequest& request, const Box& box, double preferred_scale,
                           const Limits& limits) {
    if (!request.scale) return canvas_of(box, fitting_scale(box, preferred_scale, limits.max_pixels));
    const Canvas canvas = canvas_of(box, *request.scale);
    if (fits(canvas, limits.max_pixels)) return canvas;
    return failure(ErrorCode::LimitExceeded,
                   "scale makes an output of " + std::to_string(canvas.width) + " x " + std::to_string(canvas.height) +
                       " pixels; this server's limit (max-pixels) is " + std::to_string(limits.max_pixels),
                   "scale");
}

/// Makes a density for each ink that has sites. Coverages go as they are taken.
Result<std::vector<Density>> make_densities(Separation& separation, const std::vector<std::size_t>& sites) {
    std::vector<Density> densities(sites.size(), Density::uniform());
    for (std::size_t ink = 0; ink < sites.size(); ++ink) {
        const std::vector<float> coverage = std::exchange(separation.coverage[ink], {});
        if (sites[ink] == 0) continue;
        auto density = Density::grid(separation.picture.width, separation.picture.height, std::span(coverage));
        if (!density) return tl::unexpected(density.error());
        densities[ink] = *std::move(density);
    }
    return densities;
}

}  // namespace

Result<HalftonePlan> plan_halftone(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                                   const Control& control) {
    auto separation = separate_picture(request, limits, decode, control.stop);
    if (!separation) return tl::unexpected(separation.error());
    HalftonePlan plan;
    plan.picture = separation->picture;
    std::vector<double> ink(separation->coverage.size());
    std::ranges::transform(separation->coverage, ink.begin(), sum);
    const double all_ink = std::accumulate(ink.begin(), ink.end(), 0.0);
    if (!(all_ink > 0)) return nothing_to_draw(request);
    const std::size_t pixels = separation->coverage.front().size();
    for (const double each : ink) plan.cover.push_back(each / static_cast<double>(pixels));
    const std::size_t sites = request.sites ? *request.sites : default_sites(all_ink, limits.max_sites);
    plan.sites = share_sites(ink, sites);
    if (request.format->is_drawn()) {
        auto canvas = plan_canvas(request, plan.box(), default_scale(all_ink, pixels, sites), limits);
        if (!canvas) return tl::unexpected(canvas.error());
        plan.canvas = *canvas;
        if (auto checked = request.format->check_side(*canvas, "scale", "scale"); !checked)
            return tl::unexpected(checked.error());
    }
    auto densities = make_densities(*separation, plan.sites);
    if (!densities) return about_image(densities.error(), request);
    plan.densities = *std::move(densities);
    return plan;
}

Result<std::vector<Distribution>> place_dots(const HalftoneRequest& request, HalftonePlan& plan,
                                             const Control& control) {
    const std::vector<Density> densities = std::exchange(plan.densities, {});
    const auto domain = Domain::rectangle(plan.picture.width, plan.picture.height);
    if (!domain) return tl::unexpected(domain.error());
    auto dots = distribute_inks(*domain, densities, plan.sites, request.run, control);
    if (!dots) return about_image(dots.error(), request);
    for (const Distribution& each : *dots) {
        if (auto whole = check_whole(each, request.on_deadline); !whole) return about_image(whole.error(), request);
    }
    return dots;
}

}  // namespace ccdt::api
