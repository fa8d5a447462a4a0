// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/geometry/point.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Means of an image, weighted by a Gaussian of any width around any position.
///
/// Level k holds the image blurred by a standard deviation of about 2^k pixels, sampled at every 2^k-th pixel. All
/// levels together take 4/3 of the image's memory.
/// Source: Burt, Adelson 1983, The Laplacian pyramid as a compact image code.
class BlurPyramid {
public:
    /// @param values  [width * height]
    /// @param widest  largest standard deviation that at() supports, in pixels
    /// Deterministic for any number of threads. O(pixels).
    BlurPyramid(std::vector<float> values, int width, int height, double widest,
                Executor& executor = inline_executor());

    /// Returns the mean weighted by a Gaussian around a position, interpolated between levels.
    /// @param place  in pixels from the image's upper left corner
    /// @param sigma  approximate standard deviation in pixels; values below 1 count as 1
    float at(Point place, double sigma) const;

private:
    struct Level {
        int width = 0;
        int height = 0;
        std::vector<float> values;

        float at(Point place) const;
    };

    std::vector<Level> levels_;
};

}  // namespace ccdt
