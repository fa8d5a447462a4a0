#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>
#include <stop_token>
#include <variant>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/polish/local_spacing.h"
#include "core/polish/spline_grid.h"

namespace ccdt {

/// Evens out long waves: finds how far the sites' density, smoothed over a few of them, is off the wanted one, and
/// small displacements of all sites that undo it.
///
/// Displacements u change the sites' density by -div(density u). Of all that undo an error E = sites - density the one
/// is taken for which density u is a gradient, grad phi: Laplace phi = E, which a Fourier transform solves on a torus,
/// and a cosine transform in a box that no site leaves. Waves shorter than about two spacings are the pattern itself,
/// not an error, and are left alone. Where the density varies, sites and density are split among octaves of spacing
/// alike, each with its own limit. To first order a round undoes E; what is left is of second order, and of ridges so
/// thin that the gradient cannot follow them. In a box all this is done where there is density at all: margins without
/// any count for nothing.
///
/// Departs from a plain blur in that what is called an error ends sharply: no wave below is left, none above is harmed.
/// Source: one step of Moser's flow (1965; Dacorogna and Moser 1990), which is steepest descent on the energy of long
/// waves; core/README.md derives it.
class Transport {
public:
    /// @param domain   a box or a torus; its sides and the density's values are in the ranges that their headers name,
    ///                 so that contrast, spacings and the grids' sides are finite and not 0
    /// @param density  must outlive this
    /// @param sites    >= 1
    /// @param stop     asked now and then; leaves what is of no use
    /// @param team     must outlive this
    /// O(density's cells + sites log sites).
    Transport(const Domain& domain, const Density& density, std::size_t sites, const std::stop_token& stop = {},
              Team& team = alone());

    /// Computes the moves of a round.
    /// @param sites    [sites] in the unit frame; inside, on a torus anywhere
    /// @param moves    out [sites], none longer than a quarter of the spacing there
    /// @param stop     asked now and then
    /// @param weights  of the last sites, which count as so many each; all others count as one
    /// @returns      false if it was stopped: the moves are of no use
    /// O(sites log sites).
    bool displacements(std::span<const Point> sites, std::span<Point> moves, const std::stop_token& stop = {},
                       std::span<const double> weights = {});

    /// 1 / sqrt(density of sites) around a point, the density smoothed over a spacing; in the unit frame. Where sites
    /// are denser than octaves go, over as little as holds one.
    double spacing(Point p) const;

    /// Gives back what most of the memory is for until displacements() are asked for again.
    void rest();

private:
    /// Sites whose spacing is about 2^octave times the finest.
    struct Octave {
        SplineGrid grid;
        /// From coefficients to their share of the potential's; see factor().
        std::vector<float> factors;

        /// For the coefficient (column, row), the same for (column, -row).
        float& factor(int column, int row) { return factors[grid.number(column, std::abs(row))]; }
    };

    void add_octave();
    double potential_of(int column, int row) const;
    double octave_spacing(std::size_t octave) const;
    std::vector<double> masses(const Density& density, const CellBlock& block) const;
    std::span<const double> smooth(const std::vector<double>& masses, double sigma);
    void assign_octaves(const std::vector<double>& masses);
    void set_targets(const std::vector<double>& masses, const std::stop_token& stop);
    void set_fine_targets(const Density& density, const CellBlock& block, const std::stop_token& stop);
    Point in_box(Point p) const;
    std::size_t cell_of(Point p) const;
    static double part(std::uint16_t level, std::size_t octave);
    void clear();
    void spread(Point p, double weight);
    bool transform(const std::stop_token& stop);
    bool spread(std::span<const Point> sites, std::span<const double> weights, const std::stop_token& stop);
    template <class Coefficient>
    void solve(std::span<Coefficient> total);

    Team& team_;
    bool torus_;
    bool uniform_;
    Point origin_;  ///< of the box that holds all of the density, and its sides
    Point sides_;
    Point over_sides_;  ///< 1 over these
    double sites_;
    double finest_ = 0;   ///< spacing of octave 0
    double in_line_ = 0;  ///< the same, were all sites in a line along the longer side; grids are no finer
    std::vector<Octave> octaves_;
    /// [coefficients of octave 0] of the potential that the density alone would have, if it is not uniform.
    std::variant<std::vector<float>, std::vector<std::complex<float>>> targets_;
    std::vector<std::uint16_t> levels_;    ///< [cells of octave 0] octave that sites there belong to, in kLevels
    std::vector<std::uint16_t> spacings_;  ///< [cells of octave 0] over octave 0's, shortened()
    std::optional<LocalSpacing> denser_;   ///< if sites are closer somewhere than octave 0 resolves
};

}  // namespace ccdt
