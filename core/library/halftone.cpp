// SPDX-License-Identifier: GPL-3.0-or-later
#include "ccdt/halftone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <type_traits>
#include <utility>

#include "core/ccdt/construction.h"
#include "core/density/density.h"
#include "core/halftone/dot_fit.h"
#include "core/halftone/dot_plan.h"
#include "core/halftone/ground_outline.h"
#include "core/halftone/picture.h"
#include "core/halftone/pixel_ranges.h"
#include "core/halftone/reduction.h"
#include "core/halftone/separation.h"
#include "core/halftone/srgb.h"
#include "core/halftone/tone.h"
#include "core/halftone/two_sided.h"
#include "core/library/conversion.h"

namespace ccdt::v1 {
namespace {

using Coverage = std::vector<std::vector<float>>;

std::size_t pixels_of(const PictureView& picture) {
    return static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
}

void check_picture(const PictureView& picture) {
    constexpr double kMaxSide = std::numeric_limits<int>::max();
    check_range(picture.width, 1, kMaxSide, "width");
    check_range(picture.height, 1, kMaxSide, "height");
    check_range(picture.channels, 1, 4, "channels");
    const std::size_t wanted = pixels_of(picture) * static_cast<std::size_t>(picture.channels);
    const std::size_t given = std::visit([](const auto& values) { return values.size(); }, picture.values);
    if (given == wanted) return;
    raise(FailureCode::Malformed,
          "a picture of " + std::to_string(picture.width) + " x " + std::to_string(picture.height) + " pixels with " +
              std::to_string(picture.channels) + " channels needs " + std::to_string(wanted) + " values, not " +
              std::to_string(given),
          "values");
}

/// Converts options to those of core. Throws for an option out of range.
ccdt::Options run_options(std::size_t sites, const HalftoneOptions& options) {
    ccdt::Options run;
    run.sites = sites;
    run.seed = options.seed;
    run.quality = core_quality(options.quality);
    run.keep_steps = false;
    if (const auto checked = ccdt::check(run); !checked) raise(checked.error());
    check_range(options.detail, 0, 1, "detail");
    if (options.quality == Quality::Stealthy)
        raise(FailureCode::Malformed, "quality cannot be Stealthy for a halftone, whose density varies", "quality");
    if (options.colour && options.sides != Sides::Both)
        raise(FailureCode::Malformed, "colour requires Sides::Both", "colour");
    return run;
}

/// Converts the pixels of a picture to planes of linear light, as the decoder does for files.
template <class Value>
class PlaneMaker {
public:
    PlaneMaker(const PictureView& picture, std::span<const Value> values, const HalftoneOptions& options)
        : values_(values),
          size_(pixels_of(picture)),
          channels_(static_cast<std::size_t>(picture.channels)),
          is_displayed_(options.alpha == Alpha::Display && picture.channels % 2 == 0),
          ground_(options.sides == Sides::Paper ? 0 : 1) {
        if constexpr (std::is_same_v<Value, std::uint8_t>) {
            for (std::size_t i = 0; i < light_.size(); ++i)
                light_[i] = ccdt::light_of_srgb(share(static_cast<Value>(i)));
        }
    }

    ccdt::Picture grey() const {
        if (channels_ < 3) return {0, 0, light(0), alpha()};
        return {0, 0, plane([this](std::size_t pixel) {
                    return std::min(ccdt::luminance_of(light_of(pixel, 0), light_of(pixel, 1), light_of(pixel, 2)),
                                    1.0F);
                }),
                alpha()};
    }

    ccdt::ColourPicture colour() const {
        if (channels_ >= 3) return {0, 0, light(0), light(1), light(2), alpha()};
        const ccdt::Plane grey = light(0);
        return {0, 0, grey, grey, grey, alpha()};
    }

private:
    static float share(Value value) {
        if constexpr (std::is_same_v<Value, std::uint8_t>) {
            return static_cast<float>(value) / std::numeric_limits<Value>::max();
        } else {
            return ccdt::to_share(value);
        }
    }

    float light_of(Value value) const {
        if constexpr (std::is_same_v<Value, std::uint8_t>) {
            return light_[value];
        } else {
            return share(value);
        }
    }

    /// Returns the light of a pixel; with Alpha::Display, as it looks on the ground.
    float light_of(std::size_t pixel, std::size_t channel) const {
        const float own = light_of(values_[pixel * channels_ + channel]);
        return is_displayed_ ? ccdt::displayed_light(own, ground_, alpha_of(pixel)) : own;
    }

    float alpha_of(std::size_t pixel) const { return share(values_[pixel * channels_ + channels_ - 1]); }

    template <class Function>
    ccdt::Plane plane(const Function& value) const {
        const auto values = std::make_shared<float[]>(size_);
        for (std::size_t pixel = 0; pixel < size_; ++pixel) values[static_cast<std::ptrdiff_t>(pixel)] = value(pixel);
        return {values, size_};
    }

