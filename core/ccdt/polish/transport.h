// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/ccdt/polish/local_spacing.h"
#include "core/ccdt/polish/octave_transport.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Removes long waves of density error in the plane; see OctaveTransport. In a box, the grid covers only the bounding
/// box of nonzero density.
///
/// Departure from a plain blur: the filter ends sharply, so that all waves longer than the limit are removed and
/// shorter waves are not affected.
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
    void release_memory() { octaves_->release_memory(); }

private:
    std::vector<double> masses(const Density& density, const CellBlock& block) const;
    std::span<double> smooth(const std::vector<double>& masses, double sigma);
    void assign_octaves(const std::vector<double>& masses, const std::stop_token& stop);
    void set_fine_targets(const Density& density, const CellBlock& block, const std::stop_token& stop);

    Executor& executor_;
    OctaveTransport<Point>::Frame frame_;
    double sites_;
    std::optional<OctaveTransport<Point>> octaves_;  ///< always present after construction
    std::vector<std::uint16_t> spacings_;  ///< [cells of octave 0] spacing relative to octave 0, encoded by shortened()
    std::optional<LocalSpacing> denser_;   ///< present if sites are denser anywhere than octave 0 resolves
};

}  // namespace ccdt
