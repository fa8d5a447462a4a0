// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "core/halftone/colour_table.h"
#include "core/halftone/overprint.h"

namespace ccdt {

/// Finds the shares of a ground that dots flip to make a colour, where the ground is solid ink or none of each ink, and
/// a dot of a kind flips a set of inks.
///
/// Dots lie side by side, so the mean colour is linear in the shares: each adds what its inks, printed over each other
/// and the paper, differ from the ground. Of all shares whose sum is kMost at most, those are chosen whose colour
/// differs least (ColourDifference), and of shares that look alike those that cover least and stand out least. For
/// ideal cyan, magenta and yellow these are nested. A table per ground holds the shares for all colours. May be used
/// from any thread.
class KindMixture {
public:
    static constexpr std::size_t kMostKinds = (std::size_t{1} << kMostInks) - 1;
    using Shares = std::array<float, kMostKinds>;
    using Channels = std::array<float, 3>;

    /// Sum of the shares, at most and nearly: beyond a half where the ground is that of the neighbourhood.
    static constexpr double kMost = 0.6;

    /// @param kinds  inks that dots of each kind flip, as bits
    KindMixture(const InkSet& inks, std::vector<unsigned> kinds);

    std::size_t count() const { return kinds_.size(); }

    /// Returns the share of each kind [count()]; further ones are 0.
    /// @param ground  inks of the ground, as bits
    /// @param wanted  in [0, 1]
    Shares shares(unsigned ground, const Light& wanted);

    /// Returns the light of a ground and shares of dots on it.
    Channels light(unsigned ground, const Shares& shares) const;

    /// Returns how much light a share of dots of a kind adds, over that share.
    Channels change(unsigned ground, std::size_t kind) const;

private:
    Shares solve(unsigned ground, const Light& wanted) const;

    std::vector<unsigned> kinds_;
    std::vector<Overprint::Channels> colours_;                  ///< by the inks that lie on each other, as bits
    std::vector<std::unique_ptr<ColourTable<Shares>>> tables_;  ///< by the ground; null until it is asked
    std::mutex making_;
};

}  // namespace ccdt
