#include "core/globe/clearance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "core/geometry/simplify.h"

namespace ccdt {

namespace {

/// Simplifies a border with very many corners, to a hundredth of the pitch of sites. The tolerance is added to the
/// error, so that no site comes too near to the true border. A border with a cut along a circle is not changed.
void coarsen(ChartedPart& part, const std::stop_token& stop) {
    constexpr std::size_t kManyCorners = 50'000;
    constexpr double kCoarser = 10, kLargestRadius = 6'399'594;
    if (part.seam > 0 || part.domain.corner_count() <= kManyCorners) return;
    const double distance = kCoarser * part.indifference;
    std::vector<Ring> rings;
    for (const Ring& unit : part.domain.rings()) {
        Ring ring;
        for (const Point& p : unit) ring.push_back(part.domain.to_user(p));
        rings.push_back(simplified(ring, distance));
    }
    auto coarse = Domain::enclosed_by(rings, stop);
    if (!coarse) return;
    part.domain = *std::move(coarse);
    part.error += distance * kLargestRadius;
}

}  // namespace

Disc disc_on_ground(const Chart& chart, Point place, double metres) {
    constexpr double kMost = 0.99 * std::numbers::pi;  // angle from the centre
    constexpr double kRoom = 1e-3;
    constexpr double kVaries = 0.007;  // relative change of metres per radian, per radian of latitude
    const double squared = dot(place, place), length = std::sqrt(squared);
    const double radian = std::sqrt(chart.ground(place)) * (1 + squared / 4);
    const double from_centre = 2 * std::atan(length / 2), least = metres / radian;
    const double angle = (1 + kRoom + kVaries * least) * least;
    if (!(from_centre + angle < kMost)) return {place, std::numeric_limits<double>::max()};
    const double nearest = 2 * std::tan((from_centre - angle) / 2), farthest = 2 * std::tan((from_centre + angle) / 2);
    const Point outwards = length > 0 ? 1 / length * place : Point{1, 0};
    return {(nearest + farthest) / 2 * outwards, (farthest - nearest) / 2};
}

Result<void> keep_off_border(ChartedPart& part, double buffer, const std::stop_token& stop) {
    constexpr double kOnSeam = 1e-5;  // the circle's edges are chords; other borders are degrees away
    if (!(buffer > 0)) return {};
    coarsen(part, stop);
    const double metres = std::max(buffer, kLeastBuffer) + part.error;
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
