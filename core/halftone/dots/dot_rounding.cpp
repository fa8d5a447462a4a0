// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/dots/dot_rounding.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <utility>

namespace ccdt {

namespace {

constexpr int kFull = 255;

class DotRounding {
public:
    DotRounding(std::vector<std::uint8_t>& shares, int width, int height, std::span<const std::uint8_t> covered)
        : shares_(shares),
          must_cover_(covered),
          width_(width),
          height_(height),
          values_(shares.begin(), shares.end()),
          is_rounded_(shares.size()) {}

    void run() {
        gather();
        for (int y = 0; y < height_; ++y) {
            const int ahead = y % 2 == 0 ? 1 : -1;
            for (int i = 0; i < width_; ++i) finish(ahead > 0 ? i : width_ - 1 - i, y, ahead);
        }
        for (std::size_t i = 0; i < shares_.size(); ++i) shares_[i] = is_covered(i) ? kFull : 0;
    }

private:
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }

    bool is_inside(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }
    bool is_fixed(std::size_t pixel) const { return shares_[pixel] == 0 || shares_[pixel] == kFull; }
    bool must_cover(std::size_t pixel) const { return !must_cover_.empty() && must_cover_[pixel] != 0; }
    bool is_covered(std::size_t pixel) const { return values_[pixel] > kFull / 2.0f; }

    /// Rounds pixels, from the most to the least certain ones, and passes their errors to less certain neighbours.
    /// Pixels without such neighbours remain.
    void gather() {
        std::array<std::vector<std::uint32_t>, kFull / 2 + 1> classes;
        for (std::size_t i = 0; i < shares_.size(); ++i) {
            is_rounded_[i] = is_fixed(i);
            if (is_fixed(i)) continue;
            const int certainty = must_cover(i) ? 0 : std::min(+shares_[i], kFull - shares_[i]);
            classes[static_cast<std::size_t>(certainty)].push_back(static_cast<std::uint32_t>(i));
        }
        for (const auto& pixels : classes) {
            for (const std::uint32_t pixel : pixels) pass_inwards(pixel);
        }
    }

    /// Calls visit(neighbour, weight) for the eight neighbours of a pixel.
    template <class Visit>
    void for_neighbours(std::size_t pixel, const Visit& visit) const {
        constexpr float kDiagonal = 0.5f;
        const int x = static_cast<int>(pixel % static_cast<std::size_t>(width_));
        const int y = static_cast<int>(pixel / static_cast<std::size_t>(width_));
        for (int down = -1; down <= 1; ++down) {
            for (int across = -1; across <= 1; ++across) {
                if ((across != 0 || down != 0) && is_inside(x + across, y + down))
                    visit(index(x + across, y + down), across != 0 && down != 0 ? kDiagonal : 1.0f);
            }
        }
    }

    /// Returns how suitable a pixel is for more or less coverage.
    float suitability(std::size_t pixel, bool more) const {
        return static_cast<float>(more ? shares_[pixel] : kFull - shares_[pixel]);
    }

    void pass_inwards(std::size_t pixel) {
        // A pixel with a share of at most a half is covered only if it has received enough for a whole pixel. Any other
        // pixel is bare only if it has passed on its whole share.
        const float least = shares_[pixel] <= kFull / 2 ? kFull - 1 : 0;
        const float rounded = must_cover(pixel) || values_[pixel] > least ? kFull : 0, error = values_[pixel] - rounded;
        const auto for_receivers = [&](const auto& visit) {
            for_neighbours(pixel, [&](std::size_t to, float weight) {
                if (!is_rounded_[to]) visit(to, weight * suitability(to, error > 0));
            });
        };
        float weights = 0;
        for_receivers([&](std::size_t, float weight) { weights += weight; });
        if (!(weights > 0)) return;
        for_receivers([&](std::size_t to, float weight) { values_[to] += weight / weights * error; });
        values_[pixel] = rounded;
        is_rounded_[pixel] = true;
    }

    /// Rounds the last pixel of a dot. While the error exceeds half a pixel, also changes the most suitable pixels
    /// around it.
    /// @param ahead  direction of travel along the row
    void finish(int x, int y, int ahead) {
        const std::size_t pixel = index(x, y);
        if (is_rounded_[pixel]) return;
        values_[pixel] += std::exchange(carried_, 0.0f);
        is_rounded_[pixel] = true;
        float error = values_[pixel];
        const auto change = [&](std::size_t changed, bool more) {
            values_[changed] = more ? kFull : 0;
            error += more ? -kFull : kFull;
        };
        if (must_cover(pixel) || is_covered(pixel)) {
            change(pixel, true);
        } else {
            values_[pixel] = 0;
        }
        while (std::abs(error) > kFull / 2.0f) {
            const bool more = error > 0;
            std::size_t best = pixel;
            float most = 0;
            for_neighbours(pixel, [&](std::size_t other, float weight) {
                if (is_fixed(other) || !is_rounded_[other] || is_covered(other) == more || must_cover(other)) return;
                const float own = (1 + weight) * suitability(other, more);
                if (own > most) std::tie(most, best) = std::pair(own, other);
            });
            if (best == pixel) break;
            change(best, more);
        }
        pass_on(error, x, y, ahead);
    }

    /// Passes an error to the nearest pixels that are not rounded yet or, if they are far, to the next one.
    void pass_on(float error, int x, int y, int ahead) {
        constexpr int kReach = 12;
        nearest_.clear();
        // Two pixels that are not rounded are never neighbours.
        for (int reach = 2; reach <= kReach && nearest_.empty(); ++reach) {
            const auto add = [&](int across, int down) {
                const int to = x + across * ahead;
                if (is_inside(to, y + down) && !is_rounded_[index(to, y + down)])
                    nearest_.push_back(index(to, y + down));
            };
            for (int down = 0; down < reach; ++down) {
                if (down > 0) add(-reach, down);
                add(reach, down);
            }
            for (int across = -reach; across <= reach; ++across) add(across, reach);
        }
        if (nearest_.empty()) carried_ += error;
        for (const std::size_t to : nearest_) values_[to] += error / static_cast<float>(nearest_.size());
    }

    std::vector<std::uint8_t>& shares_;
    std::span<const std::uint8_t> must_cover_;
    int width_, height_;
    std::vector<float> values_;             ///< [pixels] coverage with errors of others
    std::vector<std::uint8_t> is_rounded_;  ///< [pixels]
    std::vector<std::size_t> nearest_;      ///< of pass_on(), kept for its memory
    float carried_ = 0;                     ///< error that no pixel is near enough to take
};

}  // namespace

void round_dots(std::vector<std::uint8_t>& shares, int width, int height, std::span<const std::uint8_t> covered) {
    assert(shares.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    DotRounding(shares, width, height, covered).run();
}

}  // namespace ccdt
