// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/ccdt/polish/nonuniform_transform.h"
#include "core/ccdt/polish/wave_grid.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Removes all power from the low frequencies of sites on a torus of uniform density, by the smallest possible moves.
///
/// Let F(k) = sum over sites j of e^(-2 pi i k.x_j). Moves u change F by J u, to first order. Of all moves with F + J u
/// = 0, those with the least sum of squares are the gradient of a potential that has low frequencies only: u = J* p, J
/// J* p = -F. Below kLimit there are 0.79 equations and two unknowns per site, so J J* is well-conditioned. Conjugate
/// gradients, preconditioned by the diagonal, take about five steps. The rounds together are Newton's method: each
/// round squares the relative error.
///
/// Point sets without low frequencies are called stealthy. Source: Batten, Stillinger, Torquato 2008. They minimise sum
/// |F|^2 by steepest descent from random sites. Here, the initial sites are close to a solution.
class Stealth {
public:
    /// Upper limit of the removed frequencies, in units of sqrt(sites / area).
    static constexpr double kLimit = 0.5;
    /// Power below which a frequency counts as removed. Random sites have power 1. Rounding leaves about 1e-18.
    static constexpr double kNegligiblePower = 1e-12;

    /// Returns the least number of sites for which a torus is wide enough: at least four spacings in each direction,
    /// where the spacing is sqrt(area / sites).
    static double fewest_sites(Point sides);

    /// Whether a torus is wide enough for a number of sites. Tolerates the rounding of its sides.
    static bool fits(const Domain& torus, std::size_t sites);

    /// @param torus     wide enough for the sites, see fits()
    /// @param executor  runs the tasks; must outlive this object
    ///
    /// Needs about 400 bytes of memory per site.
    Stealth(const Domain& torus, std::size_t sites, Executor& executor = inline_executor());

    /// Computes the moves of one round.
    /// @param sites  [sites] in the unit frame; any periodic copy
    /// @param moves  out [sites]
    /// @param stop   polled regularly
    /// @returns      false, with unusable moves, after a stop or if no low frequency has power above kNegligiblePower
    ///
    /// Deterministic. O(sites log sites).
    bool displacements(std::span<const Point> sites, std::span<Point> moves, const std::stop_token& stop = {});

    /// Returns the largest power among the low frequencies, measured before the last moves.
    double largest_power() const { return largest_power_; }

private:
    using Coefficients = std::vector<std::complex<double>>;  ///< [waves_] one coefficient for each wave

    struct Wave {
        int column, row;  ///< cycles along the torus' sides; column >= 0
        double diagonal;  ///< diagonal element of J J*
    };

    bool measure(std::span<const Point> sites, const std::stop_token& stop);
    void find_moves(const Coefficients& potential, std::span<const Point> sites, std::span<Point> moves);
    void change_of(std::span<const Point> sites, std::span<const Point> moves, Coefficients& change);
    double product(const Coefficients& a, const Coefficients& b) const;
    void precondition(const Coefficients& from, Coefficients& to) const;

    Executor& executor_;
    Point sides_;
    double sites_;
    std::vector<Wave> waves_;  ///< one wave of each pair k, -k
    NonuniformTransform transform_;
    std::vector<WeightedPoint> positions_;  ///< [sites] positions relative to the torus' sides
    WaveGrid grid_;
    double largest_power_ = 0;
    Coefficients sums_;  ///< F(k) of each wave
};

}  // namespace ccdt
