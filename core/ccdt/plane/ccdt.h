// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/plane/distribution.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Distributes sites so that all triangles of their Delaunay triangulation have nearly the same capacity. Then polishes
/// the pattern, unless the quality is Draft or the number of iterations is 0.
///
///     draw sites in cells of equal capacity, triangulate them      plane/start, plane/placement
///     for each iteration:                                          the first phase:
///         for each pass, for each site:                                relax/relaxation
///             go where the capacities of its triangles are nearest to their targets
///         flip edges until the triangulation is Delaunay               mesh/flips
///     for each round:                                              the second phase:
///         push neighbours apart that are too near                      polish/mesh_polish
///         move all sites against long waves of the density error       polish/mesh_transport
///
/// @param density  stretched over the domain's bounding box; values outside the domain are ignored; periodic on a torus
/// @param control  a stop returns the current sites, which is not an error; a stop during the start gives the error
///                 Stopped
///
/// Errors: Malformed for an option out of range; Unusable if the density is zero everywhere in the domain.
/// Deterministic for any number of threads. O(n) per pass.
/// Source: Xu, Liu, Gotsman, Gortler 2011, section 3. The polish is not part of their method.
Result<Distribution> distribute(const Domain& domain, const Density& density, const Options& options,
                                const Control& control = {});

/// Computes moves that improve the appearance of the dots of all inks together.
/// @param sites  [inks] in the domain's coordinates
/// @returns      [inks][sites] moves of at most a few hundredths of the spacing of the ink's sites
using Retouch = std::function<std::vector<std::vector<Point>>(std::span<const std::vector<Point>> sites)>;

/// Distributes the dots of several inks. Each ink follows its own density as in distribute(), and dots of different
/// inks keep apart where there is space. All inks run the same iteration at the same time, and are polished together.
/// With the quality Draft there is no polish, so the inks are independent.
///
/// @param densities  [inks] each stretched over the domain's bounding box; unused for an ink without sites
/// @param sites      [inks] >= 0, at least one > 0
/// @param options    apply to all inks, except for the number of sites; the first ink with sites uses the seed, the
///                   other inks use seeds derived from it
/// @param control    the progress counts the iterations and rounds, which all inks share, and gives the largest
///                   capacity variation of any ink; a stop returns the current sites, which is not an error; a stop
///                   during the start gives the error Stopped
/// @param retouch    called in the last rounds of the polish if several inks have sites; may be empty
/// @returns          [inks]; an ink without sites has no points and the trace {0}
///
/// Errors: as for distribute(), which is the case of one ink; Malformed if the densities have different grids.
/// Deterministic for any number of threads. O(sites) per pass.
Result<std::vector<Distribution>> distribute_inks(const Domain& domain, std::span<const Density> densities,
                                                  std::span<const std::size_t> sites, const Options& options,
                                                  const Control& control = {}, const Retouch& retouch = {});

}  // namespace ccdt
