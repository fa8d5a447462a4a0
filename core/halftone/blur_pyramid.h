// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/point.h"
#include "core/halftone/bilinear.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Means of an image, weighted by a Gaussian of any width around any position.
///
/// Level k holds the image blurred by a standard deviation of about 2^k pixels, sampled at every 2^k-th pixel. All
/// levels together take 4/3 of the image's memory.
/// Source: Burt, Adelson 1983, The Laplacian pyramid as a compact image code.
class BlurPyramid {
public:
    BlurPyramid() = default;

    /// Reserves memory; assign() sets the image.
    /// @param widest  largest standard deviation that sample() supports, in pixels
    BlurPyramid(int width, int height, double widest);

    /// Computes the levels of an image [width * height]. Deterministic for any number of threads. O(pixels).
    void assign(const std::vector<float>& values, Executor& executor = inline_executor());

    /// Bilinear interpolation of one level at a position.
    struct LevelSample {
        std::size_t level = 0;
        std::size_t pixel = 0;  ///< upper left one of the four pixels between which the value is interpolated
        float right = 0;        ///< weight of the pixels on the right
        float below = 0;        ///< weight of the lower pixels
    };

    /// Interpolation between two levels, for a position and a standard deviation.
    struct Sample {
        LevelSample finer, coarser;
        float share = 0;  ///< weight of the coarser level
    };

    /// Returns the interpolation with which at() computes the mean around a position.
    /// @param place  in pixels from the image's upper left corner
    /// @param sigma  approximate standard deviation in pixels; at least 1 and at most the standard deviation of the
    ///               coarsest level
    Sample sample(Point place, double sigma) const;

    /// Returns the mean weighted by a Gaussian, interpolated between levels.
    float at(const Sample& sample) const {
        const float finer = at(sample.finer);
        return sample.share > 0 ? (1 - sample.share) * finer + sample.share * at(sample.coarser) : finer;
    }

private:
    struct Level {
        int width = 0;
        int height = 0;
        std::vector<float> values;
    };

    LevelSample sample(std::size_t level, Point place) const;

    float at(const LevelSample& sample) const {
        const Level& level = levels_[sample.level];
        const std::size_t right = level.width > 1 ? 1 : 0;
        const std::size_t below = level.height > 1 ? static_cast<std::size_t>(level.width) : 0;
        const float* pixel = level.values.data() + sample.pixel;
        return mix(mix(pixel[0], pixel[right], sample.right), mix(pixel[below], pixel[below + right], sample.right),
                   sample.below);
    }

    std::vector<Level> levels_;
    std::vector<float> scratch_;
};

}  // namespace ccdt
