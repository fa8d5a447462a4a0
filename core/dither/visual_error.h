// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <span>
#include <vector>

#include "core/base/executor.h"

namespace ccdt {

/// Converts a coordinate that is not negative to the type of indices.
constexpr std::size_t index(int i) {
    return static_cast<std::size_t>(i);
}

/// Blur of an eye that resolves about three pixels: standard deviation, in pixels.
inline constexpr double kEyeBlur = 1.5;

/// Standard deviations of blurs, in pixels. A search runs for one blur after the other.
///
/// A narrow blur makes finer patterns, from which the search with the next blur finds a much better picture. The last
/// blur is that of the eye; in colours, the eye sees less detail.
inline constexpr std::array<double, 4> kGreyBlurs = {1.1, 1.6, 1.3, kEyeBlur};
inline constexpr std::array<double, 2> kColourBlurs = {1.5, 1.9};

/// Visible error of a picture on a device, updated exactly when pixels change.
///
/// Let r be the residual: the device's picture minus the wanted picture. Level l holds r_l, the sums of r over squares
/// of 2^l x 2^l pixels. Let G be a Gaussian whose standard deviation, in squares, is the same at all levels. The error
/// is
///
///     E = sum over levels l of weight_l |G * r_l|^2.
///
/// Level 0 models the eye. Coarser levels weight long waves by about the square of their wavelength, because sums grow
/// with the area of the squares. They prevent the tone from drifting in deep shadows, where level 0 sees only single
/// dots.
///
/// The class stores A * r_l for each level, where A is weight_l times the autocorrelation of G. A change d of one pixel
/// then changes E by 2 d . gradient() + |d|^2 self(), and changes the stored values in a small window only.
///
/// @tparam Channels  1, or 4 with the last one unused, so that a colour fills one vector register
template <std::size_t Channels>
class VisualError {
public:
    using Colour = std::array<float, Channels>;

    static constexpr int kLevels = 4;
    static constexpr int kReach = 8;  ///< half the width of the kernel of a level, in squares

    /// Largest distance in pixels, along an axis, between two pixels whose changes mutual() relates.
    static constexpr int kNear = 3;

    /// Largest distance in pixels, along an axis, at which a change of one pixel changes stored values.
    static constexpr int kReachInPixels = (kReach + 1) << (kLevels - 1);

    /// @param residual  [width * height]
    /// @param blur      standard deviation of G, in squares
    VisualError(std::span<const Colour> residual, int width, int height, double blur, Executor& executor);

    /// Returns half the derivative of the error with respect to the residual of a pixel.
    Colour gradient(int x, int y) const {
        Colour sum{};
        for (int l = 0; l < kLevels; ++l) {
            const float* const value = levels_[static_cast<std::size_t>(l)].at(x >> l, y >> l);
            for (std::size_t c = 0; c < Channels; ++c) sum[c] += value[c];
        }
        return sum;
    }

    /// Returns the coefficient of |d|^2 in the change of the error, for a change d of one pixel.
    float self() const { return self_; }

    /// Returns half the coefficient of d . d' in the change of the error, for changes d and d' of two pixels.
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

    /// Stored values of one level, with a margin around the picture to which changes near the border also write.
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

    Kernel kernel_{};  ///< autocorrelation of the Gaussian along one axis
    float self_ = 0;
    /// [y & kPhaseMask][x & kPhaseMask][kNearSide * (dy + kNear) + dx + kNear] results of mutual().
    std::array<std::array<std::array<float, kNearSide * kNearSide>, kPhaseMask + 1>, kPhaseMask + 1> mutual_{};
    std::array<Level, kLevels> levels_;
};

extern template class VisualError<1>;
extern template class VisualError<4>;

}  // namespace ccdt
