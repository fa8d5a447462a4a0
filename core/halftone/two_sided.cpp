#include "core/halftone/two_sided.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/halftone/bilinear.h"
#include "core/halftone/blur.h"
#include "core/halftone/blur_pyramid.h"
#include "core/halftone/dot_plan.h"
#include "core/halftone/pixel_ranges.h"
#include "core/halftone/sharpening.h"

namespace ccdt {

namespace {

constexpr double kPi = std::numbers::pi;

/// Slope of CIE 1976 lightness, in [0, 1], over luminance.
float lightness_slope(float luminance) {
    constexpr float kLinearBelow = 216.0f / 24389.0f, kSlope = 24389.0f / 2700.0f;
    if (luminance <= kLinearBelow) return kSlope;
    const float root = std::cbrt(luminance);
    return 1.16f / 3 / (root * root);
}

/// Returns the area of a dot, up to a factor, that makes the pattern least visible.
/// @param cover  in (0, 1/2]
float relative_area(float cover, float luminance) {
    // Measured on eleven photographs by mean |dL*| after a blur of half a pitch; 0.03 to 0.1 do.
    constexpr float kVisibility = 0.05f, kNothing = 1e-6f;
    const float share = std::max(cover, kNothing);
    return share / std::log1p(share * lightness_slope(luminance) / kVisibility);
}

template <class Work>
void for_cells(Team& team, std::size_t cells, const Work& work) {
    for_ranges(team, cells, kPixelsOfTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) work(i);
    });
}

/// Mean light of the cells around one that lie wholly on white or wholly on black ground.
/// @param ground    1 for white, 0 for black
/// @param fallback  if there are none
float light_beside(const std::vector<float>& light, const std::vector<float>& white, const CellGrid& cells,
                   std::size_t cell, float ground, float fallback) {
    constexpr int kReach = 2;
    const int column = static_cast<int>(cell % static_cast<std::size_t>(cells.columns));
    const int row = static_cast<int>(cell / static_cast<std::size_t>(cells.columns));
    float sum = 0, count = 0;
    for (int y = std::max(row - kReach, 0); y <= std::min(row + kReach, cells.rows - 1); ++y) {
        for (int x = std::max(column - kReach, 0); x <= std::min(column + kReach, cells.columns - 1); ++x) {
            const std::size_t other =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(cells.columns) + static_cast<std::size_t>(x);
            if (white[other] != ground) continue;
            sum += light[other];
            ++count;
        }
    }
    return count > 0 ? sum / count : fallback;
}

/// Computes the share of each cell that the picture wants flipped: ink on white ground, paper on black ground.
///
/// A cell that the boundary crosses wants what the cells beside it do, on either side: nothing at an edge between black
/// and white, half of it where a smooth tone passes one half.
std::vector<float> wanted_share(const std::vector<float>& light, const std::vector<float>& white, const CellGrid& cells,
                                Team& team) {
    std::vector<float> share(light.size());
    for_cells(team, light.size(), [&](std::size_t i) {
        if (white[i] == 0 || white[i] == 1) {
            share[i] = std::abs(light[i] - white[i]);
        } else {
            const float on_white = light_beside(light, white, cells, i, 1, light[i]);
            const float on_black = light_beside(light, white, cells, i, 0, light[i]);
            share[i] = white[i] * (1 - on_white) + (1 - white[i]) * on_black;
        }
    });
    return share;
}

/// Leaves ground that is thinner than dots without dots, and takes the error that this makes off the dots beside it,
/// which are on the other side.
void spare_thin_ground(const std::vector<float>& white, const CellGrid& cells, double radius, std::vector<float>& share,
                       Team& team) {
    constexpr float kNothing = 1e-9f;
    std::vector<float> scratch, majority = white;
    blur(majority, cells.columns, cells.rows, radius, scratch, team);
    const auto is_thin = [&](std::size_t i) { return (white[i] > 0.5f) != (majority[i] > 0.5f); };
    // Signed, ink being positive: of thin ground, and of all other.
    std::vector<float> thin(share.size()), other(share.size());
    for_cells(team, share.size(),
              [&](std::size_t i) { (is_thin(i) ? thin : other)[i] = white[i] > 0.5f ? share[i] : -share[i]; });
    blur(thin, cells.columns, cells.rows, radius, scratch, team);
    blur(other, cells.columns, cells.rows, radius, scratch, team);
    for_cells(team, share.size(), [&](std::size_t i) {
        const float sign = white[i] > 0.5f ? 1.0f : -1.0f;
        const float own = std::max(sign * other[i], kNothing);
        share[i] = is_thin(i) ? 0 : share[i] * std::clamp(1 + sign * thin[i] / own, 0.0f, 1.0f);
    });
}

