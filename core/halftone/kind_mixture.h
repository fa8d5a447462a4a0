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

/// Finds the share that each kind of dots must cover on a given ground to reproduce a colour. A ground is a set of
/// solid inks. The dots of a kind flip a set of inks.
///
/// Dots lie side by side, so the mean light is linear in the shares. Each kind adds its share multiplied by the
/// difference between the light of a dot and the light of the ground. Of all shares with a sum of at most kMaxCover,
/// the result has the least ColourDifference from the wanted colour. Small penalties on coverage and contrast decide
/// between shares that look alike. For ideal cyan, magenta and yellow, the resulting flipped areas of the inks are
/// nested. The results are cached in a table for each ground. Thread-safe.
class KindMixture {
public:
    static constexpr std::size_t kMaxKinds = (std::size_t{1} << kMaxInks) - 1;
    using Shares = std::array<float, kMaxKinds>;
    using Channels = std::array<float, 3>;

    /// Approximate upper limit of the sum of the shares. It is above one half, because a cell may have the ground of
    /// its neighbourhood instead of its own best ground.
    static constexpr double kMaxCover = 0.6;

    /// @param kinds  inks that each kind flips, as bits
    KindMixture(const InkSet& inks, std::vector<unsigned> kinds);

    std::size_t count() const { return kinds_.size(); }

    /// Returns the share of each kind [count()]; the remaining entries are 0.
    /// @param ground  inks of the ground, as bits
    /// @param wanted  colour in [0, 1]
    Shares shares(unsigned ground, const Light& wanted);

    /// Returns the mean light of a ground with dots that cover the given shares.
    Channels light(unsigned ground, const Shares& shares) const;

    /// Returns the light that dots of a kind add to a ground, divided by the share that they cover.
    Channels change(unsigned ground, std::size_t kind) const;

private:
    Shares solve(unsigned ground, const Light& wanted) const;

    std::vector<unsigned> kinds_;
    std::vector<Overprint::Channels> colours_;  ///< [2^inks] light of each set of inks, printed over each other
    /// [2^inks] table of each ground; null until the ground is first used.
    std::vector<std::unique_ptr<ColourTable<Shares>>> tables_;
    std::vector<std::once_flag> is_made_;  ///< [2^inks] whether the table exists
};

}  // namespace ccdt
