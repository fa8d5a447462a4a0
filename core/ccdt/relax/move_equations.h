// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/lanes.h"
#include "core/ccdt/relax/move_groups.h"
#include "core/geometry/point.h"
#include "core/mesh/move_guard.h"

// The normal equations of the moves of Relaxation: one vertex at a time, or several sites at once in vectors.
namespace ccdt {

/// Least determinant relative to the product of the diagonal, larger than its rounding error.
inline constexpr double kSingular = 1e-12;

/// Returns the step along x and y to the minimum of a quadratic with the given half Hessian and half gradient; a zero
/// step if the Hessian is singular. The arguments are single numbers, or vectors with one number per lane.
template <class Numbers>
CCDT_INLINE inline std::array<Numbers, 2> minimum(Numbers xx, Numbers xy, Numbers yy, Numbers x, Numbers y) {
    const Numbers det = xx * yy - xy * xy;
    const Numbers inverse = det > kSingular * xx * yy ? 1 / det : Numbers{};
    return {(xy * y - yy * x) * inverse, (xy * x - xx * y) * inverse};
}

inline Point minimum(double xx, double xy, double yy, Point gradient) {
    const auto [x, y] = minimum(xx, xy, yy, gradient.x, gradient.y);
    return {x, y};
}

/// Contribution of a triangle to the normal equations of its corners.
struct GoalTerm {
    double weight;  ///< weight and target are divided by the square root of the triangle's share
    double target;
    double spring;  ///< weight * share
    double scale;   ///< 1 / sqrt(share)
};

/// The one-rings of sites that are moved at once, one site per lane. Each vector holds the values of two triangles of
/// each site. The first neighbour is repeated to fill the last pair. The resulting flat triangle contributes nothing.
template <std::size_t kPairs, class Lanes>
struct LaneRings {
    using Pairs = typename Lanes::Pairs;

    CCDT_INLINE LaneRings(const Point* points, const MoveGroups::Records<Lanes>& records) {
        const auto position = [&](std::size_t i) CCDT_INLINE {
            std::array<Pair, Lanes::kCount> positions;
            for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) positions[lane] = load(points[records[lane][i]]);
            return Lanes::join(positions);
        };
        const Pairs here = position(0);
        for (std::size_t i = 0; i < kPairs; ++i) {
            const Pairs p = position(1 + 2 * i) - here, q = position(2 + 2 * i) - here;
            x[i] = Lanes::firsts(p, q);
            y[i] = Lanes::seconds(p, q);
        }
        x[kPairs] = x[0];
        y[kPairs] = y[0];
        for (std::size_t i = 0; i < kPairs; ++i) {
            area[i] = x[i] * next_y(i) - y[i] * next_x(i);
            a[i] = y[i] - next_y(i);
            b[i] = next_x(i) - x[i];
        }
    }

    /// Returns the coordinates of the neighbours that follow the ones in x[i] and y[i], counter-clockwise.
    CCDT_INLINE Pairs next_x(std::size_t i) const { return Lanes::shifted(x[i], x[i + 1]); }
    CCDT_INLINE Pairs next_y(std::size_t i) const { return Lanes::shifted(y[i], y[i + 1]); }

    /// Whether all triangles keep enough area when the sites move by (by_x, by_y). The result has two components per
    /// lane, which must both be true.
    /// @param least  least doubled area
    CCDT_INLINE auto fit(typename Lanes::Numbers by_x, typename Lanes::Numbers by_y, double least) const {
        const Pairs move_x = Lanes::twice(by_x), move_y = Lanes::twice(by_y);
        auto fits = move_x == move_x;  // NOLINT(misc-redundant-expression): true in all lanes
        for (std::size_t i = 0; i < kPairs; ++i) {
            const Pairs moved = area[i] + a[i] * move_x + b[i] * move_y;
            fits &= (area[i] == Pairs{}) | ((moved >= kKeptShare * area[i]) & (moved >= least + Pairs{}));
        }
        return fits;
    }

    std::array<Pairs, kPairs + 1> x, y;    ///< positions of the neighbours relative to the site
    std::array<Pairs, kPairs> area, a, b;  ///< doubled areas, and their derivatives along x and y
};

/// Normal equations (see NormalEquations) of sites that are moved at once, one site per lane.
template <class Lanes>
struct LaneEquations {
    using Pairs = typename Lanes::Pairs;
    using Numbers = typename Lanes::Numbers;

    /// Adds two triangles of each site.
    /// @param a, b  derivatives of the residual along x and y
    CCDT_INLINE void add(Pairs a, Pairs b, Pairs residual) {
        xx += a * a;
        xy += a * b;
        yy += b * b;
        x += residual * a;
        y += residual * b;
    }
    CCDT_INLINE std::array<Numbers, 2> minimum() const {
        return ccdt::minimum(Lanes::sum(xx) + stiffness, Lanes::sum(xy), Lanes::sum(yy) + stiffness,
                             Lanes::sum(x) - pull_x, Lanes::sum(y) - pull_y);
    }

    Pairs xx{}, xy{}, yy{}, x{}, y{};
    Numbers stiffness, pull_x, pull_y;  ///< sums over all springs
};

/// Normal equations of one vertex at its current position: half gradient and half Hessian of the energy.
struct NormalEquations {
    double xx = 0, xy = 0, yy = 0;
    Point gradient;

    /// Adds a triangle (vertex, from, to), and half of the springs along its two edges at the vertex.
    void add(Point from, Point to, const GoalTerm& term, double spring) {
        // Twice the area is cross(from, to) = a x + b y + c in the vertex's coordinates.
        const Point growth{term.weight * (from.y - to.y), term.weight * (to.x - from.x)};
        add(growth, term.weight * cross(from, to) - term.target);
        add_springs(from, to, spring * term.spring);
    }

    /// Adds a triangle whose residual (capacity minus target) and gradient of capacity are given.
    void add(Point growth, double residual) {
        xx += growth.x * growth.x;
        xy += growth.x * growth.y;
        yy += growth.y * growth.y;
        gradient = gradient + residual * growth;
    }

    /// Adds half of the springs along a triangle's two edges at the vertex.
    void add_springs(Point from, Point to, double stiffness) {
        add_spring(from, 0.5 * stiffness);
        add_spring(to, 0.5 * stiffness);
    }

    void add_spring(Point spoke, double stiffness) {
        xx += stiffness;
        yy += stiffness;
        gradient = gradient - stiffness * spoke;
    }

    double minimum_along(Point direction) const {
        const double curvature =
            direction.x * direction.x * xx + 2 * direction.x * direction.y * xy + direction.y * direction.y * yy;
        return curvature > 0 ? -dot(gradient, direction) / curvature : 0;
    }
};

}  // namespace ccdt