/// Computes areas of dots over that of the largest, by what is around each cell.
std::vector<float> relative_areas(const std::vector<float>& share, const std::vector<float>& light,
                                  const CellGrid& cells, double radius, Team& team) {
    // A small light in the dark is one dot rather than many tiny ones.
    constexpr float kOwn = 0.25f;
    constexpr double kSurroundings = 2;
    std::vector<float> scratch, area = share, around = light;
    blur(area, cells.columns, cells.rows, kSurroundings * radius, scratch, team);
    blur(around, cells.columns, cells.rows, kSurroundings * radius, scratch, team);
    for_cells(team, area.size(), [&](std::size_t i) {
        const float cover = std::clamp(std::max(area[i], kOwn * share[i]), 0.0f, 0.5f);
        area[i] = relative_area(cover, std::clamp(around[i], 0.0f, 1.0f));
    });
    float largest = 0;
    for (std::size_t i = 0; i < area.size(); ++i) {
        if (share[i] > 0) largest = std::max(largest, area[i]);
    }
    for_cells(team, area.size(), [&](std::size_t i) { area[i] = largest > 0 ? std::min(area[i] / largest, 1.0f) : 1; });
    return area;
}

/// Settles the number of dots, the area of the largest, and that of the smallest over it.
struct Scale {
    double dots = 0;
    double unit = 0;  ///< area of a dot of relative area 1, in cells
    float least = 0;  ///< relative area of the smallest dots
};

Scale settle(const std::vector<float>& share, const std::vector<float>& area, const TwoSidedOptions& options,
             Team& team) {
    constexpr float kLeastArea = 0.05f;
    constexpr int kRounds = 3;
    Scale scale;
    scale.least = kLeastArea;
    for (int round = 0; round < kRounds; ++round) {
        const double units = sum_of_pixels(team, share.size(), [&](std::size_t i) {
            return static_cast<double>(share[i] / std::max(area[i], scale.least));
        });
        scale.unit = options.radius ? std::max(kPi * *options.radius * *options.radius, kLeastDotArea)
                                    : units / static_cast<double>(*options.sites);
        if (!(scale.unit > 0)) return {};
        scale.dots = units / scale.unit;
        const double least = kPi * options.least_radius * options.least_radius / scale.unit;
        scale.least = static_cast<float>(std::clamp(least, static_cast<double>(kLeastArea), 1.0));
    }
    return scale;
}

/// Radius that dots would have if all had one size, in cells.
double mean_radius(const std::vector<float>& light, const TwoSidedOptions& options, Team& team) {
    if (options.radius) return *options.radius;
    const double minority = sum_of_pixels(
        team, light.size(), [&](std::size_t i) { return static_cast<double>(std::min(light[i], 1 - light[i])); });
    return std::sqrt(minority / (kPi * static_cast<double>(*options.sites)));
}

/// Fits the areas of dots to the picture.
class DotFit {
public:
    DotFit(const TwoSidedPlan& plan, std::span<const Point> sites, Team& team)
        : plan_(plan), sites_(sites), team_(team) {
        const auto at = [&](const std::vector<float>& values, const Point& site) {
            return interpolated(values, plan.cells.columns, plan.cells.rows, site);
        };
        const double sum = sum_of_pixels(team, plan.density.size(),
                                         [&](std::size_t i) { return static_cast<double>(plan.density[i]); });
        const auto least = std::max(static_cast<float>(kLeastDensity * sum / static_cast<double>(plan.density.size())),
                                    std::numeric_limits<float>::min());
        const auto unit = static_cast<float>(sum / static_cast<double>(sites.size()));
        for (const Point& site : sites) {
            planned_.push_back(at(plan.area, site));
            ground_per_dot_.push_back(unit / std::max(at(plan.density, site), least));
        }
        areas_ = planned_;
        cut_.resize(sites.size());
        find_cut();
    }

    const std::vector<float>& areas() const { return areas_; }

