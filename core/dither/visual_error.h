// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <span>
#include <vector>

#include "core/parallel/executor.h"

namespace ccdt {

/// Standard deviations of the blurs of eyes, in pixels. A search runs for one eye after the other.
///
/// An eye that resolves more detail makes finer patterns, from which the search for the next eye finds a much better
/// picture. The last eyes are those that count; in colours, the eye sees less detail.
inline constexpr std::array<double, 4> kGreyBlurs = {1.1, 1.6, 1.3, 1.5};
inline constexpr std::array<double, 2> kColourBlurs = {1.5, 1.9};

/// Error that an eye sees of a picture on a device, and its exact changes when pixels change.
///
/// Let r be the residual, the device's picture minus the wanted one. Level l sums r over squares of 2^l x 2^l pixels
/// and blurs these sums with a Gaussian G, which has the same standard deviation in squares for all levels. The error
/// is
///
///     E = sum over levels l of weight_l |G * r_l|^2.
///
/// Level 0 is the eye; a blur of 1.5 pixels resolves about three pixels. Since sums grow with the squares, coarser
/// levels weigh long waves with about the square of their wavelength, as transport does. They prevent the tone of deep
/// shadows from drifting, where level 0 alone sees only single dots.
///
/// The class stores A * r_l for each level, where A is the autocorrelation of G times the weight. A change d of one
/// pixel then changes E by 2 d . gradient() + |d|^2 self(), and changes the stored values in a small window only.
///
/// @tparam Channels  1, or 4 with the last one unused, so that a colour fills one vector register
template <std::size_t Channels>
class VisualError {
public:
    using Colour = std::array<float, Channels>;

    static constexpr int kLevels = 4;
    static constexpr int kReach = 8;  ///< of A, in squares

    /// Largest distance in pixels, along an axis, between two pixels whose changes mutual() relates.
    static constexpr int kNear = 3;

    /// Largest distance in pixels, along an axis, at which a change of one pixel changes stored values.
    static constexpr int kReachInPixels = (kReach + 1) << (kLevels - 1);

    /// @param blur      standard deviation of G
    /// @param residual  [width * height]
    VisualError(double blur, std::span<const Colour> residual, int width, int height, Executor& executor);

    /// Returns half the derivative of E with respect to the residual of a pixel.
    Colour gradient(int x, int y) const {
        Colour sum{};
        for (int l = 0; l < kLevels; ++l) {
            const float* const value = levels_[static_cast<std::size_t>(l)].at(x >> l, y >> l);
            for (std::size_t c = 0; c < Channels; ++c) sum[c] += value[c];
        }
        return sum;
    }

    /// Returns the coefficient of the square of the change of one pixel.
    float self() const { return self_; }

    /// Returns half the coefficient of the product of the changes of a pixel and one near it.
    /// @param dx, dy  from -kNear to kNear
    float mutual(int x, int y, int dx, int dy) const {
        return mutual_[index(y & kPhaseMask)][index(x & kPhaseMask)][index(kNearSide * (dy + kNear) + dx + kNear)];
    }

    /// Changes the residual of a pixel.
    void change(int x, int y, const Colour& by) {
        for (int l = 0; l < kLevels; ++l) levels_[index(l)].change(x >> l, y >> l, by, kernel_, kWeights[index(l)]);
    }

private:
    static constexpr int kSide = 2 * kReach + 1, kNearSide = 2 * kNear + 1;
    static constexpr int kPhaseMask = (1 << (kLevels - 1)) - 1;
    /// Weights of levels. Larger weights of coarse levels make shadows more exact, and fine detail less.
    static constexpr std::array<float, kLevels> kWeights = {1, 0.05f, 0.05f, 0.1f};

    using Kernel = std::array<float, kSide>;

    static constexpr std::size_t index(int i) { return static_cast<std::size_t>(i); }

    /// A * r_l of one level, with a margin that changes near the border of the picture write to.
    struct Level {
        int width = 0, height = 0;
        std::size_t stride = 0;
        std::vector<float> values;

        float* at(int column, int row) {
            return values.data() + index(row + kReach) * stride + Channels * index(column + kReach);
        }
        const float* at(int column, int row) const { return const_cast<Level*>(this)->at(column, row); }

        void change(int column, int row, const Colour& by, const Kernel& kernel, float weight) {
            std::array<float, Channels * kSide> line;
            for (std::size_t i = 0; i < line.size(); ++i) line[i] = weight * kernel[i / Channels] * by[i % Channels];
            float* value = at(column - kReach, row - kReach);
            for (const float factor : kernel) {
                for (std::size_t i = 0; i < line.size(); ++i) value[i] += factor * line[i];
                value += stride;
            }
        }
    };

    void fill(int l, std::span<const Colour> residual, int width, int height, Executor& executor);

    Kernel kernel_{};  ///< A is the product of this kernel along both axes, and of the weight
    float self_ = 0;
    /// [y & kPhaseMask][x & kPhaseMask][kNearSide * (dy + kNear) + dx + kNear]
    std::array<std::array<std::array<float, kNearSide * kNearSide>, kPhaseMask + 1>, kPhaseMask + 1> mutual_{};
    std::array<Level, kLevels> levels_;
};

extern template class VisualError<1>;
extern template class VisualError<4>;

}  // namespace ccdt