    ccdt::Plane light(std::size_t channel) const {
        return plane([&](std::size_t pixel) { return light_of(pixel, channel); });
    }

    ccdt::Plane alpha() const {
        if (channels_ % 2 != 0) return {};
        return plane([this](std::size_t pixel) {
            const float alpha = alpha_of(pixel);
            return is_displayed_ && alpha > 0 ? 1 : alpha;
        });
    }

    std::span<const Value> values_;
    std::size_t size_;
    std::size_t channels_;
    bool is_displayed_;               ///< whether partly transparent pixels are shown on the ground, and become opaque
    float ground_;                    ///< sRGB value, black or white
    std::array<float, 256> light_{};  ///< light of each byte; unused for floats
};

/// Computes a halftone, in the steps of the service.
class Halftoning {
public:
    Halftoning(const PictureView& picture, std::size_t sites, const HalftoneOptions& options, const Control& control)
        : picture_(picture), options_(options), run_(run_options(sites, options)), execution_(control) {}

    Halftone run() {
        Halftone result;
        result.width = picture_.width;
        result.height = picture_.height;
        result.channels = options_.colour ? 3 : 1;
        result.black.resize(static_cast<std::size_t>(result.channels));
        if (options_.sides == Sides::Both) {
            draw_both(result);
        } else {
            draw_one(result);
        }
        return result;
    }

private:
    bool draws_paper() const { return options_.sides == Sides::Paper; }
    double pixels() const { return static_cast<double>(pixels_of(picture_)); }

    ccdt::Tone tone() const {
        return options_.tone == Reproduction::Lightness ? ccdt::Tone::Perceptual : ccdt::Tone::Linear;
    }

    /// Chooses the cells of the computation, as fine as dots can show.
    /// @param drawn  area that dots cover, in pixels
    void choose_cells(double drawn) {
        const double radius = std::sqrt(drawn / (std::numbers::pi * static_cast<double>(run_.sites)));
        cells_ = ccdt::resolved_cells(picture_.width, picture_.height, radius);
    }

    double cell_area() const { return pixels() / (static_cast<double>(cells_.columns) * cells_.rows); }

    ccdt::Picture grey_picture() const {
        auto made = std::visit([&](const auto& values) { return PlaneMaker(picture_, values, options_).grey(); },
                               picture_.values);
        made.width = picture_.width;
        made.height = picture_.height;
        return made;
    }

    ccdt::ColourPicture colour_picture() const {
        auto made = std::visit([&](const auto& values) { return PlaneMaker(picture_, values, options_).colour(); },
                               picture_.values);
        made.width = picture_.width;
        made.height = picture_.height;
        return made;
    }

    /// Returns the share of each pixel that dots should cover [pixels].
    std::vector<float> grey_coverage() {
        return ccdt::ink_coverage(grey_picture(), tone(), draws_paper(), execution_.executor());
    }

    std::vector<float> in_cells(std::vector<float> coverage) {
        if (cells_ == ccdt::CellGrid{picture_.width, picture_.height}) return coverage;
        return ccdt::reduced(coverage, picture_.width, picture_.height, cells_, execution_.executor());
    }

    /// Returns the share of light that dots should remove in each channel [channels][cells].
    Coverage channel_coverage() {
        if (!options_.colour) return {in_cells(grey_coverage())};
        auto picture = colour_picture();
        if (cells_ != ccdt::CellGrid{picture_.width, picture_.height})
            picture = ccdt::reduced(picture, cells_, execution_.executor());
        return ccdt::channel_coverage(picture, {}, tone(), execution_.executor());
    }

    [[noreturn]] void refuse() const {
        raise(FailureCode::Unusable,
              std::string("the picture is ") + (draws_paper() ? "black" : "white") +
                  " or transparent everywhere: there is nothing to draw",
              "values");
    }

    /// Distributes the dots of each kind.
    std::vector<ccdt::Distribution> place(std::span<const ccdt::Density> densities,
                                          std::span<const std::size_t> sites) {
        execution_.check_stop();
        const auto domain = value_of(ccdt::Domain::rectangle(picture_.width, picture_.height));
        auto placed = value_of(ccdt::distribute_inks(domain, densities, sites, run_, execution_.control()));
        const bool stopped = std::ranges::any_of(placed, &ccdt::Distribution::stopped);
        if (stopped && !options_.partial) execution_.check_stop();
        return placed;
    }

