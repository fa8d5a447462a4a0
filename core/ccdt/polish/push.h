// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>

#include "core/ccdt/polish/cell_list.h"

// Pushes in the plane and in space. P is Point or Point3.
namespace ccdt {

/// Returns a move, shortened to `longest` if it is longer.
template <class P>
P capped(P move, double longest) {
    const double length = std::sqrt(dot(move, move));
    return length > longest ? (longest / length) * move : move;
}

/// Pushes a site away from another one that is nearer than `wanted`, by a share of the missing distance.
struct PairPush {
    double wanted, share;

    /// Returns the move of a site at a distance from the other one.
    /// @param away  vector from the other site to the site, of length `distance`. If it is turned or scaled, so is the
    ///              move
    template <class P>
    P move(P away, double distance) const {
        return share * (wanted / distance - 1) * away;
    }
};

/// Returns a move, plus the moves of a site due to pushes off all listed sites.
/// @param range    largest distance of a site that pushes
/// @param push_of  called with the number of a listed site and its distance; returns the PairPush
/// @param apart    called without arguments; returns the vector that replaces the zero vector from a coincident site to
///                 this site. If it is zero, coincident sites do not push
template <class P, class PushOf, class Apart>
P pushed_off(const BasicCellList<P>& sites, P p, double range, P move, PushOf&& push_of, Apart&& apart) {
    sites.for_near(p, range, [&](P other, std::uint32_t number) {
        const P away = p == other ? apart() : p - other;
        const double squared = dot(away, away);
        if (squared >= range * range || squared == 0) return;
        const double distance = std::sqrt(squared);
        const PairPush push = push_of(number, distance);
        if (distance < push.wanted) move = move + push.move(away, distance);
    });
    return move;
}

/// Returns the same, for sites that do not push coincident sites.
template <class P, class PushOf>
P pushed_off(const BasicCellList<P>& sites, P p, double range, P move, PushOf&& push_of) {
    return pushed_off(sites, p, range, move, push_of, [] { return P{}; });
}

}  // namespace ccdt
