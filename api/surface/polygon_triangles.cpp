// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/polygon_triangles.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/geometry/point.h"

namespace ccdt::api {
namespace {

/// Projects a polygon along the axis that is closest to its normal, such that it is counter-clockwise.
std::vector<Point> projected(std::span<const Point3> corners) {
    Point3 normal{0, 0, 0};
    for (std::size_t i = 2; i < corners.size(); ++i)
        normal = normal + cross(corners[i - 1] - corners[0], corners[i] - corners[0]);
    const double x = std::abs(normal.x), y = std::abs(normal.y), z = std::abs(normal.z);
    std::vector<Point> flat;
    for (const Point3 corner : corners) {
        const Point3 p = corner - corners[0];  // exact digits also far from the origin
        if (z >= x && z >= y) {
            flat.push_back(normal.z < 0 ? Point{p.y, p.x} : Point{p.x, p.y});
        } else if (x >= y) {
            flat.push_back(normal.x < 0 ? Point{p.z, p.y} : Point{p.y, p.z});
        } else {
            flat.push_back(normal.y < 0 ? Point{p.x, p.z} : Point{p.z, p.x});
        }
    }
    return flat;
}

double turn(Point a, Point b, Point c) {
    return cross(b - a, c - b);
}

/// A polygon from which corners are removed.
class Ring {
public:
    explicit Ring(std::vector<Point> at)
        : at_(std::move(at)), previous_(at_.size()), next_(at_.size()), is_ear_(at_.size()) {
        const auto size = static_cast<std::uint32_t>(at_.size());
        for (std::uint32_t i = 0; i < size; ++i) {
            previous_[i] = i == 0 ? size - 1 : i - 1;
            next_[i] = i + 1 == size ? 0 : i + 1;
        }
        for (std::uint32_t i = 0; i < size; ++i) {
            if (turn_at(i) < 0) concave_.push_back(i);
        }
    }

    /// Returns a concave corner if there is one, otherwise the first corner.
    std::uint32_t fan_corner() const { return concave_.empty() ? 0 : concave_.front(); }
    bool is_convex() const { return concave_.empty(); }
    std::uint32_t next(std::uint32_t i) const { return next_[i]; }

    /// Calls a function with the corners of all triangles.
    template <class Function>
    void clip(Function&& triangle) {
        for (std::uint32_t i = 0; i < at_.size(); ++i) is_ear_[i] = is_ear(i);
        std::uint32_t i = 0;
        for (std::size_t remaining = at_.size(); remaining > 3; --remaining) {
            // In a polygon that intersects itself there may be no ear.
            for (std::size_t tried = 0; tried < remaining && !is_ear_[i]; ++tried) i = next_[i];
            const std::uint32_t before = previous_[i], after = next_[i];
            triangle(before, i, after);
            next_[before] = after;
            previous_[after] = before;
            std::erase_if(concave_, [&](std::uint32_t each) { return each == i || turn_at(each) >= 0; });
            is_ear_[before] = is_ear(before);
            is_ear_[after] = is_ear(after);
            i = after;
        }
        triangle(previous_[i], i, next_[i]);
    }

private:
    double turn_at(std::uint32_t i) const { return turn(at_[previous_[i]], at_[i], at_[next_[i]]); }

    bool is_ear(std::uint32_t i) const {
        const Point a = at_[previous_[i]], b = at_[i], c = at_[next_[i]];
        if (turn(a, b, c) <= 0) return false;
        return std::ranges::none_of(concave_, [&](std::uint32_t each) {
            const Point p = at_[each];
            return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0 && p != a && p != b && p != c;
        });
    }

    std::vector<Point> at_;
    std::vector<std::uint32_t> previous_, next_;
    std::vector<bool> is_ear_;
    std::vector<std::uint32_t> concave_;
};

}  // namespace

void divide_polygon(std::span<const Point3> corners, std::span<std::array<std::uint32_t, 3>> triangles) {
    std::size_t made = 0;
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) { triangles[made++] = {a, b, c}; };
    Ring ring(projected(corners));
    if (!ring.is_convex() && corners.size() > 4) return ring.clip(add);
    const std::uint32_t first = ring.fan_corner();
    for (std::uint32_t i = ring.next(first); made < triangles.size(); i = ring.next(i)) add(first, i, ring.next(i));
}

}  // namespace ccdt::api
