// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/base/result.h"
#include "core/geometry/point3.h"
#include "core/points/choice/candidate_cells.h"

namespace ccdt {

/// Candidates of a choice, and what is wanted of them. An empty span stands for equal values.
struct Candidates {
    std::span<const Point3> positions;  ///< [n], may coincide; in the plane, z is 0
    choice::Extent extent = choice::Extent::Plane;
    /// [n] wanted density of chosen points around each candidate; only ratios matter. 0: the candidate is never chosen
    std::span<const double> density;
    std::span<const double> priority;    ///< [n] of candidates that are close to each other, higher ones are preferred
    std::span<const std::uint8_t> kept;  ///< [n] 1 for candidates that are always chosen, whatever their density
    /// [n] class of each candidate. Chosen points of a class are spread evenly, and those of all classes together.
    std::span<const std::uint32_t> classes;
    /// Number of points of each class; without it, in proportion to the candidates that can be chosen.
    std::span<const std::size_t> counts;
    std::optional<Point3> torus;  ///< sides of a torus from the origin that contains the positions; z may be 0
};

/// A region with too few candidates: a block of 4 x 4 cells of the grid, or 4 x 4 x 4 in space.
struct Shortfall {
    std::uint32_t row;  ///< index of a candidate in the region
    double points;      ///< number of points that are wanted there, but chosen elsewhere
};

/// Chosen candidates.
struct ChosenCandidates {
    std::vector<std::uint32_t> rows;  ///< indices, ascending
    /// Number of points that are wanted where there are some candidates, but too few. They are chosen elsewhere
    /// instead.
    std::size_t shortfall = 0;
    std::vector<Shortfall> shortfalls = {};  ///< by region, the largest first
};

/// Chooses exactly `count` candidates, so that they are spread evenly or with the wanted density, however dense the
/// candidates are. Each cell of a grid that holds candidates wants a number of points: its size times its density. A
/// walk along a curve through the cells makes a first choice. An exchange search (exchange_search.h) improves it. With
/// classes, this is done for each of them, and then twice more with the energy of the points of the other classes.
///
/// @param count  0 to the number of candidates; the sum of the counts of classes, if there are any
/// @param stop   after a stop, the choice is less even
/// Errors: Malformed for a position, density or priority that is not finite, or a negative density (the field is
/// candidates, density or priority, followed by the index, such as density/7); Unusable if more candidates are wanted,
/// also of a class, than have a density above 0 or are kept (field `sites`), or if more are kept than wanted (field
/// `keep` or, of a class, `sites`).
/// Deterministic for a seed and any number of threads. O(n log n) for any positions.
/// Sources: the exchange of pixels in direct binary search (Analoui, Allebach 1992), simulated annealing (Kirkpatrick,
/// Gelatt, Vecchi 1983). The README of core/points compares sample elimination and farthest points.
Result<ChosenCandidates> choose_points(const Candidates& candidates, std::size_t count, std::uint64_t seed,
                                       const std::stop_token& stop = {}, Executor& executor = inline_executor());

/// Chooses candidates that are at least `spacing` apart, until no other one fits. There are more than in a random
/// maximal set, by a fifth to a third if candidates are dense.
///
/// Kept candidates are chosen first, however near they are to each other. The next one is always that with the highest
/// priority and, among equal ones, that to which the fewest remaining candidates are too near.
///
/// @param candidates  without classes; of the density, only which candidates have the density 0 matters
/// @param spacing     > 0, finite; in space, the length of the straight line
/// @param stop        after a stop, further candidates may fit
/// Errors: Malformed as for choose_points(). Deterministic. O(n log n), also if all candidates coincide.
/// Source: the greedy choice of vertices with the least degree for independent sets (Halldorsson, Radhakrishnan 1997).
Result<ChosenCandidates> choose_apart(const Candidates& candidates, double spacing, const std::stop_token& stop = {});

/// Orders chosen candidates progressively: for any k, the first k are spread as evenly as possible, with the same
/// relative density as all of them. See progressive_order().
/// @param rows  result of choose_points() for these candidates
/// @param stop  after a stop, the order must not be used
/// Deterministic for any number of threads. O(n log n).
std::vector<std::uint32_t> order_choice(const Candidates& candidates, const std::vector<std::uint32_t>& rows,
                                        const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt
