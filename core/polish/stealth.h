#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include "core/analysis/nonuniform_transform.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/parallel/team.h"
#include "core/polish/spline_grid.h"

namespace ccdt {

/// Takes all power out of the low frequencies of sites on a torus of uniform density, by the smallest moves that do.
///
/// With F(k) = sum over sites j of e^(-2 pi i k.x_j), moves u change F by J u, to first order. Of all with F + J u = 0
/// the least by sum of squares is the gradient of a potential of these frequencies alone: u = J* p, J J* p = -F. There
/// are 0.79 equations a site below kLimit, and two unknowns, so that J J* is well-conditioned: conjugate gradients,
/// preconditioned by its diagonal, take about five steps. That is Newton's method: each round squares what is left.
///
/// Sets without low frequencies are known as stealthy. Source: Batten, Stillinger, Torquato 2008, who minimise
/// sum |F|^2 by steepest descent from random sites; here they start so near that a few rounds do.
class Stealth {
public:
    /// Frequencies below this, over sqrt(sites / area), are silenced.
    static constexpr double kLimit = 0.5;
    /// Power, of which random sites have 1, below which a frequency is silent. Rounding makes 1e-18 or so.
    static constexpr double kSilence = 1e-12;

    /// The fewest sites of a torus for which it is wide enough: four of their spacings, sqrt(area / sites), each way.
    static double fewest_sites(Point sides);

    /// Tells whether a torus is wide enough for so many sites, its sides taken for what they were before rounding.
    static bool fits(const Domain& torus, std::size_t sites);

    /// @param torus  that fits the sites
    /// About 400 bytes a site.
    /// @param team  must outlive this
    Stealth(const Domain& torus, std::size_t sites, Team& team = alone());

    /// Computes the moves of a round.
    /// @param sites  [sites] in the unit frame; anywhere
    /// @param moves  out [sites]
    /// @param stop   asked now and then
    /// @returns      false if it was stopped, or all is silent: the moves are of no use
    /// Same input, same bytes. O(sites log sites).
    bool displacements(std::span<const Point> sites, std::span<Point> moves, const std::stop_token& stop = {});

    /// The largest power among the frequencies, of the sites before the last moves.
    double loudest() const { return loudest_; }

private:
    using Coefficients = std::vector<std::complex<double>>;  ///< [waves_]

    struct Wave {
        int column, row;  ///< cycles along the torus' sides; column >= 0
        double diagonal;  ///< of J J*
    };

    bool listen(std::span<const Point> sites, const std::stop_token& stop);
    void find_moves(const Coefficients& potential, std::span<const Point> sites, std::span<Point> moves);
    void change_of(std::span<const Point> sites, std::span<const Point> moves, Coefficients& change);
    double product(const Coefficients& a, const Coefficients& b) const;
    void precondition(const Coefficients& from, Coefficients& to) const;

    Team& team_;
    Point sides_;
    double sites_;
    std::vector<Wave> waves_;  ///< one of each pair k, -k
    NonuniformTransform listener_;
    std::vector<WeightedPoint> listened_;  ///< [sites]
    SplineGrid grid_;
    double loudest_ = 0;
    Coefficients sums_;  ///< F
};

}  // namespace ccdt
