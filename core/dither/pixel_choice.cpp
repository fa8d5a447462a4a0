// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/pixel_choice.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/base/random.h"
#include "core/dither/device_colours.h"
#include "core/dither/direct_search.h"
#include "core/dither/error_diffusion.h"
#include "core/picture/pixel_ranges.h"

namespace ccdt {

namespace {

/// Integrates a density over each pixel.
std::vector<double> masses_of(const Density& density, int width, int height, Executor& executor) {
    std::vector<double> masses(index(width) * index(height), 1);
    if (density.is_uniform()) return masses;
    for_rows(executor, width, index(height), [&](std::size_t row) {
        density.resample_row(density.cells(), width, height, static_cast<int>(row),
                             std::span(masses).subspan(row * index(width), index(width)));
    });
    return masses;
}

/// Chooses pixels in a hierarchy of rectangles. In each rectangle, at most one pixel remains undecided.
class HierarchicalChoice {
public:
    HierarchicalChoice(std::span<const double> shares, int width, std::uint64_t seed)
        : shares_(shares), width_(width), random_(seed, 0), chosen_(shares.size(), 0) {}

    std::vector<std::uint8_t> run(int height) && {
        const Undecided last = decide(0, 0, width_, height);
        settle(last, last.share > 0.5);  // 0 or 1, except for rounding
        return std::move(chosen_);
    }

private:
    struct Undecided {
        std::size_t pixel = 0;
        double share = 0;  ///< probability with which the pixel is chosen
    };

    /// Decides all pixels of a rectangle except for one.
    Undecided decide(int left, int top, int right, int bottom) {
        const int width = right - left, height = bottom - top;
        if (width == 1 && height == 1) {
            const std::size_t pixel = index(top) * index(width_) + index(left);
            return {pixel, shares_[pixel]};
        }
        if (width > height) {
            const int middle = left + width / 2;
            const Undecided first = decide(left, top, middle, bottom);
            return decide_one(first, decide(middle, top, right, bottom));
        }
        const int middle = top + height / 2;
        const Undecided first = decide(left, top, right, middle);
        return decide_one(first, decide(left, middle, right, bottom));
    }

    /// Decides one of two pixels. The other pixel remains undecided; its share becomes the sum of both shares, minus 1
    /// if the decided pixel is chosen.
    Undecided decide_one(const Undecided& a, const Undecided& b) {
        const double sum = a.share + b.share;
        if (sum <= 1) {
            const bool keeps_a = random_.uniform() * sum < a.share;
            settle(keeps_a ? b : a, false);
            return {keeps_a ? a.pixel : b.pixel, sum};
        }
        const bool chooses_a = random_.uniform() * (2 - sum) < 1 - b.share;
        settle(chooses_a ? a : b, true);
        return {chooses_a ? b.pixel : a.pixel, sum - 1};
    }

    void settle(const Undecided& pixel, bool is_chosen) { chosen_[pixel.pixel] = is_chosen ? 1 : 0; }

    std::span<const double> shares_;
    int width_;
    Random random_;
    std::vector<std::uint8_t> chosen_;
};

/// Returns the blur of the error in a set of pixels. A wide blur spreads sparse pixels evenly, but lets dense ones
/// touch. Benchmark PixelChoice measures the evenness.
/// @param share  mean share of the pixels that are chosen at random
double blur_of(double share) {
    constexpr double kBlurPerSpacing = 0.2, kNarrowest = 0.75;
    return std::clamp(kBlurPerSpacing / std::sqrt(std::min(share, 1 - share)), kNarrowest, kEyeBlur);
}

}  // namespace

Result<std::vector<double>> pixel_shares(const Density& density, std::span<const std::uint8_t> included, int width,
                                         int height, std::size_t count, Executor& executor) {
    std::vector<double> shares = masses_of(density, width, height, executor);
    assert(included.size() == shares.size());
    const auto number_of = [&](const auto& is_counted) {
        return static_cast<std::size_t>(
            sum_of_pixels(executor, shares.size(), [&](std::size_t i) { return is_counted(i) ? 1.0 : 0.0; }));
    };
    const std::size_t forced = number_of([&](std::size_t i) { return included[i] != 0; });
    if (forced > count)
        return failure(
            ErrorCode::Unusable,
            std::to_string(forced) + " pixels are included, but there are only " + std::to_string(count) + " sites",
            "include");
    const std::size_t possible = number_of([&](std::size_t i) { return included[i] != 0 || shares[i] > 0; });
    if (possible < count)
        return failure(ErrorCode::Unusable,
                       "only " + std::to_string(possible) +
                           " pixels have a density above 0 or are included, but there are " + std::to_string(count) +
                           " sites",
                       "sites");

    // Pixels whose density reaches the limit have the share 1. Each of them leaves less density for the remaining
    // count, so the limit only falls.
    double limit = std::numeric_limits<double>::infinity();
    const auto is_full = [&](std::size_t i) { return included[i] != 0 || shares[i] >= limit; };
    for (std::size_t full = number_of(is_full), before = count; full < count && full != before;) {
        const double rest =
            sum_of_pixels(executor, shares.size(), [&](std::size_t i) { return is_full(i) ? 0 : shares[i]; });
        limit = std::min(limit, rest / static_cast<double>(count - full));  // rounding could raise it
        before = std::exchange(full, number_of(is_full));
    }
    for_pixels(executor, shares.size(), [&](std::size_t i) { shares[i] = is_full(i) ? 1 : shares[i] / limit; });
    return shares;
}

std::vector<std::uint8_t> choose_pixels(std::span<const double> shares, int width, int height, std::uint64_t seed,
                                        const std::stop_token& stop, Executor& executor) {
    assert(shares.size() == index(width) * index(height));
    const DeviceColours device(std::array{Light{0, 0, 0}, Light{1, 1, 1}});
    std::vector<DeviceColours::Opponent> wanted(shares.size());
    std::vector<std::uint8_t> given(shares.size(), kAnyColour);
    for_pixels(executor, shares.size(), [&](std::size_t i) {
        wanted[i] = {static_cast<float>(shares[i]) * device[1][0], 0, 0};
        if (shares[i] == 0 || shares[i] == 1) given[i] = shares[i] == 1 ? 1 : 0;
    });
    const auto sum_of_random = [&](const auto& value) {
        return sum_of_pixels(executor, shares.size(),
                             [&](std::size_t i) { return given[i] == kAnyColour ? value(i) : 0; });
    };
    std::vector<std::uint8_t> chosen = HierarchicalChoice(shares, width, seed).run(height);
    const double random = sum_of_random([](std::size_t) { return 1.0; });
    if (random == 0 || stop.stop_requested()) return chosen;
    const double share = sum_of_random([&](std::size_t i) { return shares[i]; }) / random;
    return search_directly(wanted, given, std::move(chosen), width, height, device,
                           {.keeps_counts = true, .blur = blur_of(share)}, stop, executor);
}

}  // namespace ccdt
