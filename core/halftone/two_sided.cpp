// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/two_sided.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "core/halftone/bilinear.h"
#include "core/halftone/blur.h"
#include "core/halftone/blur_pyramid.h"
#include "core/halftone/dot_plan.h"
#include "core/halftone/kind_mixture.h"
#include "core/halftone/pixel_ranges.h"
#include "core/halftone/sharpening.h"
#include "core/halftone/visibility.h"

namespace ccdt {

namespace {

constexpr double kPi = std::numbers::pi;

/// Returns the area of a dot, up to a factor, that makes the pattern least visible.
/// @param cover       in (0, 1/2]
/// @param visibility  of the dots
float relative_area(float cover, float visibility) {
    // Measured on eleven photographs by mean |dL*| after a blur of half a pitch; 0.03 to 0.1 do.
    constexpr float kVisibility = 0.05f, kNothing = 1e-6f;
    const float share = std::max(cover, kNothing);
    return share / std::log1p(share * visibility / kVisibility);
}

template <class Work>
void for_cells(Executor& executor, std::size_t cells, const Work& work) {
    for_ranges(executor, cells, kPixelsOfTask, [&](std::size_t begin, std::size_t end) {
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
                                Executor& executor) {
    std::vector<float> share(light.size());
    for_cells(executor, light.size(), [&](std::size_t i) {
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
                       Executor& executor) {
    constexpr float kNothing = 1e-9f;
    std::vector<float> scratch, majority = white;
    blur(majority, cells.columns, cells.rows, radius, scratch, executor);
    const auto is_thin = [&](std::size_t i) { return (white[i] > 0.5f) != (majority[i] > 0.5f); };
    // Signed, ink being positive: of thin ground, and of all other.
    std::vector<float> thin(share.size()), other(share.size());
    for_cells(executor, share.size(),
              [&](std::size_t i) { (is_thin(i) ? thin : other)[i] = white[i] > 0.5f ? share[i] : -share[i]; });
    blur(thin, cells.columns, cells.rows, radius, scratch, executor);
    blur(other, cells.columns, cells.rows, radius, scratch, executor);
    for_cells(executor, share.size(), [&](std::size_t i) {
        const float sign = white[i] > 0.5f ? 1.0f : -1.0f;
        const float own = std::max(sign * other[i], kNothing);
        share[i] = is_thin(i) ? 0 : share[i] * std::clamp(1 + sign * thin[i] / own, 0.0f, 1.0f);
    });
}

/// A number for each channel.
using Channels = std::array<float, kMostInks>;

/// Values of all channels in a cell.
std::span<const float> at_cell(std::span<const std::vector<float>> planes, std::size_t cell, Channels& values) {
    for (std::size_t c = 0; c < planes.size(); ++c) values[c] = planes[c][cell];
    return {values.data(), planes.size()};
}

/// Share that dots of a kind flip, where the flipped areas of channels are nested.
/// @param shares  of each channel
float nested_share(std::span<const float> shares, unsigned flips) {
    float within = 1, beyond = 0;
    for (std::size_t c = 0; c < shares.size(); ++c) {
        if ((flips >> c & 1) != 0) {
            within = std::min(within, shares[c]);
        } else {
            beyond = std::max(beyond, shares[c]);
        }
    }
    return std::max(within - beyond, 0.0f);
}

/// Makes the areas of dots relative to that of the largest.
void normalize_areas(std::vector<KindOfDots>& kinds, Executor& executor) {
    float largest = 0;
    for (const KindOfDots& kind : kinds) {
        for (std::size_t i = 0; i < kind.area.size(); ++i) {
            if (kind.density[i] > 0) largest = std::max(largest, kind.area[i]);
        }
    }
    for (KindOfDots& kind : kinds) {
        for_cells(executor, kind.area.size(),
                  [&](std::size_t i) { kind.area[i] = largest > 0 ? std::min(kind.area[i] / largest, 1.0f) : 1; });
    }
}

/// Radius of the surroundings that dots share in showing a place, in radii of dots.
constexpr double kSurroundings = 2;

/// Share of the surroundings that a place counts for at least: a small light in the dark is one dot rather than many
/// tiny ones.
constexpr float kOwn = 0.25f;

/// Plans the areas of dots, and how dense they are.
class KindPlan {
public:
    /// @param share  [channels][cells] that is to be flipped
    KindPlan(TwoSidedPlan& plan, std::span<const std::vector<float>> share, std::span<const std::vector<float>> light,
             double radius, Executor& executor)
        : plan_(plan), share_(share), executor_(executor) {
        std::vector<float> scratch;
        const auto surroundings = [&](const std::vector<float>& values) {
            std::vector<float> means = values;
            blur(means, plan.cells.columns, plan.cells.rows, kSurroundings * radius, scratch, executor);
            return means;
        };
        for (const auto& each : share) share_around_.push_back(surroundings(each));
        for (const auto& each : light) light_around_.push_back(surroundings(each));
    }

    /// Computes the shares of each kind, as its density, and areas of dots over that of the largest.
    void add_areas() {
        const std::size_t cells = share_.front().size();
        plan_.kinds.resize(kinds_of(share_.size()));
        for (std::size_t k = 0; k < plan_.kinds.size(); ++k)
            plan_.kinds[k] = {flips_of(k), std::vector<float>(cells), std::vector<float>(cells), 0};
        for_cells(executor_, cells, [&](std::size_t i) { add_areas(i); });
        normalize_areas(plan_.kinds, executor_);
    }

private:
    void add_areas(std::size_t cell) {
        Channels own_values{}, around_values{}, light{};
        const auto own = at_cell(share_, cell, own_values), around = at_cell(share_around_, cell, around_values);
        for (float& each : light) each = 0;
        at_cell(light_around_, cell, light);
        for (float& each : light) each = std::clamp(each, 0.0f, 1.0f);
        const Visibility visibility({light.data(), own.size()});
        unsigned white = 0;
        for (std::size_t c = 0; c < own.size(); ++c)
            white |= static_cast<unsigned>(plan_.channels[c].white[cell] > 0.5f) << c;
        for (std::size_t k = 0; k < plan_.kinds.size(); ++k) {
            const float share = nested_share(own, flips_of(k));
            const float cover = std::max(nested_share(around, flips_of(k)), kOwn * share);
            plan_.kinds[k].density[cell] = share;
            plan_.kinds[k].area[cell] = relative_area(std::clamp(cover, 0.0f, 0.5f), visibility.of(flips_of(k), white));
        }
    }

    TwoSidedPlan& plan_;
    std::span<const std::vector<float>> share_;
    std::vector<std::vector<float>> share_around_, light_around_;
    Executor& executor_;
};

/// Light of a cell, in [0, 1].
Light light_at(const LightPlanes& light, std::size_t cell) {
    const auto value = [&](std::size_t c) { return std::clamp(light[c][cell], 0.0f, 1.0f); };
    return {value(0), value(1), value(2)};
}

/// Plans dots of inks: shares of kinds whose mean colour is that of the picture.
class MixturePlan {
public:
    /// @param sigma  of the blur that the dots' places are sharpened against, in cells
    MixturePlan(TwoSidedPlan& plan, const InkSet& inks, const LightPlanes& light, double sigma, Executor& executor)
        : plan_(plan), executor_(executor) {
        for (std::size_t c = 0; c < light.size(); ++c)
            sharp_[c] = sharpened(light[c], plan.cells.columns, plan.cells.rows, sigma, executor);
        choose_kinds(inks);
    }

    /// Adds to the light of the surroundings what the ground of a cell keeps dots from making there.
    /// @param radius  of the dots, in cells
    void make_up(LightPlanes& wanted, double radius) {
        constexpr int kRounds = 2;
        std::vector<float> scratch;
        const LightPlanes picture = wanted;
        for (int round = 0; round < kRounds; ++round) {
            LightPlanes missing = picture;
            for_cells(executor_, cells(), [&](std::size_t i) {
                const unsigned ground = ground_of(i);
                const auto seen = mixture_->light(ground, mixture_->shares(ground, light_at(wanted, i)));
                for (std::size_t c = 0; c < 3; ++c) missing[c][i] -= seen[c];
            });
            for (std::size_t c = 0; c < 3; ++c) {
                blur(missing[c], plan_.cells.columns, plan_.cells.rows, kSurroundings * radius, scratch, executor_);
                for_cells(executor_, cells(), [&](std::size_t i) {
                    wanted[c][i] += missing[c][i];
                    sharp_[c][i] += missing[c][i];
                });
            }
        }
    }

    /// Sets what each ink shall leave bare, which the shares of the kinds make of it.
    void set_light(const LightPlanes& wanted) {
        for_cells(executor_, cells(), [&](std::size_t i) {
            Channels bare{};
            add_bare(0, 0, 1, i, light_at(wanted, i), bare);
            for (std::size_t c = 0; c < plan_.channels.size(); ++c) plan_.channels[c].light[i] = bare[c];
        });
    }

    /// Sets the shares of the kinds, as their densities. Cells that a boundary crosses have those of the cells beside
    /// them.
    void add_shares() {
        for_cells(executor_, cells(), [&](std::size_t i) {
            if (!is_whole(i)) return;
            const KindMixture::Shares shares = mixture_->shares(ground_of(i), light_at(sharp_, i));
            for (std::size_t k = 0; k < plan_.kinds.size(); ++k) plan_.kinds[k].density[i] = shares[k];
        });
        for_cells(executor_, cells(), [&](std::size_t i) {
            if (!is_whole(i)) take_shares_beside(i);
        });
    }

    /// Sets the relative areas of dots.
    /// @param radius  of the dots, in cells
    void add_areas(double radius) {
        constexpr float kLeastVisibility = 0.02f;  // an ink below black is not seen at all
        std::vector<float> scratch;
        LightPlanes around = sharp_;
        for (std::vector<float>& each : around)
            blur(each, plan_.cells.columns, plan_.cells.rows, kSurroundings * radius, scratch, executor_);
        for (std::size_t k = 0; k < plan_.kinds.size(); ++k) {
            KindOfDots& kind = plan_.kinds[k];
            kind.area = kind.density;
            blur(kind.area, plan_.cells.columns, plan_.cells.rows, kSurroundings * radius, scratch, executor_);
            for_cells(executor_, cells(), [&](std::size_t i) {
                const float cover = std::clamp(std::max(kind.area[i], kOwn * kind.density[i]), 0.0f, 0.5f);
                const auto [red, green, blue] = light_at(around, i);
                const float seen = Visibility(std::array{red, green, blue}).of(mixture_->change(ground_of(i), k));
                kind.area[i] = relative_area(cover, std::max(seen, kLeastVisibility));
            });
        }
        normalize_areas(plan_.kinds, executor_);
    }

private:
    std::size_t cells() const { return sharp_[0].size(); }

    /// Finds the inks of the ground of a cell, as bits.
    unsigned ground_of(std::size_t cell) const {
        unsigned inks = 0;
        for (std::size_t c = 0; c < plan_.channels.size(); ++c)
            inks |= static_cast<unsigned>(!(plan_.channels[c].white[cell] > 0.5f)) << c;
        return inks;
    }

    /// Tells whether no boundary crosses a cell.
    bool is_whole(std::size_t cell) const {
        return std::ranges::all_of(plan_.channels, [cell](const TwoSidedChannel& channel) {
            return channel.white[cell] == 0 || channel.white[cell] == 1;
        });
    }

    /// Chooses the kinds that cover most, as far as some thousand cells tell.
    void choose_kinds(const InkSet& inks) {
        constexpr std::size_t kSamples = 8192;
        const std::size_t all = kinds_of(inks.inks.size());
        std::vector<unsigned> flips(all);
        for (std::size_t k = 0; k < all; ++k) flips[k] = flips_of(k);
        KindMixture any(inks, flips);
        if (all > kMostKindsOfInks) {
            std::vector<double> sums(all, 0);
            const std::size_t step = std::max(cells() / kSamples, std::size_t{1});
            for (std::size_t i = 0; i < cells(); i += step) {
                const KindMixture::Shares shares = any.shares(ground_of(i), light_at(sharp_, i));
                for (std::size_t k = 0; k < all; ++k) sums[k] += static_cast<double>(shares[k]);
            }
            std::ranges::stable_sort(flips, std::ranges::greater(), [&](unsigned kind) { return sums[kind - 1]; });
            flips.resize(kMostKindsOfInks);
            std::ranges::sort(flips);
        }
        for (const unsigned kind : flips) plan_.kinds.push_back({kind, std::vector<float>(cells()), {}, 0});
        mixture_.emplace(inks, std::move(flips));
    }

    /// Adds what each ink leaves bare of a cell, from a channel on: of each ground that is there, by its share.
    void add_bare(std::size_t channel, unsigned ground, float weight, std::size_t cell, const Light& wanted,
                  Channels& bare) {
        if (channel < plan_.channels.size()) {
            const float white = plan_.channels[channel].white[cell];
            if (white > 0) add_bare(channel + 1, ground, weight * white, cell, wanted, bare);
            if (white < 1) add_bare(channel + 1, ground | 1U << channel, weight * (1 - white), cell, wanted, bare);
            return;
        }
        const KindMixture::Shares shares = mixture_->shares(ground, wanted);
        for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
            float flipped = 0;
            for (std::size_t k = 0; k < plan_.kinds.size(); ++k) {
                if ((plan_.kinds[k].flips >> c & 1) != 0) flipped += shares[k];
            }
            bare[c] += weight * ((ground >> c & 1) != 0 ? flipped : 1 - flipped);
        }
    }

    /// Gives a cell the mean shares of the whole cells around it, or its own if there are none.
    void take_shares_beside(std::size_t cell) {
        constexpr std::size_t kReach = 2;
        const auto columns = static_cast<std::size_t>(plan_.cells.columns);
        const auto rows = static_cast<std::size_t>(plan_.cells.rows);
        const std::size_t column = cell % columns, row = cell / columns;
        KindMixture::Shares sum{};
        float count = 0;
        for (std::size_t y = row - std::min(row, kReach); y <= std::min(row + kReach, rows - 1); ++y) {
            for (std::size_t x = column - std::min(column, kReach); x <= std::min(column + kReach, columns - 1); ++x) {
                if (!is_whole(y * columns + x)) continue;
                for (std::size_t k = 0; k < plan_.kinds.size(); ++k) sum[k] += plan_.kinds[k].density[y * columns + x];
                ++count;
            }
        }
        if (count == 0) sum = mixture_->shares(ground_of(cell), light_at(sharp_, cell));
        for (std::size_t k = 0; k < plan_.kinds.size(); ++k)
            plan_.kinds[k].density[cell] = sum[k] / std::max(count, 1.0f);
    }

    TwoSidedPlan& plan_;
    Executor& executor_;
    LightPlanes sharp_;
    std::optional<KindMixture> mixture_;
};

/// Chooses grounds of inks on which dots can make the picture: inks that each cover less than a half may take more than
/// half of the light together.
class InkGrounds {
public:
    InkGrounds(const InkSet& inks, const LightPlanes& wanted, Executor& executor)
        : inks_(inks.inks.size()), wanted_(wanted), executor_(executor), mixture_(inks, all_kinds(inks_)) {}

    /// Turns grounds over where dots on them would cover too much, but leaves them near to a half.
    /// @param bare  [inks][cells] what inks leave bare
    void settle(std::vector<std::vector<float>>& bare) {
        constexpr float kMostCover = 0.5f, kOff = 0.15f;
        for_cells(executor_, bare.front().size(), [&](std::size_t i) {
            const unsigned ground = ground_of(bare, i);
            if (cover(ground, i) <= kMostCover) return;
            const unsigned turned = ground ^ best_near(bare, ground, i);
            for (std::size_t c = 0; c < inks_; ++c) {
                if ((turned >> c & 1) != 0) bare[c][i] = bare[c][i] > 0.5f ? 0.5f - kOff : 0.5f + kOff;
            }
        });
    }

    /// Makes sure of better grounds where dots cannot make the picture on those of a plan.
    /// @returns  whether there are such places
    bool repair(std::vector<std::vector<float>>& bare, const TwoSidedPlan& plan) {
        std::vector<std::uint8_t> is_bad(bare.front().size(), 0);
        for_cells(executor_, is_bad.size(), [&](std::size_t i) {
            unsigned ground = 0;
            for (std::size_t c = 0; c < inks_; ++c)
                ground |= static_cast<unsigned>(!(plan.channels[c].white[i] > 0.5f)) << c;
            if (!is_off(ground, i)) return;
            const unsigned best = best_near(bare, ground_of(bare, i), i);
            if (is_off(best, i)) return;
            is_bad[i] = 1;
            for (std::size_t c = 0; c < inks_; ++c) bare[c][i] = (best >> c & 1) != 0 ? 0.0f : 1.0f;
        });
        return std::ranges::find(is_bad, 1) != is_bad.end();
    }

private:
    static std::vector<unsigned> all_kinds(std::size_t inks) {
        std::vector<unsigned> flips(kinds_of(inks));
        for (std::size_t k = 0; k < flips.size(); ++k) flips[k] = flips_of(k);
        return flips;
    }

    unsigned ground_of(const std::vector<std::vector<float>>& bare, std::size_t cell) const {
        unsigned ground = 0;
        for (std::size_t c = 0; c < inks_; ++c) ground |= static_cast<unsigned>(!(bare[c][cell] > 0.5f)) << c;
        return ground;
    }

    /// Share that all dots cover.
    float cover(unsigned ground, std::size_t cell) {
        const KindMixture::Shares shares = mixture_.shares(ground, light_at(wanted_, cell));
        return std::accumulate(shares.begin(), shares.end(), 0.0f);
    }

    /// Tells whether dots on a ground cannot make the light of a cell.
    bool is_off(unsigned ground, std::size_t cell) {
        constexpr float kOff = 0.02f;
        const Light light = light_at(wanted_, cell);
        const auto seen = mixture_.light(ground, mixture_.shares(ground, light));
        return std::max({std::abs(seen[0] - light.red), std::abs(seen[1] - light.green),
                         std::abs(seen[2] - light.blue)}) > kOff;
    }

    /// Finds the ground on which dots cover least, of those that differ from one in the inks nearest to a half.
    unsigned best_near(const std::vector<std::vector<float>>& bare, unsigned ground, std::size_t cell) {
        constexpr std::size_t kNearest = 3;
        std::array<std::size_t, kMostInks> order{};
        std::iota(order.begin(), order.end(), std::size_t{0});
        const auto off = [&](std::size_t c) { return std::abs(bare[c][cell] - 0.5f); };
        std::ranges::stable_sort(std::span(order).first(inks_), {}, off);
        const std::size_t near = std::min(inks_, kNearest);
        float least = cover(ground, cell);
        unsigned best = ground;
        for (unsigned turned = 1; turned < 1U << near; ++turned) {
            unsigned other = ground;
            for (std::size_t n = 0; n < near; ++n) other ^= (turned >> n & 1U) << order[n];
            const float own = cover(other, cell);
            if (own < least) {
                least = own;
                best = other;
            }
        }
        return best;
    }

    std::size_t inks_;
    const LightPlanes& wanted_;
    Executor& executor_;
    KindMixture mixture_;
};

/// Settles the number of dots, the area of the largest, and that of the smallest over it.
struct Scale {
    double dots = 0;
    double unit = 0;  ///< area of a dot of relative area 1, in cells
    float least = 0;  ///< relative area of the smallest dots
};

/// @param kinds  with their shares as densities
Scale settle(std::span<const KindOfDots> kinds, const TwoSidedOptions& options, Executor& executor) {
    constexpr float kLeastArea = 0.05f;
    constexpr int kRounds = 3;
    Scale scale;
    scale.least = kLeastArea;
    for (int round = 0; round < kRounds; ++round) {
        double units = 0;
        for (const KindOfDots& kind : kinds) {
            units += sum_of_pixels(executor, kind.area.size(), [&](std::size_t i) {
                return static_cast<double>(kind.density[i] / std::max(kind.area[i], scale.least));
            });
        }
        scale.unit = options.radius ? std::max(kPi * *options.radius * *options.radius, kLeastDotArea)
                                    : units / static_cast<double>(*options.sites);
        if (options.most) scale.unit = std::max(scale.unit, units / static_cast<double>(*options.most));
        if (!(scale.unit > 0)) return {};
        scale.dots = units / scale.unit;
        const double least = kPi * options.least_radius * options.least_radius / scale.unit;
        scale.least = static_cast<float>(std::clamp(least, static_cast<double>(kLeastArea), 1.0));
    }
    return scale;
}

/// Radius that dots would have if all had one size, in cells.
double mean_radius(std::span<const std::vector<float>> light, const TwoSidedOptions& options, Executor& executor) {
    if (options.radius) return *options.radius;
    const double minority = minority_of(light, executor);
    return std::sqrt(minority / (kPi * static_cast<double>(*options.sites)));
}

/// Solves (A + e I) x = b for a symmetric, positive semidefinite A, by Cholesky's method.
Channels solved(std::array<Channels, kMostInks> a, Channels b, std::size_t count, float e) {
    for (std::size_t j = 0; j < count; ++j) {
        a[j][j] += e;
        for (std::size_t k = 0; k < j; ++k) a[j][j] -= a[j][k] * a[j][k];
        a[j][j] = std::sqrt(a[j][j]);
        for (std::size_t i = j + 1; i < count; ++i) {
            for (std::size_t k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
            a[i][j] /= a[j][j];
        }
        for (std::size_t k = 0; k < j; ++k) b[j] -= a[j][k] * b[k];
        b[j] /= a[j][j];
    }
    for (std::size_t j = count; j-- > 0;) {
        for (std::size_t k = j + 1; k < count; ++k) b[j] -= a[k][j] * b[k];
        b[j] /= a[j][j];
    }
    return b;
}

/// Area that two discs have in common.
double common_area(double first, double second, double distance) {
    if (distance >= first + second) return 0;
    const double less = std::min(first, second);
    if (distance <= std::abs(first - second)) return kPi * less * less;
    const auto segment = [&](double own, double other) {
        const double cosine = (distance * distance + own * own - other * other) / (2 * distance * own);
        const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
        return own * own * (angle - std::sin(angle) * std::cos(angle));
    };
    return segment(first, second) + segment(second, first);
}

/// Fits the areas of dots to the picture.
class DotFit {
public:
    DotFit(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, Executor& executor)
        : plan_(plan), executor_(executor) {
        for (std::size_t kind = 0; kind < sites.size(); ++kind) {
            if (!sites[kind].empty()) add(plan.kinds[kind], sites[kind]);
        }
        areas_ = planned_;
        cut_.resize(sites_.size() * plan.channels.size());
        gains_.resize(sites_.size());
        for_cells(executor, sites_.size(), [&](std::size_t dot) { gains_[dot] = gains_of(dot); });
        find_cut();
    }

    const std::vector<float>& areas() const { return areas_; }

    /// Changes the area of each dot by the error of the local mean of what is drawn, times the ground that it stands
    /// for. Long waves of error vanish at once, those of the length of a spacing after some rounds.
    void improve() {
        constexpr float kStep = 0.85f, kSmallest = 0.25f, kLargest = 2.5f, kNoise = 0.004f;
        const float widest = *std::ranges::max_element(ground_per_dot_);
        std::vector<float> change(sites_.size(), 0);
        for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
            const TwoSidedChannel& channel = plan_.channels[c];
            std::vector<float> error(channel.white);
            for_cells(executor_, error.size(), [&](std::size_t i) { error[i] -= channel.light[i]; });
            for (std::size_t dot = 0; dot < sites_.size(); ++dot) print(dot, c, error);
            for (const auto& [one, other] : close_) print_overlap(one, other, c, error);
            const BlurPyramid means(std::move(error), plan_.cells.columns, plan_.cells.rows, spread(widest), executor_);
            for_cells(executor_, sites_.size(), [&](std::size_t dot) {
                const float ground = ground_per_dot_[dot];
                const float mean = means.at(sites_[dot], spread(ground)) * ground;
                const float excess = std::max(std::abs(mean) - kNoise * planned_[dot], 0.0f);
                change[dot] += -kStep * sign(dot, c) * gains_[dot][c] * std::copysign(excess, mean);
            });
        }
        for_cells(executor_, sites_.size(), [&](std::size_t dot) {
            areas_[dot] = std::clamp(areas_[dot] + change[dot], kSmallest * planned_[dot], kLargest * planned_[dot]);
        });
    }

    /// Finds where the boundary of the ground cuts dots of their present sizes, and which dots are close together.
    void find_cut() {
        if (plan_.kinds.size() > 1) find_close();
        for_cells(executor_, sites_.size(), [&](std::size_t dot) {
            for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
                if (flips(dot, c)) cut_[dot * plan_.channels.size() + c] = cut_of(dot, plan_.channels[c].ground);
            }
        });
    }

    /// Channels whose boundary cuts a dot, as bits.
    unsigned cut_channels(std::size_t dot) const {
        unsigned bits = 0;
        for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
            const Cut& cut = cut_at(dot, c);
            bits |= static_cast<unsigned>(cut.brightening * cut.darkening > 0) << c;
        }
        return bits;
    }

    unsigned white_channels(std::size_t dot) const {
        unsigned bits = 0;
        for (std::size_t c = 0; c < plan_.channels.size(); ++c)
            bits |= static_cast<unsigned>(plan_.channels[c].ground.is_white(sites_[dot])) << c;
        return bits;
    }

private:
    /// Ground that a dot in the emptiest places stands for, at most, over the mean, is 1 / this.
    static constexpr double kLeastDensity = 1e-4;

    /// Standard deviation of the blur by which a dot is judged: the spacing there.
    static double spread(float ground) { return std::sqrt(static_cast<double>(ground)); }

    static double radius(float area) { return std::sqrt(static_cast<double>(area) / kPi); }

    float at(const std::vector<float>& values, Point site) const {
        return interpolated(values, plan_.cells.columns, plan_.cells.rows, site);
    }

    /// Adds the dots of a kind.
    void add(const KindOfDots& kind, std::span<const Point> sites) {
        const double sum = sum_of_pixels(executor_, kind.density.size(),
                                         [&](std::size_t i) { return static_cast<double>(kind.density[i]); });
        const auto least = std::max(static_cast<float>(kLeastDensity * sum / static_cast<double>(kind.density.size())),
                                    std::numeric_limits<float>::min());
        const auto unit = static_cast<float>(sum / static_cast<double>(sites.size()));
        for (const Point& site : sites) {
            sites_.push_back(site);
            flips_.push_back(static_cast<std::uint8_t>(kind.flips));
            planned_.push_back(at(kind.area, site));
            ground_per_dot_.push_back(unit / std::max(at(kind.density, site), least));
        }
    }

    /// Computes how a dot's area answers to errors of each channel. The kinds that lie around there share the
    /// correction such that the sum of squared changes, over what each kind covers, is least: that of kind s is
    /// -s (S A S^T)^-1 error. S A S^T holds the areas that two channels both flip: the smaller one if they are nested.
    Channels gains_of(std::size_t dot) const {
        constexpr float kDamping = 0.05f;  // of the largest share: what few dots could change is left as it is
        const std::size_t channels = plan_.channels.size();
        if (channels == 1) return {1};
        Channels share{}, sign{}, flipped{};
        for (std::size_t c = 0; c < channels; ++c) {
            const TwoSidedChannel& channel = plan_.channels[c];
            const bool white = channel.ground.is_white(sites_[dot]);
            const float light = at(channel.light, sites_[dot]);
            share[c] = std::max(white ? 1 - light : light, 0.0f);
            sign[c] = white ? -1.0f : 1.0f;
            flipped[c] = flips(dot, c) ? sign[c] : 0;
        }
        std::array<Channels, kMostInks> areas = areas_at(sites_[dot], share);
        for (std::size_t i = 0; i < channels; ++i) {
            for (std::size_t j = 0; j < channels; ++j) areas[i][j] *= sign[i] * sign[j];
        }
        const float own = planned_[dot] / ground_per_dot_[dot];
        const float most = std::max(*std::ranges::max_element(share), own);
        Channels gains = solved(areas, flipped, channels, kDamping * most);
        for (std::size_t c = 0; c < channels; ++c) gains[c] *= own * sign[c];
        return gains;
    }

    /// Computes the share of a place that each two channels both flip.
    /// @param share  that each channel flips
    std::array<Channels, kMostInks> areas_at(Point site, const Channels& share) const {
        std::array<Channels, kMostInks> areas{};
        const auto for_pairs = [&](const auto& work) {
            for (std::size_t i = 0; i < plan_.channels.size(); ++i) {
                for (std::size_t j = 0; j < plan_.channels.size(); ++j) work(i, j);
            }
        };
        if (plan_.is_nested) {
            for_pairs([&](std::size_t i, std::size_t j) { areas[i][j] = std::min(share[i], share[j]); });
            return areas;
        }
        const auto unit = static_cast<float>(kPi * plan_.radius * plan_.radius);
        for (const KindOfDots& kind : plan_.kinds) {
            const float covered = at(kind.density, site) * at(kind.area, site) / unit;
            if (!(covered > 0)) continue;
            for_pairs([&](std::size_t i, std::size_t j) {
                if ((kind.flips >> i & kind.flips >> j & 1) != 0) areas[i][j] += covered;
            });
        }
        return areas;
    }

    bool flips(std::size_t dot, std::size_t channel) const { return (flips_[dot] >> channel & 1) != 0; }

    /// Parts of a dot on black ground, which it brightens, and on white ground, which it darkens.
    struct Cut {
        float brightening = 0;       ///< share of the dot's area
        float darkening = 0;         ///< share of the dot's area
        Point brightened, darkened;  ///< centroids of the parts, from the dot's centre, in radii
    };

    const Cut& cut_at(std::size_t dot, std::size_t channel) const {
        return cut_[dot * plan_.channels.size() + channel];
    }

    /// Light that a dot brings to a channel, or takes, over its area.
    float sign(std::size_t dot, std::size_t channel) const {
        const Cut& cut = cut_at(dot, channel);
        return cut.brightening - cut.darkening;
    }

    Cut cut_of(std::size_t dot, const Ground& ground) const {
        constexpr double kMargin = 1.1;  // of the radius, so that small changes keep the answer
        const bool white = ground.is_white(sites_[dot]);
        const double reach = radius(areas_[dot]);
        if (std::ranges::all_of(
                rim(), [&](const Point& way) { return ground.is_white(sites_[dot] + kMargin * reach * way) == white; }))
            return white ? Cut{0, 1, {}, {}} : Cut{1, 0, {}, {}};
        Cut cut;
        int brightened = 0;
        for (const Point& sample : disc()) {
            const bool darkens = ground.is_white(sites_[dot] + reach * sample);
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
    void print(std::size_t dot, std::size_t channel, std::vector<float>& image) const {
        if (!flips(dot, channel)) return;
        const Cut& cut = cut_at(dot, channel);
        const float area = areas_[dot];
        const double reach = radius(area);
        if (cut.brightening == 0 || cut.darkening == 0)
            return spread_over(sites_[dot], reach, (cut.brightening - cut.darkening) * area, image);
        add(sites_[dot] + reach * cut.brightened, cut.brightening * area, image);
        add(sites_[dot] + reach * cut.darkened, -cut.darkening * area, image);
    }

    /// Finds pairs of dots that flip a channel in common and overlap, or nearly. Dots of one kind keep apart; where
    /// there are several kinds, dots of different kinds come nearer.
    void find_close() {
        constexpr double kMargin = 1.15;  // of the distance at which dots touch, so that small changes keep the answer
        const double widest = radius(*std::ranges::max_element(areas_));
        const double side = std::max(2 * kMargin * widest, 1.0);
        const auto columns = static_cast<std::size_t>(plan_.cells.columns / side) + 1;
        const auto rows = static_cast<std::size_t>(plan_.cells.rows / side) + 1;
        std::vector<std::vector<std::uint32_t>> boxes(columns * rows);
        const auto box_of = [&](Point site) {
            const auto place = [side](double at, std::size_t count) {
                return std::min(static_cast<std::size_t>(std::max(at, 0.0) / side), count - 1);
            };
            return std::pair(place(site.x, columns), place(site.y, rows));
        };
        close_.clear();
        for (std::uint32_t dot = 0; dot < sites_.size(); ++dot) {
            const auto [column, row] = box_of(sites_[dot]);
            const double own = radius(areas_[dot]);
            for (std::size_t y = row - std::min<std::size_t>(row, 1); y <= std::min(row + 1, rows - 1); ++y) {
                for (std::size_t x = column - std::min<std::size_t>(column, 1); x <= std::min(column + 1, columns - 1);
                     ++x) {
                    for (const std::uint32_t other : boxes[y * columns + x]) {
                        if ((flips_[dot] & flips_[other]) == 0) continue;
                        const Point way = sites_[dot] - sites_[other];
                        const double reach = kMargin * (own + radius(areas_[other]));
                        if (::ccdt::dot(way, way) < reach * reach) close_.push_back({other, dot});
                    }
                }
            }
            boxes[row * columns + column].push_back(dot);
        }
    }

    /// Takes back the light of what two dots cover both.
    void print_overlap(std::uint32_t one, std::uint32_t other, std::size_t channel, std::vector<float>& image) const {
        if (!flips(one, channel) || !flips(other, channel)) return;
        const Point way = sites_[other] - sites_[one];
        const double distance = std::sqrt(::ccdt::dot(way, way));
        const double first = radius(areas_[one]), second = radius(areas_[other]);
        const double overlap = common_area(first, second, distance);
        if (!(overlap > 0)) return;
        const double middle = distance > 0 ? (distance + first - second) / 2 / distance : 0.5;
        const float sign_of_both = (sign(one, channel) + sign(other, channel)) / 2;
        add(sites_[one] + std::clamp(middle, 0.0, 1.0) * way, -sign_of_both * static_cast<float>(overlap), image);
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
    Executor& executor_;
    std::vector<Point> sites_;           ///< [dots], of one kind after the other
    std::vector<std::uint8_t> flips_;    ///< [dots] channels, as bits
    std::vector<float> planned_;         ///< [dots] area
    std::vector<float> areas_;           ///< [dots]
    std::vector<float> ground_per_dot_;  ///< [dots] area of the picture that each of its kind stands for
    std::vector<Channels> gains_;        ///< [dots] change of area by error of light and ground, as what flips it has
    std::vector<std::array<std::uint32_t, 2>> close_;  ///< pairs that may overlap
    std::vector<Cut> cut_;  ///< [dots][channels]; neither, where the dot does not flip the channel
};

/// Divides a picture into grounds.
TwoSidedPlan with_grounds(std::vector<std::vector<float>> light, const CellGrid& cells, double radius, double detail,
                          bool is_rgb, Executor& executor) {
    TwoSidedPlan plan;
    plan.cells = cells;
    std::vector<Ground> grounds = divide_ground(light, cells, radius, detail, is_rgb, executor);
    for (std::size_t c = 0; c < light.size(); ++c)
        plan.channels.push_back({std::move(grounds[c]), std::move(light[c]), {}});
    return plan;
}

/// Settles the number and the areas of dots, whose shares and relative areas a plan has.
void settle(TwoSidedPlan& plan, const TwoSidedOptions& options, Executor& executor) {
    const Scale scale = settle(plan.kinds, options, executor);
    plan.dots = scale.dots;
    plan.radius = std::sqrt(scale.unit / kPi);
    for (KindOfDots& kind : plan.kinds) {
        for_cells(executor, kind.area.size(), [&](std::size_t i) {
            const float area = std::max(kind.area[i], scale.least);
            kind.density[i] /= area;
            kind.area[i] = area * static_cast<float>(scale.unit);
        });
        kind.share = sum_of_pixels(executor, kind.density.size(),
                                   [&](std::size_t i) { return static_cast<double>(kind.density[i]); });
    }
}

}  // namespace

double minority_of(std::span<const std::vector<float>> light, Executor& executor) {
    return sum_of_pixels(executor, light.front().size(), [&](std::size_t i) {
        float most = 0;
        for (const auto& channel : light) most = std::max(most, std::min(channel[i], 1 - channel[i]));
        return static_cast<double>(most);
    });
}

TwoSidedPlan plan_two_sided(std::vector<std::vector<float>> light, const CellGrid& cells,
                            const TwoSidedOptions& options, const std::stop_token& stop, Executor& executor) {
    assert(options.sites || options.radius);
    assert(light.size() == 1 || light.size() == 3);
    const double radius = mean_radius(light, options, executor);
    const bool is_rgb = light.size() > 1;
    TwoSidedPlan plan = with_grounds(std::move(light), cells, radius, options.detail, is_rgb, executor);
    std::vector<std::vector<float>> sharp, share;
    for (TwoSidedChannel& channel : plan.channels) {
        if (stop.stop_requested()) return plan;
        sharp.push_back(sharpened(channel.light, cells.columns, cells.rows, options.detail * radius, executor));
        channel.white = channel.ground.white_shares(executor);
        share.push_back(wanted_share(sharp.back(), channel.white, cells, executor));
        spare_thin_ground(channel.white, cells, radius, share.back(), executor);
    }
    if (stop.stop_requested()) return plan;
    KindPlan(plan, share, sharp, radius, executor).add_areas();
    settle(plan, options, executor);
    return plan;
}

TwoSidedPlan plan_two_sided(InkPicture picture, const InkSet& inks, const CellGrid& cells,
                            const TwoSidedOptions& options, const std::stop_token& stop, Executor& executor) {
    assert(options.sites || options.radius);
    assert(picture.coverage.size() == inks.inks.size());
    constexpr int kMostRepairs = 2;
    std::vector<std::vector<float>> bare = std::move(picture.coverage);
    for (std::vector<float>& ink : bare) for_cells(executor, ink.size(), [&](std::size_t i) { ink[i] = 1 - ink[i]; });
    const double radius = mean_radius(bare, options, executor);
    InkGrounds grounds(inks, picture.light, executor);
    grounds.settle(bare);
    TwoSidedPlan plan;
    for (int repairs = 0; repairs <= kMostRepairs; ++repairs) {
        plan = with_grounds(bare, cells, radius, options.detail, false, executor);
        for (TwoSidedChannel& channel : plan.channels) channel.white = channel.ground.white_shares(executor);
        if (stop.stop_requested() || repairs == kMostRepairs || !grounds.repair(bare, plan)) break;
    }
    plan.is_nested = false;
    if (stop.stop_requested()) return plan;
    MixturePlan mixture(plan, inks, picture.light, options.detail * radius, executor);
    mixture.make_up(picture.light, radius);
    mixture.set_light(picture.light);
    if (stop.stop_requested()) return plan;
    mixture.add_shares();
    mixture.add_areas(radius);
    settle(plan, options, executor);
    return plan;
}

std::vector<SizedDots> size_dots(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, bool fit,
                                 const std::stop_token& stop, Executor& executor) {
    std::vector<SizedDots> dots(sites.size());
    if (std::ranges::all_of(sites, &std::vector<Point>::empty)) return dots;
    constexpr int kRounds = 14, kRoundsOfCut = 4;
    DotFit sizes(plan, sites, executor);
    for (int round = 0; fit && round < kRounds && !stop.stop_requested(); ++round) {
        if (round > 0 && round % kRoundsOfCut == 0) sizes.find_cut();
        sizes.improve();
    }
    sizes.find_cut();
    std::size_t dot = 0;
    for (std::size_t kind = 0; kind < sites.size(); ++kind) {
        for (std::size_t i = 0; i < sites[kind].size(); ++i, ++dot) {
            dots[kind].radii.push_back(static_cast<float>(std::sqrt(static_cast<double>(sizes.areas()[dot]) / kPi)));
            dots[kind].white.push_back(static_cast<std::uint8_t>(sizes.white_channels(dot)));
            dots[kind].cut.push_back(static_cast<std::uint8_t>(sizes.cut_channels(dot)));
        }
    }
    return dots;
}

}  // namespace ccdt
