// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "core/base/lanes.h"

namespace ccdt {

/// Several segments ab. Each lane holds a pair of segments.
template <class Lanes>
struct Segments {
    static constexpr std::size_t kCount = 2 * Lanes::kCount;
    typename Lanes::Pairs ax, ay, bx, by;
};

/// Cuts several segments at once at the lines of a grid of unit cells, like walk_cells(). Calls `visit(column, row,
/// from, to)` for one piece of each segment: the piece's cell, as whole numbers, and the parameters of its ends along
/// the segment, 0 at a and 1 at b. Horizontal segments are visited, too. The number of calls is the largest number of
/// pieces of any segment; the other segments get additional pieces of length 0. The pieces of a segment depend neither
/// on the other segments nor on the lane, bit for bit.
///
/// @param columns, rows  size of the grid in cells; the segments lie within the grid, except for rounding
template <class Lanes, class Visit>
CCDT_INLINE inline void walk_pieces(const Segments<Lanes>& segments, int columns, int rows, Visit&& visit) {
    using Pairs = typename Lanes::Pairs;
    constexpr double kNever = 2, kShortest = 1e-290;  // kShortest: shorter sides have no finite inverse
    const Pairs none{}, one = none + 1.0;
    const auto within = [&](Pairs position, int count) CCDT_INLINE {
        const Pairs last = none + (count - 1.0), above = position < none ? none : position;
        return above < last ? above : last;
    };
    /// Crossings of the segments with the grid lines across one axis.
    struct Axis {
        Pairs step;  ///< 1 or -1, from a cell to the next one
        Pairs cell;
        Pairs distance;  ///< from a to the next grid line, along the axis, in cells; negative if b < a
        Pairs inverse;   ///< 1 / (b - a) along the axis; 0 if b - a is almost 0
        Pairs after;     ///< 0; or 2 if b - a is almost 0, so that the segment never reaches next()

        CCDT_INLINE Pairs next() const { return distance * inverse + after; }
    };
    const auto axis = [&](Pairs a, Pairs b, int count) CCDT_INLINE {
        const Pairs along = b - a, ahead = along > none ? one : none;
        const auto moves = (along > kShortest + none) | (along < none - kShortest);
        const Pairs cell = within(Lanes::whole(a), count);
        return Axis{2.0 * ahead - 1.0, cell, cell + ahead - a, moves ? one / along : none,
                    moves ? none : none + kNever};
    };
    Axis x = axis(segments.ax, segments.bx, columns), y = axis(segments.ay, segments.by, rows);
    Pairs next_x = x.next(), next_y = y.next(), from = none;
    for (;;) {
        const Pairs next = next_x < next_y ? next_x : next_y, nearer = next < one ? next : one;
        const Pairs to = nearer < from ? from : nearer;
        visit(within(x.cell, columns), within(y.cell, rows), from, to);
        if (!Lanes::any(to < one)) return;
        from = to;
        const auto across = next_x <= next_y;
        const Pairs step_x = across ? x.step : none, step_y = across ? none : y.step;
        x.cell += step_x;
        x.distance += step_x;
        y.cell += step_y;
        y.distance += step_y;
        next_x = x.next();
        next_y = y.next();
    }
}

}  // namespace ccdt
