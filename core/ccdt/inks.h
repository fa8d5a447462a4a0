#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/ccdt/ccdt.h"

namespace ccdt {

/// Distributes the dots of several inks, each as distribute() does by a density of its own, and dots of different inks
/// apart from each other where there is room: all iterate in step, and are polished together. A draft has no polish,
/// and inks that know nothing of each other.
///
/// @param densities  [inks] each stretched over the domain's bounding box; that of an ink without sites is not used
/// @param sites      [inks] >= 0, one of them at least > 0
/// @param options    but for the number of sites; the first ink that has sites takes the seed, others seeds made of it
/// @param control    progress counts iterations and rounds of all inks as one, with the largest variation; a stop
///                   returns the sites as they stand, is no error; stopped during the start: Error Stopped
/// @returns          [inks]; an ink without sites has no points, and a trace of one 0
/// Errors: as distribute(); Malformed if the densities have different grids. One ink that has sites gets what
/// distribute() gives it, to the byte. Same input, same bytes, on any number of threads (it uses one). O(sites) per
/// pass.
Result<std::vector<Distribution>> distribute_inks(const Domain& domain, std::span<const Density> densities,
                                                  std::span<const std::size_t> sites, const Options& options,
                                                  const Control& control = {});

}  // namespace ccdt
