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

#include "core/ccdt/plane/construction.h"
#include "core/density/density.h"
#include "core/halftone/field/dot_plan.h"
#include "core/halftone/field/field_drawing.h"
#include "core/halftone/field/field_plan.h"
#include "core/halftone/inks/separation.h"
#include "core/library/conversion.h"
#include "core/picture/picture.h"
#include "core/picture/pixel_ranges.h"
#include "core/picture/reduction.h"
#include "core/picture/srgb.h"
#include "core/picture/tone.h"

namespace ccdt::v2 {
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
        if (options_.sides == Sides::Both) {
            draw_areas(result);
        } else {
            draw_discs(result);
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

    /// Places the points.
    void position(const std::vector<float>& density, Halftone& result) {
        execution_.check_stop();
        const auto domain = value_of(ccdt::Domain::rectangle(picture_.width, picture_.height));
        const auto grid = value_of(ccdt::Density::grid(cells_.columns, cells_.rows, std::span<const float>(density)));
        const auto placed =
            value_of(ccdt::distribute_inks(domain, {&grid, 1}, {&run_.sites, 1}, run_, execution_.control()));
        result.stopped = placed.front().stopped;
        if (result.stopped && !options_.partial) execution_.check_stop();
        for (const auto& point : placed.front().points) result.points.push_back({point.x, point.y});
    }

    /// Draws discs of ink or of paper, all of one size.
    void draw_discs(Halftone& result) {
        std::vector<float> coverage = grey_coverage();
        const double drawn = ccdt::sum_of(execution_.executor(), coverage);
        if (!(drawn > 0)) refuse();
        choose_cells(drawn);
        Coverage cover;
        cover.push_back(in_cells(std::move(coverage)));
        const auto plan =
            ccdt::plan_dots(std::move(cover), cells_.columns, cells_.rows, {run_.sites, {}, options_.detail},
                            execution_.control().stop, execution_.executor());
        position(plan.density.front(), result);
        result.radius = plan.radius * std::sqrt(cell_area());
    }

    /// Draws areas of ink by one field.
    void draw_areas(Halftone& result) {
        choose_cells(ccdt::kDrawnShare * pixels());
        Coverage light = channel_coverage();
        const bool is_white = std::ranges::all_of(light, [](const std::vector<float>& channel) {
            return std::ranges::all_of(channel, [](float share) { return share == 0; });
        });
        if (is_white) refuse();
        for (auto& channel : light) {
            for (float& share : channel) share = 1 - share;
        }
        const auto plan = ccdt::plan_field(std::move(light), cells_, {run_.sites, {}, options_.detail},
                                           execution_.control().stop, execution_.executor());
        run_.quality = ccdt::quality_of_sites(run_.quality);
        if (plan.sites > 0) position(plan.density, result);
        if (!options_.partial) execution_.check_stop();
        const double across = static_cast<double>(picture_.width) / cells_.columns;
        const double down = static_cast<double>(picture_.height) / cells_.rows;
        std::vector<ccdt::Point> sites;
        for (const Point& point : result.points) sites.push_back({point.x / across, point.y / down});
        // A stop leaves the areas as they are after the completed rounds of the fit.
        const ccdt::FieldDrawing drawing(plan, sites, std::nullopt, execution_.control().stop, execution_.executor());
        if (!options_.partial) execution_.check_stop();
        result.stopped = result.stopped || execution_.control().stop.stop_requested();
        for (const auto& channel : drawing.outlines()) {
            auto& rings = result.rings.emplace_back();
            for (const auto& ring : channel) {
                Ring& corners = rings.emplace_back();
                for (const auto& p : ring) corners.push_back({picture_.width * p.x, picture_.height * p.y});
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

}  // namespace ccdt::v2
