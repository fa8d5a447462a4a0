// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/locate.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "core/base/elementary.h"
#include "core/ccdt/maps/feature_area.h"
#include "core/ccdt/maps/feature_index.h"

namespace ccdt {
namespace {

constexpr std::size_t kStopStride = 4'096;  ///< points between polls of the stop token

double distance_to_edge(Point p, Point a, Point b) {
    const Point along = b - a, to = p - a;
    const double length = elementary::hypot(along.x, along.y);
    const double at = length > 0 ? std::clamp(dot(to, 1 / length * along), 0.0, length) : 0;
    const Point nearest = length > 0 ? a + at / length * along : a;
    return elementary::hypot(p.x - nearest.x, p.y - nearest.y);
}

double distance_to_border(Point p, const Domain& area) {
    double least = std::numeric_limits<double>::max();
    for (const Ring& ring : area.rings()) {
        Point last = area.to_user(ring.back());
        for (const Point& corner : ring) {
            const Point next = area.to_user(corner);
            least = std::min(least, distance_to_edge(p, last, next));
            last = next;
        }
    }
    return least;
}

class Locator {
public:
    Locator(std::span<const Domain* const> areas, double period)
        : domains_(areas), areas_(make_areas(areas)), index_(areas_), period_(period), box_(areas.front()->bounds()) {
        for (const Domain* area : areas) {
            box_.include(area->bounds().min);
            box_.include(area->bounds().max);
        }
    }

    std::uint32_t find(Point p) const {
        std::optional<std::uint32_t> found;
        for_copies(p, [&](Point copy) {
            index_.for_near(copy, [&](std::uint32_t i) {
                if ((!found || i < *found) && areas_[i].contains(copy)) found = i;
            });
        });
        return found ? *found : nearest(p);
    }

private:
    static std::vector<FeatureArea> make_areas(std::span<const Domain* const> areas) {
        std::vector<FeatureArea> made;
        made.reserve(areas.size());
        for (const Domain* area : areas) made.emplace_back(*area);
        return made;
    }

    /// Shifts a point by whole periods, and calls function(copy) for each copy within the extent of all areas along x.
    template <class Function>
    void for_copies(Point p, Function&& function) const {
        if (period_ == 0) return function(p);
        for (p.x += period_ * std::ceil((box_.min.x - p.x) / period_); p.x <= box_.max.x; p.x += period_) function(p);
    }

    /// Finds the area whose border is nearest. Considers only areas whose bounding boxes may contain the point; if
    /// there are none, all areas.
    std::uint32_t nearest(Point p) const {
        std::uint32_t best = 0;
        double least = std::numeric_limits<double>::max();
        const auto compare = [&](Point copy, std::uint32_t i) {
            const double distance = distance_to_border(copy, *domains_[i]);
            if (distance > least || (distance == least && i > best)) return;
            best = i;
            least = distance;
        };
        for_copies(p, [&](Point copy) { index_.for_near(copy, [&](std::uint32_t i) { compare(copy, i); }); });
        if (least < std::numeric_limits<double>::max()) return best;
        for (std::uint32_t i = 0; i < domains_.size(); ++i) for_copies(p, [&](Point copy) { compare(copy, i); });
        return best;
    }

    std::span<const Domain* const> domains_;
    std::vector<FeatureArea> areas_;
    FeatureIndex index_;
    double period_;
    Box box_;
};

}  // namespace

Result<std::vector<std::uint32_t>> locate(std::span<const Domain* const> areas, std::span<const Point> points,
                                          double period, const std::stop_token& stop) {
    std::vector<std::uint32_t> found(points.size(), 0);
    if (areas.size() == 1) return found;
    const Locator locator(areas, period);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i % kStopStride == 0 && stop.stop_requested())
            return failure(ErrorCode::Stopped, "stopped before there was a result");
        found[i] = locator.find(points[i]);
    }
    return found;
}

}  // namespace ccdt