    /// Draws ink dots or paper dots, all of one size.
    void draw_one(Halftone& result) {
        std::vector<float> coverage = grey_coverage();
        const double drawn = ccdt::sum_of_pixels(execution_.executor(), coverage.size(),
                                                 [&](std::size_t i) { return static_cast<double>(coverage[i]); });
        if (!(drawn > 0)) refuse();
        choose_cells(drawn);
        Coverage cover;
        cover.push_back(in_cells(std::move(coverage)));
        const auto plan =
            ccdt::plan_dots(std::move(cover), cells_.columns, cells_.rows, {run_.sites, {}, options_.detail},
                            execution_.control().stop, execution_.executor());
        execution_.check_stop();
        const auto density =
            value_of(ccdt::Density::grid(cells_.columns, cells_.rows, std::span<const float>(plan.density.front())));
        const auto placed = place({&density, 1}, {&run_.sites, 1});
        const auto radius = static_cast<float>(plan.radius * std::sqrt(cell_area()));
        const auto white = static_cast<std::uint8_t>(draws_paper() ? 0 : 1);
        for (const auto& point : placed.front().points) result.dots.push_back({{point.x, point.y}, radius, 1, white});
        result.stopped = placed.front().stopped;
        const double right = picture_.width, bottom = picture_.height;
        if (draws_paper()) result.black.front() = {{{0, 0}, {right, 0}, {right, bottom}, {0, bottom}}};
    }

    /// Draws dots on both sides of the tonal scale.
    void draw_both(Halftone& result) {
        // The area that dots draw is measured in cells, whose size follows from the radius. A quarter of the picture is
        // assumed.
        constexpr double kShare = 0.25;
        choose_cells(kShare * pixels());
        Coverage light = channel_coverage();
        const bool has_dots = ccdt::minority_area(light, execution_.executor()) > 0;
        const bool is_white = std::ranges::all_of(light, [](const std::vector<float>& channel) {
            return std::ranges::all_of(channel, [](float share) { return share == 0; });
        });
        if (is_white) refuse();
        for (auto& channel : light) {
            for (float& share : channel) share = 1 - share;
        }
        const auto plan = ccdt::plan_two_sided(std::move(light), cells_, {run_.sites, {}, options_.detail},
                                               execution_.control().stop, execution_.executor());
        execution_.check_stop();
        outline(plan, result);
        if (has_dots && plan.dots > 0) add_dots(plan, result);
    }

    void outline(const ccdt::TwoSidedPlan& plan, Halftone& result) const {
        const double across = static_cast<double>(picture_.width) / cells_.columns;
        const double down = static_cast<double>(picture_.height) / cells_.rows;
        for (std::size_t channel = 0; channel < result.black.size(); ++channel) {
            for (const auto& ring : ccdt::outline_of(plan.channels[channel].ground)) {
                Ring& corners = result.black[channel].emplace_back();
                for (const auto& corner : ring) corners.push_back({across * corner.x, down * corner.y});
            }
        }
    }

    void add_dots(const ccdt::TwoSidedPlan& plan, Halftone& result) {
        std::vector<double> shares;
        for (const auto& kind : plan.kinds) shares.push_back(kind.share);
        const std::vector<std::size_t> sites = ccdt::share_sites(shares, run_.sites);
        std::vector<ccdt::Density> densities(sites.size(), ccdt::Density::uniform());
        for (std::size_t kind = 0; kind < sites.size(); ++kind) {
            const std::span<const float> values = plan.kinds[kind].density;
            if (sites[kind] > 0)
                densities[kind] = value_of(ccdt::Density::grid(plan.dot_cells.columns, plan.dot_cells.rows, values));
        }
        const auto placed = place(densities, sites);
        std::vector<std::vector<ccdt::Point>> points;
        points.reserve(placed.size());
        for (const auto& kind : placed) points.push_back(kind.points);
        const ccdt::Point size{static_cast<double>(picture_.width), static_cast<double>(picture_.height)};
        const auto sized = ccdt::size_dots_in_pixels(plan, size, std::move(points), true, execution_.control().stop,
                                                     execution_.executor());
        // A stop leaves the radii as they are after the completed rounds of the fit.
        if (!options_.partial) execution_.check_stop();
        result.stopped = execution_.control().stop.stop_requested();
        for (std::size_t kind = 0; kind < placed.size(); ++kind) {
            const auto flips = static_cast<std::uint8_t>(plan.kinds[kind].flips);
            result.stopped = result.stopped || placed[kind].stopped;
            for (std::size_t i = 0; i < placed[kind].points.size(); ++i) {
                const auto [x, y] = placed[kind].points[i];
                result.dots.push_back({{x, y}, sized[kind].radii[i], flips, sized[kind].white[i]});
            }
        }
    }

    const PictureView& picture_;
    const HalftoneOptions& options_;
    ccdt::Options run_;
    Execution execution_;
    ccdt::CellGrid cells_;
};

}  // namespace

Halftone halftone(const PictureView& picture, std::size_t sites, const HalftoneOptions& options,
                  const Control& control) {
    check_picture(picture);
    return Halftoning(picture, sites, options, control).run();
}

}  // namespace ccdt::v1
