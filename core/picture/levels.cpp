// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/levels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "core/base/elementary.h"
#include "core/picture/pixel_ranges.h"
#include "core/picture/srgb.h"
#include "core/picture/tone.h"

namespace ccdt {

namespace {

/// Applies Levels to linear light. Uses a table with equal steps of light between the black and the white point.
class LevelCurve {
public:
    explicit LevelCurve(const Levels& levels)
        : black_(static_cast<float>(light_of_srgb(levels.black))),
          white_(static_cast<float>(light_of_srgb(levels.white)) * kWhite),
          table_(kSteps + 1) {
        for (std::size_t i = 0; i < table_.size(); ++i) {
            const double light = std::lerp(double{black_}, double{white_}, static_cast<double>(i) / kSteps);
            const double share =
                std::clamp((srgb_of_light(light) - levels.black) / (levels.white - levels.black), 0.0, 1.0);
            table_[i] = static_cast<float>(light_of_srgb(elementary::pow(share, 1 / levels.gamma)));
        }
    }

    float operator()(float value) const {
        const float light = to_share(value);
        if (light >= white_) return 1;
        if (light <= black_) return 0;
        const float position = (light - black_) / (white_ - black_) * kSteps;
        const auto below = std::min(static_cast<std::size_t>(position), std::size_t{kSteps - 1});
        return std::lerp(table_[below], table_[below + 1], position - static_cast<float>(below));
    }

    Plane of(const Plane& plane, Executor& executor) const {
        const auto values = std::make_shared_for_overwrite<float[]>(plane.size());
        for_ranges(executor, plane.size(), kPixelsOfTask, [&](std::size_t begin, std::size_t end) {
            std::transform(plane.begin() + begin, plane.begin() + end, values.get() + begin, std::cref(*this));
        });
        return {values, plane.size()};
    }

private:
    static constexpr int kSteps = 1 << 15;
    /// Factor on the white point. Without it, a pixel at the white point could get dots because of rounding.
    static constexpr float kWhite = 1 - 1e-6F;

    float black_;
    float white_;
    std::vector<float> table_;
};

}  // namespace

Picture with_levels(const Picture& picture, const Levels& levels, Executor& executor) {
    if (levels == Levels{}) return picture;
    const LevelCurve curve(levels);
    return {picture.width, picture.height, curve.of(picture.luminance, executor), picture.alpha};
}

ColourPicture with_levels(const ColourPicture& picture, const Levels& levels, Executor& executor) {
    if (levels == Levels{}) return picture;
    const LevelCurve curve(levels);
    return {picture.width,
            picture.height,
            curve.of(picture.red, executor),
            curve.of(picture.green, executor),
            curve.of(picture.blue, executor),
            picture.alpha};
}

}  // namespace ccdt
