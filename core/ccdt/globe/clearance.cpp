// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/clearance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/base/elementary.h"

namespace ccdt {

Disc disc_on_ground(const Chart& chart, Point position, double metres) {
    constexpr double kMax = 0.99 * std::numbers::pi;  // largest angle from the chart's centre
    constexpr double kMargin = 1e-3;
    constexpr double kVaries = 0.007;  // relative change of the length of a metre on the sphere, per radian of latitude
    const double squared = dot(position, position), length = std::sqrt(squared);
    const double radian = std::sqrt(chart.ground(position)) * (1 + squared / 4);
    const double from_centre = 2 * elementary::atan(length / 2), least = metres / radian;
    const double angle = (1 + kMargin + kVaries * least) * least;
    if (!(from_centre + angle < kMax)) return {position, std::numeric_limits<double>::max()};
    const double nearest = 2 * elementary::tan((from_centre - angle) / 2),
                 farthest = 2 * elementary::tan((from_centre + angle) / 2);
    const Point outwards = length > 0 ? 1 / length * position : Point{1, 0};
    return {(nearest + farthest) / 2 * outwards, (farthest - nearest) / 2};
}

Result<void> keep_off_border(ChartedPart& part, double buffer, const std::stop_token& stop) {
    constexpr double kOnSeam = 1e-5;  // relative; edges of the circle are chords, other borders are degrees away
    if (!(buffer > 0)) return {};
    const double metres = std::max(buffer, kMinBuffer) + part.error;
    const DiscAround disc_around = [&](Point p) {
        const bool is_cut = std::abs(std::sqrt(dot(p, p)) - part.seam) < kOnSeam * part.seam;
        return is_cut ? Disc{} : disc_on_ground(part.chart, p, metres);
    };
    auto kept = inset(part.domain, disc_around, part.indifference, stop);
    if (!kept) return failure(kept.error().code, "the buffer leaves nothing of the polygon", "buffer");
    part.domain = *std::move(kept);
    return {};
}

}  // namespace ccdt
