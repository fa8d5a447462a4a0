#include "core/globe/clearance.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace ccdt {

Disc disc_on_ground(const Chart& chart, Point place, double metres) {
    constexpr double kMost = 0.99 * std::numbers::pi;  // from the centre
    constexpr double kRoom = 1e-3;
    constexpr double kVaries = 0.007;  // of metres to a radian, a radian of latitude
    const double squared = dot(place, place), length = std::sqrt(squared);
    const double radian = std::sqrt(chart.ground(place)) * (1 + squared / 4);
    const double from_centre = 2 * std::atan(length / 2), least = metres / radian;
    const double angle = (1 + kRoom + kVaries * least) * least;
    if (!(from_centre + angle < kMost)) return {place, std::numeric_limits<double>::max()};
    const double nearest = 2 * std::tan((from_centre - angle) / 2), farthest = 2 * std::tan((from_centre + angle) / 2);
    const Point outwards = length > 0 ? 1 / length * place : Point{1, 0};
    return {(nearest + farthest) / 2 * outwards, (farthest - nearest) / 2};
}

}  // namespace ccdt
