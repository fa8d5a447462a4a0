// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/geometry/point.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Local means of an image over Gaussians of many widths.
///
/// Level k holds the image blurred by about 2^k pixels at every 2^k-th pixel. Memory is 4/3 of the image's.
/// Source: Burt, Adelson 1983, The Laplacian pyramid as a compact image code.
class BlurPyramid {
public:
    /// @param values  [width * height]
    /// @param widest  standard deviation in pixels that at() shall reach
    /// Same input, same bytes, on any executor. O(pixels).
    BlurPyramid(std::vector<float> values, int width, int height, double widest,
                Executor& executor = inline_executor());

    /// Returns the mean around a place, in pixels from the image's corner, by a Gaussian of about `sigma` pixels. Less
    /// than 1 counts as 1.
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
