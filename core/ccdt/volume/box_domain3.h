// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "core/geometry/point3.h"

namespace ccdt {

/// A box in space with one corner at the origin, or the torus that results from joining its opposite faces.
struct BoxDomain3 {
    Point3 sides{1, 1, 1};
    bool periodic = false;

    double volume() const { return sides.x * sides.y * sides.z; }

    /// Returns the copy of a point that lies in the domain. Copies on a torus are periodic. Copies in a box are mirror
    /// images, and the result keeps a tiny distance from the border; points farther away than a side are clamped to it.
    Point3 inside(Point3 p) const { return {inside(p.x, sides.x), inside(p.y, sides.y), inside(p.z, sides.z)}; }

    // SolidDomain has the following members, too.

    /// Returns the bounding box.
    BoxDomain3 box() const { return *this; }
    bool contains(Point3) const { return true; }
    /// Returns a point in the domain.
    Point3 interior() const { return 0.5 * sides; }
    /// Returns the position in the bounding box where the density at a copy is defined.
    Point3 in_box(Point3 p) const { return inside(p); }
    /// Returns the position in the domain at which a move ends, from a position in the domain to a position near it.
    Point3 moved(Point3 /*from*/, Point3 to) const { return inside(to); }

    /// Calls function(copy, is_original) for a point and its copies up to a distance from the domain. Along each axis,
    /// omits copies that are more than 30 sides away, which only thin domains have within the usual distances.
    template <class Function>
    void for_copies(Point3 p, double distance, Function&& function) const {
        constexpr double kMaxSides = 30;
        const auto limited = [&](double side) { return std::min(distance, kMaxSides * side); };
        const Point3 margin{limited(sides.x), limited(sides.y), limited(sides.z)};
        for_copies(p, {Point3{} - margin, sides + margin}, function);
    }

    /// Calls function(copy, is_original) for a point and all of its copies within a window. Copies on a torus are
    /// periodic. Copies in a box are mirror images at the faces, and mirror images of these. Points of uniform density
    /// and their copies together have the same density everywhere.
    /// @param p       in the domain
    /// @param window  at most 61 times as wide as the domain
    template <class Function>
    void for_copies(Point3 p, const Box3& window, Function&& function) const {
        const Copies xs = copies(p.x, sides.x, window.min.x, window.max.x);
        if (xs.count == 0) return;
        const Copies ys = copies(p.y, sides.y, window.min.y, window.max.y);
        if (ys.count == 0) return;
        const Copies zs = copies(p.z, sides.z, window.min.z, window.max.z);
        for (std::size_t k = 0; k < zs.count; ++k) {
            for (std::size_t j = 0; j < ys.count; ++j) {
                for (std::size_t i = 0; i < xs.count; ++i) {
                    const bool is_original = i == xs.original && j == ys.original && k == zs.original;
                    function(Point3{xs.at[i], ys.at[j], zs.at[k]}, is_original);
                }
            }
        }
    }

private:
    struct Copies {
        std::array<double, 64> at{};
        std::size_t count = 0;
        std::size_t original = 64;  ///< index of the coordinate itself; 64 if it lies outside the window
    };

    double inside(double v, double side) const {
        constexpr double kMargin = 1e-9;
        if (periodic) {
            const double rest = v - side * std::floor(v / side);
            return rest < side ? rest : 0;
        }
        if (v < 0) v = -v;
        if (v > side) v = 2 * side - v;
        return std::clamp(v, kMargin * side, (1 - kMargin) * side);
    }

    Copies copies(double v, double side, double low, double high) const {
        Copies copies;
        if (v >= low && v <= high) {
            copies.original = 0;
            copies.at[copies.count++] = v;
        }
        const double period = periodic ? side : 2 * side;
        const auto add = [&](double first, bool has_original) {
            const double begin = std::ceil((low - first) / period), end = std::floor((high - first) / period);
            for (double k = begin; k <= end; ++k) {
                if (has_original && k == 0) continue;
                assert(copies.count < copies.at.size());
                copies.at[copies.count++] = first + k * period;
            }
        };
        add(v, true);
        if (!periodic) add(-v, false);
        return copies;
    }
};

}  // namespace ccdt