    /// Changes the area of each dot by the error of the local mean of what is drawn, times the ground that it stands
    /// for. Long waves of error vanish at once, those of the length of a spacing after some rounds.
    void improve() {
        std::vector<float> error(plan_.white);
        for_cells(team_, error.size(), [&](std::size_t i) { error[i] -= plan_.light[i]; });
        for (std::size_t dot = 0; dot < sites_.size(); ++dot) print(dot, error);
        const float widest = *std::ranges::max_element(ground_per_dot_);
        const BlurPyramid means(std::move(error), plan_.cells.columns, plan_.cells.rows, spread(widest), team_);
        for_cells(team_, sites_.size(), [&](std::size_t dot) {
            constexpr float kStep = 0.85f, kSmallest = 0.25f, kLargest = 2.5f, kNoise = 0.004f;
            const float ground = ground_per_dot_[dot];
            const float sign = cut_[dot].brightening - cut_[dot].darkening;
            const float mean = means.at(sites_[dot], spread(ground)) * ground;
            const float excess = std::max(std::abs(mean) - kNoise * planned_[dot], 0.0f);
            const float change = -kStep * sign * std::copysign(excess, mean);
            areas_[dot] = std::clamp(areas_[dot] + change, kSmallest * planned_[dot], kLargest * planned_[dot]);
        });
    }

    bool is_cut(std::size_t dot) const { return cut_[dot].brightening * cut_[dot].darkening > 0; }

    /// Finds where the boundary of the ground cuts dots of their present sizes.
    void find_cut() {
        for_cells(team_, sites_.size(), [&](std::size_t dot) { cut_[dot] = cut_of(dot); });
    }

    Side side(std::size_t dot) const { return plan_.ground.is_white(sites_[dot]) ? Side::Ink : Side::Paper; }

private:
    /// Ground that a dot in the emptiest places stands for, at most, over the mean, is 1 / this.
    static constexpr double kLeastDensity = 1e-4;

    /// Standard deviation of the blur by which a dot is judged: the spacing there.
    static double spread(float ground) { return std::sqrt(static_cast<double>(ground)); }

    static double radius(float area) { return std::sqrt(static_cast<double>(area) / kPi); }

    /// Parts of a dot on black ground, which it brightens, and on white ground, which it darkens.
    struct Cut {
        float brightening = 0;       ///< share of the dot's area
        float darkening = 0;         ///< share of the dot's area
        Point brightened, darkened;  ///< centroids of the parts, from the dot's centre, in radii
    };

    Cut cut_of(std::size_t dot) const {
        constexpr double kMargin = 1.1;  // of the radius, so that small changes keep the answer
        const bool white = plan_.ground.is_white(sites_[dot]);
        const double reach = radius(areas_[dot]);
        if (std::ranges::all_of(rim(), [&](const Point& way) {
                return plan_.ground.is_white(sites_[dot] + kMargin * reach * way) == white;
            }))
            return white ? Cut{0, 1, {}, {}} : Cut{1, 0, {}, {}};
        Cut cut;
        int brightened = 0;
        for (const Point& sample : disc()) {
            const bool darkens = plan_.ground.is_white(sites_[dot] + reach * sample);
            Point& sum = darkens ? cut.darkened : cut.brightened;
            sum = sum + sample;
            brightened += darkens ? 0 : 1;
        }
        cut.brightening = static_cast<float>(brightened) / kSamples;
        cut.darkening = 1 - cut.brightening;
        if (brightened > 0) cut.brightened = 1.0 / brightened * cut.brightened;
        if (brightened < kSamples) cut.darkened = 1.0 / (kSamples - brightened) * cut.darkened;
        return cut;
    }

    /// Adds the light of a dot to an image of what is drawn, less what should be.
    void print(std::size_t dot, std::vector<float>& image) const {
        const Cut& cut = cut_[dot];
        const float area = areas_[dot];
        const double reach = radius(area);
        if (cut.brightening == 0 || cut.darkening == 0)
            return spread_over(sites_[dot], reach, (cut.brightening - cut.darkening) * area, image);
        add(sites_[dot] + reach * cut.brightened, cut.brightening * area, image);
        add(sites_[dot] + reach * cut.darkened, -cut.darkening * area, image);
    }

    /// Adds an amount of light at four places, which have the mean and the variance of a disc.
    void spread_over(Point centre, double radius, float amount, std::vector<float>& image) const {
        const double reach = radius / 2;
        for (const double y : {-reach, reach}) {
            for (const double x : {-reach, reach}) add(centre + Point{x, y}, amount / 4, image);
        }
    }

