// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/direct_search.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <utility>

#include "core/dither/error_diffusion.h"
#include "core/dither/tile_sweep.h"
#include "core/picture/pixel_ranges.h"

namespace ccdt {

namespace {

/// Direct binary search that changes pixels of a picture in the colours of a device.
/// @tparam Channels  1 for a device with greys only, 4 for other devices; as in VisualError
template <std::size_t Channels>
class DirectSearch {
public:
    using Colour = typename VisualError<Channels>::Colour;

    DirectSearch(std::span<const DeviceColours::Opponent> wanted, std::span<const std::uint8_t> given,
                 std::vector<std::uint8_t> chosen, int width, int height, const DeviceColours& device,
                 const SearchOptions& options, Executor& executor)
        : given_(given),
          chosen_(std::move(chosen)),
          width_(width),
          height_(height),
          colours_(device.count()),
          keeps_counts_(options.keeps_counts),
          error_(residual(wanted, chosen_, device, executor), width, height, options.blur, executor) {
        for (std::size_t a = 0; a < colours_; ++a) {
            for (std::size_t b = 0; b < colours_; ++b) {
                Difference& difference = differences_[a][b];
                for (std::size_t c = 0; c < std::min<std::size_t>(Channels, 3); ++c) {
                    difference.colour[c] = device[b][c] - device[a][c];
                    difference.square += difference.colour[c] * difference.colour[c];
                }
            }
        }
    }

    /// Makes the change of a pixel that reduces the visible error most, if any change reduces it.
    /// @returns  whether the picture has changed
    bool visit(int x, int y) {
        static_assert(TileSweep::kTile >= 2 * (VisualError<Channels>::kReachInPixels + 1));
        if (given_[pixel(x, y)] != kAnyColour) return false;
        const Change best = best_change(x, y);
        if (best.colour == kAnyColour) return false;
        apply(x, y, best);
        return true;
    }

    std::vector<std::uint8_t> take_result() { return std::move(chosen_); }

private:
    struct Difference {
        Colour colour{};
        float square = 0;
    };

    /// Change of a pixel to another colour, or exchange of its colour with a neighbour.
    struct Change {
        float error = -1e-7f;  ///< change of the visible error; the default exceeds rounding errors
        std::uint8_t colour = kAnyColour;
        int dx = 0, dy = 0;  ///< offset of the neighbour to exchange with; both 0: none
    };

    static std::vector<Colour> residual(std::span<const DeviceColours::Opponent> wanted,
                                        std::span<const std::uint8_t> chosen, const DeviceColours& device,
                                        Executor& executor) {
        std::vector<Colour> result(wanted.size(), Colour{});
        for_pixels(executor, wanted.size(), [&](std::size_t i) {
            for (std::size_t c = 0; c < std::min<std::size_t>(Channels, 3); ++c)
                result[i][c] = device[chosen[i]][c] - wanted[i][c];
        });
        return result;
    }

    std::size_t pixel(int x, int y) const { return index(y) * index(width_) + index(x); }

    static float product(const Colour& a, const Colour& b) {
        float sum = 0;
        for (std::size_t c = 0; c < Channels; ++c) sum += a[c] * b[c];
        return sum;
    }

    Change best_change(int x, int y) const {
        const Colour gradient = error_.gradient(x, y);
        const std::uint8_t own = chosen_[pixel(x, y)];
        Change best;
        for (std::size_t other = 0; other < colours_ && !keeps_counts_; ++other) {
            if (other == own) continue;
            const Difference& change = differences_[own][other];
            const float error = 2 * product(change.colour, gradient) + change.square * error_.self();
            if (error < best.error) best = {error, static_cast<std::uint8_t>(other), 0, 0};
        }
        for (int dy = -std::min(y, 1); dy <= std::min(height_ - 1 - y, 1); ++dy) {
            for (int dx = -std::min(x, 1); dx <= std::min(width_ - 1 - x, 1); ++dx) {
                const std::size_t neighbour = pixel(x + dx, y + dy);
                const std::uint8_t other = chosen_[neighbour];
                if (other == own || given_[neighbour] != kAnyColour) continue;
                const Difference& change = differences_[own][other];
                const Colour there = error_.gradient(x + dx, y + dy);
                const float mutual = error_.mutual(x, y, dx, dy);
                const float error = 2 * (product(change.colour, gradient) - product(change.colour, there) +
                                         change.square * (error_.self() - mutual));
                if (error < best.error) best = {error, other, dx, dy};
            }
        }
        return best;
    }

    void apply(int x, int y, const Change& change) {
        const std::uint8_t own = chosen_[pixel(x, y)];
        chosen_[pixel(x, y)] = change.colour;
        error_.change(x, y, differences_[own][change.colour].colour);
        if (change.dx == 0 && change.dy == 0) return;
        chosen_[pixel(x + change.dx, y + change.dy)] = own;
        error_.change(x + change.dx, y + change.dy, differences_[change.colour][own].colour);
    }

    std::span<const std::uint8_t> given_;
    std::vector<std::uint8_t> chosen_;
    int width_, height_;
    std::size_t colours_;
    bool keeps_counts_;
    VisualError<Channels> error_;
    std::array<std::array<Difference, kMaxDeviceColours>, kMaxDeviceColours> differences_{};
};

template <std::size_t Channels>
std::vector<std::uint8_t> search(DirectSearch<Channels> search, int width, int height, const std::stop_token& stop,
                                 Executor& executor) {
    TileSweep(width, height).run([&](int x, int y) { return search.visit(x, y); }, stop, executor);
    return search.take_result();
}

}  // namespace

std::vector<std::uint8_t> search_directly(std::span<const DeviceColours::Opponent> wanted,
                                          std::span<const std::uint8_t> given, std::vector<std::uint8_t> chosen,
                                          int width, int height, const DeviceColours& device,
                                          const SearchOptions& options, const std::stop_token& stop,
                                          Executor& executor) {
    assert(wanted.size() == index(width) * index(height));
    assert(given.size() == wanted.size() && chosen.size() == wanted.size());
    if (device.is_grey())
        return search<1>({wanted, given, std::move(chosen), width, height, device, options, executor}, width, height,
                         stop, executor);
    return search<4>({wanted, given, std::move(chosen), width, height, device, options, executor}, width, height, stop,
                     executor);
}

}  // namespace ccdt
