// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/order/threshold_mask.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <queue>
#include <utility>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/order/progressive_order.h"
#include "core/random.h"

namespace ccdt {

namespace {

// Test ThresholdMask requires the quality that these constants reach. A narrower Gaussian leaves more power in low
// frequencies; a wider one makes pixels cluster.
constexpr double kSigma = 1.5;  ///< in pixels
constexpr int kReach = 6;       ///< radius of the Gaussian in pixels; values beyond this are below 4e-4
constexpr int kMaxSweeps = 32;

/// Share of set pixels below which the Gaussians of neighbouring set pixels no longer overlap.
constexpr double kSparseShare = 1.0 / 16;

/// A pattern of set pixels on a torus, to be spread evenly.
class PixelPattern {
public:
    PixelPattern(int width, int height)
        : width_(width),
          height_(height),
          is_set_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0),
          crowding_(is_set_.size(), 0) {
        for (int i = -kReach; i <= kReach; ++i)
            gauss_[static_cast<std::size_t>(i + kReach)] = std::exp(-i * i / (2 * kSigma * kSigma));
    }

    std::size_t size() const { return is_set_.size(); }
    bool is_set(std::size_t pixel) const { return is_set_[pixel] != 0; }

    void set(std::size_t at, bool value) {
        is_set_[at] = value ? 1 : 0;
        const int x = static_cast<int>(at % static_cast<std::size_t>(width_));
        const int y = static_cast<int>(at / static_cast<std::size_t>(width_));
        std::array<std::size_t, 2 * kReach + 1> columns;
        for (int i = -kReach; i <= kReach; ++i)
            columns[static_cast<std::size_t>(i + kReach)] = static_cast<std::size_t>(wrapped(x + i, width_));
        for (int i = -kReach; i <= kReach; ++i) {
            double* row = &crowding_[pixel(0, y + i)];
            const double factor = (value ? 1 : -1) * gauss_[static_cast<std::size_t>(i + kReach)];
            for (std::size_t k = 0; k < columns.size(); ++k) row[columns[k]] += factor * gauss_[k];
        }
    }

    /// Moves set pixels to less crowded neighbouring pixels until no pixel can move, or for a limited number of sweeps.
    void relax(const std::stop_token& stop) {
        std::size_t moves = 1;
        for (int sweep = 0; sweep < kMaxSweeps && moves > 0; ++sweep) {
            moves = 0;
            for (int y = 0; y < height_; ++y) {
                if (stop.stop_requested()) return;
                for (int x = 0; x < width_; ++x) moves += move(x, y) ? 1 : 0;
            }
        }
    }

    /// Unsets `count` pixels, each time the most crowded one.
    /// @returns  the pixels in order of removal
    std::vector<std::uint32_t> thin(std::size_t count, const std::stop_token& stop) {
        using Entry = std::pair<double, std::uint32_t>;
        std::vector<Entry> all;
        for (std::uint32_t i = 0; i < size(); ++i) {
            if (is_set(i)) all.emplace_back(crowding_[i], i);
        }
        std::priority_queue<Entry, std::vector<Entry>, std::less<>> queue(std::less<>(), std::move(all));
        std::vector<std::uint32_t> gone;
        while (gone.size() < count && !(gone.size() % kStopStride == 0 && stop.stop_requested())) {
            const auto [crowding, i] = queue.top();
            queue.pop();
            // Removals of nearby pixels have reduced the crowding since the entry was queued.
            if (crowding != crowding_[i]) {
                queue.emplace(crowding_[i], i);
                continue;
            }
            set(i, false);
            gone.push_back(i);
        }
        return gone;
    }

private:
    static constexpr std::size_t kStopStride = 4'096;  ///< pixels between polls of the stop token

    static int wrapped(int i, int period) { return i < 0 ? i + period : i >= period ? i - period : i; }

    std::size_t pixel(int x, int y) const {
        return static_cast<std::size_t>(wrapped(y, height_)) * static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(wrapped(x, width_));
    }

    /// Moves a set pixel to the least crowded unset neighbour, if that lowers its crowding.
    /// @returns  whether a pixel was moved
    bool move(int x, int y) {
        constexpr double kMinGain = 1e-9;
        const std::size_t from = pixel(x, y);
        if (!is_set(from)) return false;
        double least = crowding_[from] - 1 - kMinGain;
        std::size_t to = from;
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                const std::size_t other = pixel(x + dx, y + dy);
                const double own =
                    gauss_[static_cast<std::size_t>(dx + kReach)] * gauss_[static_cast<std::size_t>(dy + kReach)];
                if (is_set(other) || crowding_[other] - own >= least) continue;
                least = crowding_[other] - own;
                to = other;
            }
        }
        if (to == from) return false;
        set(from, false);
        set(to, true);
        return true;
    }

    int width_, height_;
    std::array<double, 2 * kReach + 1> gauss_{};
    std::vector<std::uint8_t> is_set_;
    std::vector<double> crowding_;  ///< sum of the Gaussians of all set pixels
};

PixelPattern half_of(int width, int height, std::uint64_t seed, const std::stop_token& stop) {
    PixelPattern half(width, height);
    Random random(seed, 0);
    for (std::size_t i = 0; i + 1 < half.size(); i += 2) half.set(i + (random.uniform() < 0.5 ? 0 : 1), true);
    half.relax(stop);
    return half;
}

/// Orders the set pixels. For any k, the first k pixels are spread evenly.
std::vector<std::uint32_t> thinning_order(PixelPattern pattern, const Domain& torus, const std::stop_token& stop) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < pattern.size(); ++i) count += pattern.is_set(i) ? 1 : 0;
    const auto few = static_cast<std::size_t>(kSparseShare * static_cast<double>(pattern.size()));
    std::vector<std::uint32_t> last = pattern.thin(count - few, stop);

    std::vector<std::uint32_t> pixels, ordered;
    std::vector<Point> points;
    const auto columns = static_cast<std::uint32_t>(torus.bounds().width());
    for (std::uint32_t i = 0; i < pattern.size(); ++i) {
        if (!pattern.is_set(i)) continue;
        pixels.push_back(i);
        points.push_back({i % columns + 0.5, i / columns + 0.5});
    }
    for (const std::uint32_t i : progressive_order(torus, points, true, stop)) ordered.push_back(pixels[i]);
    ordered.insert(ordered.end(), last.rbegin(), last.rend());
    return ordered;
}

}  // namespace

std::vector<std::uint32_t> threshold_mask(int width, int height, std::uint64_t seed, const std::stop_token& stop) {
    PixelPattern low = half_of(width, height, seed, stop), high(width, height);
    for (std::size_t i = 0; i < low.size(); ++i) {
        if (!low.is_set(i)) high.set(i, true);
    }
    const Domain torus = Domain::torus(width, height).value();
    std::vector<std::uint32_t> ranks(low.size());
    std::uint32_t first = 0, last = static_cast<std::uint32_t>(ranks.size());
    for (const std::uint32_t pixel : thinning_order(std::move(low), torus, stop)) ranks[pixel] = first++;
    for (const std::uint32_t pixel : thinning_order(std::move(high), torus, stop)) ranks[pixel] = --last;
    return ranks;
}

}  // namespace ccdt
