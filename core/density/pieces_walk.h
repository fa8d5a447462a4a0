#pragma once

#include <cstddef>

#include "core/geometry/lanes.h"

namespace ccdt {

/// Segments ab side by side, one for each number of the lanes.
template <class Lanes>
struct Segments {
    static constexpr std::size_t kCount = 2 * Lanes::kCount;
    typename Lanes::Pairs ax, ay, bx, by;
};

/// Cuts each of several segments as walk_cells() does, horizontal ones too, and calls `visit(column, row, from, to)`
/// with whole numbers and where on each segment a piece lies: 0 at a, 1 at b. There are as many calls as the segment of
/// most pieces has; to the others of length 0 are added. What comes of a segment is the same to the bit whatever lies
/// beside it, and in whichever lanes.
///
/// @param columns, rows  cells of the grid; the segments lie within it, but for rounding
template <class Lanes, class Visit>
CCDT_INLINE inline void walk_pieces(const Segments<Lanes>& segments, int columns, int rows, Visit&& visit) {
    using Pairs = typename Lanes::Pairs;
    constexpr double kNever = 2, kShortest = 1e-290;  // shorter sides have no inverse
    const Pairs none{}, one = none + 1.0;
    const auto within = [&](Pairs place, int count) CCDT_INLINE {
        const Pairs last = none + (count - 1.0), above = place < none ? none : place;
        return above < last ? above : last;
    };
    /// Where lines across one axis cut the segments.
    struct Axis {
        Pairs step;  ///< to the next cell
        Pairs cell;
        Pairs distance;  ///< to the next line, from a
        Pairs inverse;
        Pairs after;

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
