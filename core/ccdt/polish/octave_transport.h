// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/elementary.h"
#include "core/base/executor.h"
#include "core/ccdt/polish/push.h"
#include "core/ccdt/polish/wave_grid.h"
#include "core/geometry/axes.h"

namespace ccdt {

/// The part of transport that is the same in the plane and in space. Removes long waves of density error: computes the
/// smoothed difference between actual and wanted density of sites, and small moves of all sites that cancel this
/// difference.
///
/// Moves u change the density of sites by -div(density u), to first order. Let E = sites - density be the error.
/// Chooses the moves for which density u is a gradient, grad phi, so Laplace phi = E. A Fourier transform solves this
/// equation on a torus, and a cosine transform solves it in a box. With the cosine transform, no site leaves the box.
/// Waves shorter than about two spacings are the pattern itself and are not changed. If the density varies, sites and
/// density are both split among octaves of spacing, and each octave has its own limit on the wavelength. One round
/// cancels E to first order. The remaining error is of second order, or due to ridges of the density that are too thin
/// for the gradient to follow.
///
/// Source: one step of Moser's flow (1965; Dacorogna and Moser 1990), which is steepest descent on the energy of long
/// waves; README.md has the derivation.
/// @tparam P  Point or Point3
template <class P>
class OctaveTransport {
public:
    using Grid = BasicWaveGrid<P>;
    using Wave = typename Grid::Wave;

    /// Frequencies are in cycles per spacing.
    struct Filter {
        double cells;                       ///< cells of the grids per spacing
        double end;                         ///< frequency from which on waves are not changed; less than cells / 2
        double (*share)(double frequency);  ///< returns the share of a wave's error that a round removes
    };

    /// The box that contains all of the density, or the torus.
    struct Frame {
        bool torus = false;
        P origin;  ///< the corner with the smallest coordinates
        P sides;

        /// Returns the product of the sides: in the plane, the area.
        double volume() const {
            double volume = sides.x;
            for (std::size_t axis = 1; axis < kAxes<P>; ++axis) volume *= along(sides, axis);
            return volume;
        }
        /// Returns the nearest position in the box, relative to `origin`; on a torus, returns p.
        P position(P p) const {
            if (torus) return p;
            return by_axis<P>([&, here = p - origin](std::size_t axis) {
                return std::clamp(along(here, axis), 0.0, along(sides, axis));
            });
        }
    };

    /// Limit on the number of octaves. Six octaves cover spacings of 1 to 32, which in the plane are densities of 1 to
    /// 1,000. In linear light, pictures of 8 bits give densities of 1 to 113. These are 3.4 octaves of spacing, or 4.1
    /// with the 0.7 octaves that are added for safety.
    static constexpr std::size_t kMaxOctaves = 6;
    static constexpr int kMinCells = 8;  ///< least number of cells of a grid along each axis

    /// @param finest    spacing of octave 0, unless `least` is larger
    /// @param least     lower bound on the spacing of all octaves
    /// @param executor  runs the tasks; must outlive this object
    OctaveTransport(const Frame& frame, double finest, double least, const Filter& filter, Executor& executor);

    /// Returns the argument `finest`; octave_spacing(0) may be larger.
    double finest_spacing() const { return finest_; }
    double octave_spacing(std::size_t octave) const {
        return std::max(least_, finest_ * elementary::exp2(static_cast<double>(octave)));
    }
    /// Returns the grid of octave 0.
    Grid& finest() { return octaves_[0].grid; }
    const Grid& finest() const { return octaves_[0].grid; }

    /// Returns the cell of the finest grid that contains a position in the frame.
    std::size_t cell_of(P p) const {
        std::size_t cell = 0;
        for (std::size_t axis = kAxes<P>; axis-- > 0;) {
            const int cells = finest().cells()[axis];
            double share = along(std::as_const(p), axis) * along(over_sides_, axis);
            share = frame_.torus ? share - whole(share) : std::clamp(share, 0.0, 1.0);
            cell = cell * static_cast<std::size_t>(cells) +
                   static_cast<std::size_t>(std::min(static_cast<int>(share * cells), cells - 1));
        }
        return cell;
    }

    /// Splits sites among octaves. To be called before set_targets() if the spacing varies.
    /// @param spacings  [cells of the finest grid] spacing of the sites
    /// @param mass_of   returns the number of wanted sites in a cell of the finest grid
    /// @param stop      polled regularly; after a stop, this object must not be used
    template <class MassOf>
    void assign_octaves(std::span<const double> spacings, MassOf&& mass_of, const std::stop_token& stop) {
        levels_.resize(spacings.size());
        std::vector<std::uint16_t> highest((spacings.size() + kCells - 1) / kCells, 0);
        for_ranges(executor_, spacings.size(), kCells, [&](std::size_t begin, std::size_t end) {
            std::uint16_t& own = highest[begin / kCells];
            if (stop.stop_requested()) return;
            for (std::size_t cell = begin; cell < end; ++cell) {
                levels_[cell] = level_of(spacings[cell]);
                if (levels_[cell] > own && mass_of(cell) > 0) own = levels_[cell];
            }
        });
        add_octaves(std::ranges::max(highest));
    }

    /// Sets the wanted density, which is uniform otherwise.
    /// @param mass_of  returns the number of wanted sites in a cell of the finest grid
    /// @param stop     polled regularly; after a stop, this object must not be used
    template <class MassOf>
    void set_targets(MassOf&& mass_of, const std::stop_token& stop) {
        for (std::size_t octave = 0; octave < octaves_.size(); ++octave) {
            const std::span<double> values = finest().grid();
            for_ranges(executor_, values.size(), kCells, [&](std::size_t begin, std::size_t end) {
                if (stop.stop_requested()) return;
                for (std::size_t i = begin; i < end; ++i) {
                    const double share = levels_.empty() ? 1 : part(levels_[i], octave);
                    values[i] = share > 0 ? share * mass_of(i) : 0;
                }
            });
            if (stop.stop_requested()) return;
            add_targets(octave);
        }
    }
    /// Sets the wanted density to the sum of the points spread since clear().
    /// @param piece  sides of the boxes that these points stand for
    void set_targets_from_spread(P piece, const std::stop_token& stop);

