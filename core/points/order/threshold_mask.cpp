// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/order/threshold_mask.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <queue>
#include <span>
#include <utility>

#include "core/base/elementary.h"
#include "core/base/random.h"

namespace ccdt {

namespace {

// Test ThresholdMask requires the quality that these constants reach. A narrower Gaussian leaves more power in low
// frequencies; a wider one makes pixels cluster.
constexpr double kSigma = 1.5;         ///< in pixels
constexpr double kSigmaInTime = 1.6;   ///< in frames
constexpr double kWeightInTime = 0.7;  ///< weight of the Gaussians in time, relative to those within a frame
constexpr double kReach = 4;           ///< radius of a Gaussian, in sigmas
constexpr int kMaxSweeps = 32;

// Shares of chosen pixels below which the Gaussians grow, such that they keep overlapping.
constexpr double kSparse = 0.125;
constexpr double kSparseInTime = 0.2;
constexpr double kStep = 0.7;  ///< share of the chosen pixels that remain when the Gaussians grow

/// A Gaussian along an axis of a torus.
class WrappedGaussian {
public:
    WrappedGaussian(double sigma, int period) : period_(period), radius_(static_cast<int>(std::ceil(kReach * sigma))) {
        const int taps = std::min(2 * radius_ + 1, period);
        values_.assign(static_cast<std::size_t>(taps), 0);
        for (int i = -radius_; i <= radius_; ++i)
            values_[static_cast<std::size_t>((i + radius_) % taps)] += elementary::exp(-i * i / (2 * sigma * sigma));
    }

    /// Calls function(begin, values) for one or two ranges of successive coordinates, which begin at `begin`, with the
    /// values of the Gaussian around `at`.
    template <class Function>
    void for_ranges(int at, Function&& function) const {
        const int taps = static_cast<int>(values_.size());
        int begin = (at - radius_) % period_;
        if (begin < 0) begin += period_;
        const auto first = static_cast<std::size_t>(std::min(taps, period_ - begin));
        function(static_cast<std::size_t>(begin), std::span(values_).first(first));
        if (first < values_.size()) function(0, std::span(values_).subspan(first));
    }

    /// Returns the value at a distance from the centre of at most the radius.
    double at(int i) const { return values_[static_cast<std::size_t>(i + radius_) % values_.size()]; }

private:
    int period_, radius_;
    std::vector<double> values_;  ///< sums of periodic copies, from the distance -radius_ on
};

/// Chosen pixels of a tile, to be spread evenly.
class PixelPattern {
public:
    PixelPattern(int width, int height, int depth)
        : width_(width),
          height_(height),
          depth_(depth),
          frame_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
          is_set_(frame_ * static_cast<std::size_t>(depth), 0),
          crowding_(is_set_.size()) {}

    std::size_t size() const { return is_set_.size(); }
    std::size_t frame() const { return frame_; }
    bool is_set(std::size_t pixel) const { return is_set_[pixel] != 0; }
    void choose(std::size_t pixel) { is_set_[pixel] = 1; }

    /// Computes the crowding of all pixels by Gaussians that are wide enough for a share of chosen pixels.
    void set_share(double share) {
        const double sigma = kSigma * std::sqrt(std::max(kSparse / share, 1.0));
        across_ = {sigma, width_};
        down_ = {sigma, height_};
        in_time_ = {std::min(kSigmaInTime * std::max(kSparseInTime / share, 1.0), depth_ / 2.0), depth_};
        std::ranges::fill(crowding_, 0);
        for (std::size_t i = 0; i < size(); ++i) {
            if (is_set(i)) crowd(i, 1);
        }
    }

    /// Moves chosen pixels to less crowded neighbouring pixels until no pixel can move, or for a limited number of
    /// sweeps.
    void relax(const std::stop_token& stop) {
        std::size_t moves = 1;
        for (int sweep = 0; sweep < kMaxSweeps && moves > 0; ++sweep) {
            moves = 0;
            for (std::size_t pixel = 0; pixel < size(); ++pixel) {
                if (pixel % kStopStride == 0 && stop.stop_requested()) return;
                moves += move(pixel) ? 1 : 0;
            }
        }
    }

    /// Unsets `count` chosen pixels of each frame, each time the most crowded one of the next frame.
    /// @param visit  receives each pixel and the number of removals from the frame before it
    template <class Visit>
    void thin(std::size_t count, const std::stop_token& stop, Visit&& visit) {
        using Entry = std::pair<double, std::uint32_t>;
        std::vector<std::priority_queue<Entry>> queues;
        for (std::uint32_t i = 0; i < size();) {
            std::vector<Entry> all;
            for (const std::size_t end = i + frame_; i < end; ++i) {
                if (is_set(i)) all.emplace_back(crowding_[i], i);
            }
            queues.emplace_back(std::less<Entry>(), std::move(all));
        }
        for (std::size_t gone = 0; gone < count * queues.size(); ++gone) {
            if (gone % kStopStride == 0 && stop.stop_requested()) return;
            auto& queue = queues[gone % queues.size()];
            // Removals of nearby pixels have reduced the crowding since the entry was queued.
            while (queue.top().first != crowding_[queue.top().second]) {
                const std::uint32_t pixel = queue.top().second;
                queue.pop();
                queue.emplace(crowding_[pixel], pixel);
            }
            const std::uint32_t pixel = queue.top().second;
            queue.pop();
            is_set_[pixel] = 0;
            crowd(pixel, -1);
            visit(pixel, gone / queues.size());
        }
    }

private:
    static constexpr std::size_t kStopStride = 4'096;  ///< pixels between polls of the stop token

