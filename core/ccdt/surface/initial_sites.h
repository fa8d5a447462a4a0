// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/ccdt/surface/surface.h"
#include "core/ccdt/surface/surface_density.h"

namespace ccdt {

/// Draws the initial sites on a surface. Faces are visited along a space-filling curve, and every face gets its share
/// of the sites, by systematic sampling of the density. Within a face, sites follow a low-discrepancy sequence. Each
/// component gets its share of the sites, rounded up or down; the total is exact.
///
/// @param sites  number of sites
/// @returns      [sites] numbered along the space-filling curve; empty if the density is 0 everywhere
///
/// Deterministic. O(n log n) for n = faces + sites.
std::vector<SurfacePoint> initial_sites(const Surface& surface, const SurfaceDensity& density, std::size_t sites,
                                        std::uint64_t seed);

}  // namespace ccdt