    void clear() {
        for (Octave& octave : octaves_) octave.grid.clear();
    }
    /// Spreads points on the grids of their octaves.
    /// @param positions  relative to the origin of the frame, as Frame::position() returns them
    /// @param weights    [at most positions] weights of the last points; all points before them have weight 1
    void spread(std::span<const P> positions, std::span<const double> weights);

    /// Spreads sites in the domain, as above, and transforms the grids. Returns false after a stop.
    bool measure(std::span<const P> sites, std::span<const double> weights, const std::stop_token& stop);

    /// Returns the largest power of a wave that find_moves() will remove, relative to the power of random points. Must
    /// be called after measure(). Only for a uniform wanted density, without set_targets().
    double largest_power(double sites);

    /// Computes the moves that cancel the measured error. The next call must be measure().
    /// @param moves       out [sites], each at most kMaxMove times the local spacing
    /// @param spacing_of  returns the local spacing at a site
    /// @returns           false after a stop; the moves must not be used then
    template <class Spacing>
    bool find_moves(std::span<const P> sites, std::span<P> moves, Spacing&& spacing_of, const std::stop_token& stop) {
        if (stop.stop_requested()) return false;
        finest().with_coefficients([&](auto total) { solve(total); });
        if (stop.stop_requested()) return false;
        finest().transform_back();
        const double unit = octave_spacing(0), scale = unit * unit / (finest().copies() * frame_.volume());
        for_ranges(executor_, sites.size(), kSites, [&](std::size_t begin, std::size_t end) {
            if (stop.stop_requested()) return;
            for (std::size_t i = begin; i < end; ++i) moves[i] = frame_.position(sites[i]);
            finest().gradients(moves.subspan(begin, end - begin), moves.subspan(begin, end - begin));
            for (std::size_t i = begin; i < end; ++i) {
                const double spacing = spacing_of(sites[i]);
                double factor = scale;
                for (std::size_t axis = 0; axis < kAxes<P>; ++axis) factor *= spacing;
                moves[i] = capped(factor * moves[i], kMaxMove * spacing);
            }
        });
        return !stop.stop_requested();
    }

    /// Releases most of the memory until the next call of clear() or measure().
    void release_memory() {
        for (Octave& octave : octaves_) octave.grid.release_memory();
    }

private:
    /// The long waves in a line of coefficients. Their coefficients are the first ones of the line.
    struct Line {
        std::size_t count;
        std::size_t factors;  ///< index of the first factor; waves that differ in the signs along y and z share it
        std::size_t targets;  ///< index of the first target
    };
    /// The grid for sites whose spacing is about 2^octave times the finest spacing.
    struct Octave {
        Grid grid;
        std::vector<Line> lines;  ///< [lines of coefficients]
        /// Factors that convert the coefficients of the sites to this octave's share of the potential.
        std::vector<float> factors;

        /// Returns the number of long waves.
        std::size_t waves() const { return lines.back().targets + lines.back().count; }
    };

    // Number of sites or cells per task. In space, sites take longer.
    static constexpr std::size_t kSites = kAxes<P> == 2 ? 8192 : 512, kCells = 16384;
    /// Longest move, in spacings. Even if two neighbours of a hexagonal grid, 1.07 spacings apart, move straight
    /// towards each other, they keep more than half of their distance.
    static constexpr double kMaxMove = 0.25;
    static constexpr double kLevels = 8192;  ///< steps per octave

    /// Single-precision storage of a coefficient.
    template <class Coefficient>
    using Kept = std::conditional_t<std::is_same_v<Coefficient, double>, float, std::complex<float>>;

    void add_octave();
    double potential_of(const Wave& wave) const;
    template <class Visit>
    void for_long_waves(const Octave& octave, Visit&& visit) const;
    std::uint16_t level_of(double spacing) const;
    void add_octaves(std::uint16_t highest);
    void add_targets(std::size_t octave);
    /// Computes the coefficients of the values that were spread on the grids. Returns false after a stop.
    bool transform(const std::stop_token& stop) {
        for (Octave& octave : octaves_) {
            if (stop.stop_requested()) return false;
            octave.grid.transform();
        }
        return true;
    }
    /// Returns the weight with which sites count in an octave. The spacing of the sites usually lies between two
    /// octaves, which then share the weight. The weights of all octaves add up to 1.
    /// @param level  an element of levels_
    static double part(std::uint16_t level, std::size_t octave) {
        return std::max(0.0, 1 - std::abs(level / kLevels - static_cast<double>(octave)));
    }
    template <class Coefficient>
    void solve(std::span<Coefficient> total);

    Executor& executor_;
    Frame frame_;
    P over_sides_;  ///< 1 / sides
    double finest_, least_;
    Filter filter_;
    std::vector<Octave> octaves_;
    /// [long waves of octave 0] potential of the wanted density alone; empty if the wanted density is uniform
    std::variant<std::vector<float>, std::vector<std::complex<float>>> targets_;
    /// [cells of octave 0] fractional octave of the sites in the cell, multiplied by kLevels
    std::vector<std::uint16_t> levels_;
};

extern template class OctaveTransport<Point>;
extern template class OctaveTransport<Point3>;

}  // namespace ccdt
