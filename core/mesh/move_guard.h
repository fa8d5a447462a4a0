// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/geometry/point.h"
#include "core/geometry/predicates.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Least share of its area or volume that a triangle or tetrahedron keeps in a move. With any share above 0, it keeps
/// its orientation.
inline constexpr double kKeptShare = 0.1;

/// Least doubled area after a move, relative to the longest edge squared. It must be well above 1e-16, the rounding
/// error of an area, so that signs of areas are certain, and well below 1, so that it does not affect the pattern.
inline constexpr double kMinShape = 1e-5;

/// Returns the doubled area below which a triangle is a needle.
/// @param least_height  least height of a triangle
inline double needle_area(Point a, Point b, Point c, double least_height) {
    const Point ab = b - a, ac = c - a, bc = c - b;
    const double longest = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
    return std::max(kMinShape * longest, least_height * std::sqrt(longest));
}

/// Takes back moves of sites that would invert a triangle, take most of its area, or make it a needle. To be replaced
/// by a new one whenever triangles change in other ways than by moves that it has checked.
class MoveGuard {
public:
    /// Shortens or reverts moves until every triangle is sound. O(triangles) per sweep; there are few sweeps.
    /// @param before        [sites] positions before the moves
    /// @param least_height  least height of a triangle that was not lower before the moves
    /// @param halvings      number of sweeps that halve moves; the sweeps after them revert moves
    /// @param is_large      called with a triangle and its doubled area, also in parallel; returns whether the triangle
    ///                      is too large for a needle
    template <class IsLarge>
    void check(Triangulation& mesh, std::span<const Point> before, double least_height, int halvings,
               IsLarge&& is_large) {
        const auto is_sound = [&](std::uint32_t t, double area) {
            const bool large = is_large(t, area);
            if (large && area >= kKeptShare * largest_) return true;
            const double old = area_before(mesh, t, before);
            if (area < kKeptShare * old) return false;
            if (large) return true;
            const auto [a, b, c] = mesh.positions(t);
            return area >= std::min(old, needle_area(a, b, c, least_height)) && orientation(a, b, c) > 0;
        };
        constexpr std::size_t kTriangles = 8192;  // per task
        const std::size_t triangles = mesh.triangle_count();
        std::vector<std::vector<std::uint32_t>> lists((triangles + kTriangles - 1) / kTriangles);
        std::vector<double> largest(lists.size());
        bool found = true;
        for (int sweep = 0; found; ++sweep) {
            for_ranges(mesh.executor(), triangles, kTriangles, [&](std::size_t begin, std::size_t end) {
                auto& list = lists[begin / kTriangles];
                list.clear();
                double most = 0;
                for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
                    const double area = mesh.doubled_area(t);
                    most = std::max(most, area);
                    if (!is_sound(t, area)) list.push_back(t);
                }
                largest[begin / kTriangles] = most;
            });
            const double kept = sweep < halvings ? 0.5 : 0;
            found = false;
            for (const auto& list : lists) {
                for (const std::uint32_t t : list) {
                    if (is_sound(t, mesh.doubled_area(t))) continue;  // meanwhile a neighbouring site was moved back
                    for (const std::uint32_t v : mesh.corners(t)) {
                        if (!mesh.is_site(v) || mesh.point(v) == before[v]) continue;
                        mesh.points()[v] = before[v] + kept * (mesh.point(v) - before[v]);
                        found = true;
                    }
                }
            }
        }
        largest_ = std::ranges::max(largest);
    }

private:
    /// Returns twice the area of a triangle before its sites moved.
    static double area_before(const Triangulation& mesh, std::uint32_t triangle, std::span<const Point> before) {
        const auto corners = mesh.corners(triangle);
        const auto position = [&](std::uint32_t i) {
            const Point p = mesh.is_site(corners[i]) ? before[corners[i]] : mesh.point(corners[i]);
            return p + mesh.distance(mesh.lift(Triangulation::edge(triangle, i)));
        };
        const Point a = position(0), b = position(1), c = position(2);
        return cross(b - a, c - a);
    }

    double largest_ = std::numeric_limits<double>::infinity();  ///< no doubled area before the moves is larger
};

}  // namespace ccdt
