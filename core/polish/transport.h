// SPDX-License-Identifier: GPL-3.0-or-later
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

/// Removes long waves of density error. Computes the smoothed difference between actual and wanted density of sites,
/// and small moves of all sites that cancel this difference.
///
/// Moves u change the density of sites by -div(density u), to first order. Let E = sites - density be the error.
/// Chooses the moves for which density u is a gradient, grad phi, so Laplace phi = E. A Fourier transform solves this
/// equation on a torus, and a cosine transform solves it in a box. With the cosine transform, no site leaves the box.
/// Waves shorter than about two spacings are the pattern itself and are not changed. If the density varies, sites and
/// density are both split among octaves of spacing, and each octave has its own limit on the wavelength. One round
/// cancels E to first order. The remaining error is of second order, or due to ridges of the density that are too thin
/// for the gradient to follow. In a box, the grid covers only the bounding box of nonzero density.
///
/// Departure from a plain blur: the filter ends sharply, so that all waves longer than the limit are removed and
/// shorter waves are not affected.
/// Source: one step of Moser's flow (1965; Dacorogna and Moser 1990), which is steepest descent on the energy of long
/// waves; core/README.md has the derivation.
class Transport {
public:
    /// @param domain    a box or a torus; the documented ranges of its sides, and of the density's values, keep
    ///                  contrast, spacings and grid sizes finite and nonzero
    /// @param density   must outlive this object
    /// @param sites     >= 1
    /// @param stop      polled regularly; after a stop the object must not be used
    /// @param executor  runs the tasks; must outlive this object
    ///
    /// O(the density's cells + sites log sites).
    Transport(const Domain& domain, const Density& density, std::size_t sites, const std::stop_token& stop = {},
              Executor& executor = inline_executor());

    /// Computes the moves of one round.
    /// @param sites    [sites] in the unit frame, in the domain; on a torus, any periodic copy
    /// @param moves    out [sites], each at most a quarter of the local spacing
    /// @param stop     polled regularly
    /// @param weights  [at most sites] weights of the last sites; all sites before them have weight 1
    /// @returns        false after a stop; the moves must not be used then
    ///
    /// O(sites log sites).
    bool displacements(std::span<const Point> sites, std::span<Point> moves, const std::stop_token& stop = {},
                       std::span<const double> weights = {});

    /// Returns 1 / sqrt(density of sites) around a point in the unit frame. The density is smoothed over a spacing. If
    /// sites are denser than the octaves resolve, uses the density of the smallest block of cells that wants one site
    /// (LocalSpacing).
    double spacing(Point p) const;

    /// Releases most of the memory until the next call of displacements().
    void release_memory();

private:
    /// The grid for sites whose spacing is about 2^octave times the finest spacing.
    struct Octave {
        SplineGrid grid;
        /// Factors that convert the coefficients of the sites to this octave's share of the potential; see factor().
        std::vector<float> factors;

        /// Returns the common factor of the coefficients (column, row) and (column, -row).
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

    Executor& executor_;
    bool torus_;
    bool uniform_;
    Point origin_;  ///< lower left corner of the box that contains all of the density
    Point sides_;
    Point over_sides_;  ///< 1 / sides_
    double sites_;
    double finest_ = 0;  ///< spacing of octave 0
    /// The spacing if all sites stood on a line along the longer side; a lower bound of the octaves' spacings.
    double in_line_ = 0;
    std::vector<Octave> octaves_;
    /// [coefficients of octave 0] potential of the wanted density alone; empty if the wanted density is uniform
    std::variant<std::vector<float>, std::vector<std::complex<float>>> targets_;
    /// [cells of octave 0] fractional octave of the sites in the cell, multiplied by kLevels
    std::vector<std::uint16_t> levels_;
    std::vector<std::uint16_t> spacings_;  ///< [cells of octave 0] spacing relative to octave 0, encoded by shortened()
    std::optional<LocalSpacing> denser_;   ///< present if sites are denser anywhere than octave 0 resolves
};

}  // namespace ccdt