    /// Adds the Gaussians around a pixel, multiplied by a factor, to the crowding.
    void crowd(std::size_t pixel, double factor) {
        const auto columns = static_cast<std::size_t>(width_);
        const std::size_t first = pixel - pixel % frame_, in_frame = pixel - first;
        const auto x = static_cast<int>(in_frame % columns), y = static_cast<int>(in_frame / columns);
        down_.for_ranges(y, [&](std::size_t row, std::span<const double> shares) {
            for (const double share : shares) {
                double* const line = &crowding_[first + row++ * columns];
                across_.for_ranges(x, [&](std::size_t column, std::span<const double> values) {
                    for (std::size_t i = 0; i < values.size(); ++i) line[column + i] += factor * share * values[i];
                });
            }
        });
        if (depth_ == 1) return;
        in_time_.for_ranges(static_cast<int>(pixel / frame_), [&](std::size_t frame, std::span<const double> values) {
            for (const double value : values) crowding_[frame++ * frame_ + in_frame] += factor * kWeightInTime * value;
        });
    }

    /// Moves a chosen pixel to the least crowded free neighbour, if that lowers its crowding.
    /// @returns  whether a pixel was moved
    bool move(std::size_t from) {
        constexpr double kMinGain = 1e-9;
        if (!is_set(from)) return false;
        const auto columns = static_cast<std::size_t>(width_), rows = static_cast<std::size_t>(height_);
        const std::size_t first = from - from % frame_, x = (from - first) % columns, y = (from - first) / columns;
        const double own_in_time = depth_ > 1 ? kWeightInTime * in_time_.at(0) : 0;
        double least = crowding_[from] - down_.at(0) * across_.at(0) - own_in_time - kMinGain;
        std::size_t to = from;
        for (int dy = -1; dy <= 1; ++dy) {
            const std::size_t row = (y + rows + static_cast<std::size_t>(dy)) % rows;
            for (int dx = -1; dx <= 1; ++dx) {
                const std::size_t other =
                    first + row * columns + (x + columns + static_cast<std::size_t>(dx)) % columns;
                const double crowding = crowding_[other] - down_.at(dy) * across_.at(dx);
                if (is_set(other) || crowding >= least) continue;
                least = crowding;
                to = other;
            }
        }
        if (to == from) return false;
        is_set_[from] = 0;
        crowd(from, -1);
        is_set_[to] = 1;
        crowd(to, 1);
        return true;
    }

    int width_, height_, depth_;
    std::size_t frame_;  ///< pixels per frame
    WrappedGaussian across_{kSigma, 1}, down_{kSigma, 1}, in_time_{kSigmaInTime, 1};
    std::vector<std::uint8_t> is_set_;
    std::vector<double> crowding_;
};

/// Ranks the chosen pixels of each frame. For any k, the first k pixels are spread evenly.
/// @param left  number of chosen pixels in each frame
/// @param rank  receives each pixel and its rank
template <class Rank>
void rank_pixels(PixelPattern pattern, std::size_t left, const std::stop_token& stop, Rank&& rank) {
    const auto all = static_cast<double>(pattern.frame());
    while (left > 0 && !stop.stop_requested()) {
        const auto stay = static_cast<std::size_t>(kStep * static_cast<double>(left));
        pattern.set_share(static_cast<double>(std::max<std::size_t>(stay, 1)) / all);
        pattern.thin(left - stay, stop, [&](std::uint32_t pixel, std::size_t gone) {
            rank(pixel, static_cast<std::uint32_t>(left - gone - 1));
        });
        left = stay;
    }
}

}  // namespace

std::vector<std::uint32_t> threshold_mask(int width, int height, int depth, std::uint64_t seed,
                                          const std::stop_token& stop, Executor& executor) {
    PixelPattern low(width, height, depth), high = low;
    const std::size_t frame = low.frame(), half = frame / 2;
    Random random(seed, 0);
    for (std::size_t first = 0; first < low.size(); first += frame) {
        for (std::size_t i = 0; i + 1 < frame; i += 2) low.choose(first + i + (random.uniform() < 0.5 ? 0 : 1));
    }
    low.set_share(0.5);
    low.relax(stop);
    for (std::size_t i = 0; i < low.size(); ++i) {
        if (!low.is_set(i)) high.choose(i);
    }
    std::vector<std::uint32_t> ranks(low.size());
    executor.run(2, [&](std::size_t upper) {
        if (upper == 0)
            rank_pixels(std::move(low), half, stop,
                        [&](std::uint32_t pixel, std::uint32_t rank) { ranks[pixel] = rank; });
        else
            rank_pixels(std::move(high), frame - half, stop, [&](std::uint32_t pixel, std::uint32_t rank) {
                ranks[pixel] = static_cast<std::uint32_t>(frame) - 1 - rank;
            });
    });
    return ranks;
}

}  // namespace ccdt
