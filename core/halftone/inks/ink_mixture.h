// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/halftone/inks/colour_table.h"
#include "core/halftone/inks/overprint.h"

namespace ccdt {

/// Finds the share of the area that each set of inks must cover to reproduce a colour.
///
/// Areas of different sets lie side by side, so the mean light is linear in the shares. Of all shares with the wanted
/// light, the result has the least sum of w (D + tau log w), where w is the share of a set, and D is the squared
/// difference of its colour from the wanted colour. So sets that look like the wanted colour are preferred, and shares
/// change smoothly with the colour. A colour outside the gamut becomes the nearest one by ColourDifference. The results
/// are cached in a table. Thread-safe.
class InkMixture {
public:
    static constexpr std::size_t kMaxSets = std::size_t{1} << kMaxInks;
    using Shares = std::array<float, kMaxSets>;

    /// @param sets  sets of inks, as bits
    InkMixture(const InkSet& inks, std::vector<unsigned> sets);

    std::size_t count() const { return sets_.size(); }

    /// Returns the share of each set [count()]; the remaining entries are 0.
    /// @param wanted  colour in [0, 1]
    Shares shares(const Light& wanted) { return table_(wanted); }

    /// Returns the colours of the nodes of the table between which shares() interpolates for any of `colours`, each
    /// once.
    std::vector<Light> nodes_of(const std::vector<Light>& colours) const { return table_.nodes_of(colours); }

    /// Returns the shares without interpolation in the table.
    Shares solve(const Light& wanted) const;

    /// Returns the light of an area that a set of inks covers.
    const Overprint::Channels& light(std::size_t set) const { return colours_[set]; }

    /// Returns the mean light of an area that sets of inks share.
    Overprint::Channels light(const Shares& shares) const;

private:
    std::vector<unsigned> sets_;
    std::vector<Overprint::Channels> colours_;  ///< [sets]
    ColourTable<Shares> table_;
};

/// Returns the sets of inks, as bits, from dark to light. Of sets with the same colour, such as those that contain
/// black, returns the one with the fewest inks.
std::vector<unsigned> sets_by_luminance(const InkSet& inks);

/// Returns the light of an area that a set of inks covers.
/// @param set  inks, as bits
Light light_of_set(const InkSet& inks, unsigned set);

}  // namespace ccdt