    void add(Point place, float amount, std::vector<float>& image) const {
        const BetweenPixels x(place.x, plan_.cells.columns), y(place.y, plan_.cells.rows);
        const auto columns = static_cast<std::size_t>(plan_.cells.columns);
        float *upper = image.data() + y.first * columns, *lower = image.data() + y.second * columns;
        const float below = amount * y.share, above = amount - below;
        upper[x.first] += above * (1 - x.share);
        upper[x.second] += above * x.share;
        lower[x.first] += below * (1 - x.share);
        lower[x.second] += below * x.share;
    }

    static constexpr int kSamples = 32, kRim = 8;

    /// Directions all around.
    static const std::array<Point, kRim>& rim() {
        static const auto ways = [] {
            std::array<Point, kRim> result;
            for (int k = 0; k < kRim; ++k) {
                const double angle = 2 * kPi * k / kRim;
                result[static_cast<std::size_t>(k)] = {std::cos(angle), std::sin(angle)};
            }
            return result;
        }();
        return ways;
    }

    /// Places spread evenly over the unit disc, by a spiral with the golden angle.
    static const std::array<Point, kSamples>& disc() {
        static const auto places = [] {
            constexpr double kGoldenAngle = 2.399963229728653;
            std::array<Point, kSamples> result;
            for (int k = 0; k < kSamples; ++k) {
                const double distance = std::sqrt((k + 0.5) / kSamples), angle = kGoldenAngle * k;
                result[static_cast<std::size_t>(k)] = {distance * std::cos(angle), distance * std::sin(angle)};
            }
            return result;
        }();
        return places;
    }

    const TwoSidedPlan& plan_;
    std::span<const Point> sites_;
    Team& team_;
    std::vector<float> planned_;         ///< [dots] area
    std::vector<float> areas_;           ///< [dots]
    std::vector<float> ground_per_dot_;  ///< [dots] area of the picture that each stands for
    std::vector<Cut> cut_;               ///< [dots]
};

}  // namespace

TwoSidedPlan plan_two_sided(std::vector<float> light, const CellGrid& cells, const TwoSidedOptions& options,
                            const std::stop_token& stop, Team& team) {
    assert(options.sites || options.radius);
    const double radius = mean_radius(light, options, team);
    TwoSidedPlan plan{cells, divide_ground(light, cells, radius, options.detail, team), std::move(light), {}, {}, {}, 0,
                      0};
    if (stop.stop_requested()) return plan;
    const std::vector<float> sharp = sharpened(plan.light, cells.columns, cells.rows, options.detail * radius, team);
    plan.white = plan.ground.white_shares(team);
    plan.density = wanted_share(sharp, plan.white, cells, team);
    spare_thin_ground(plan.white, cells, radius, plan.density, team);
    if (stop.stop_requested()) return plan;
    plan.area = relative_areas(plan.density, sharp, cells, radius, team);
    const Scale scale = settle(plan.density, plan.area, options, team);
    plan.dots = scale.dots;
    plan.radius = std::sqrt(scale.unit / kPi);
    for_cells(team, plan.area.size(), [&](std::size_t i) {
        const float area = std::max(plan.area[i], scale.least);
        plan.density[i] /= area;
        plan.area[i] = area * static_cast<float>(scale.unit);
    });
    return plan;
}

SidedDots size_dots(const TwoSidedPlan& plan, std::span<const Point> sites, bool fit, const std::stop_token& stop,
                    Team& team) {
    SidedDots dots;
    if (sites.empty()) return dots;
    constexpr int kRounds = 14, kRoundsOfCut = 4;
    DotFit sizes(plan, sites, team);
    for (int round = 0; fit && round < kRounds && !stop.stop_requested(); ++round) {
        if (round > 0 && round % kRoundsOfCut == 0) sizes.find_cut();
        sizes.improve();
    }
    sizes.find_cut();
    for (std::size_t dot = 0; dot < sites.size(); ++dot) {
        dots.radii.push_back(static_cast<float>(std::sqrt(static_cast<double>(sizes.areas()[dot]) / kPi)));
        dots.sides.push_back(sizes.side(dot));
        dots.cut.push_back(sizes.is_cut(dot));
    }
    return dots;
}

}  // namespace ccdt
