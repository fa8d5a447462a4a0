// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "core/parallel/executor.h"
#include "core/surface/surface.h"
#include "core/surface/surface_density.h"

namespace ccdt {

/// Evens out sites where a surface is narrower than their spacing, as on roads and ribbons. Does on a surface what
/// even_out_narrow_places() (core/ccdt/narrow_places.h) does in the plane; creases count as borders. Sites whose strip
/// is too near to another part of the surface to be told from it stay where they are.
///
/// @param capacity  integral of the density that belongs to each site
/// @param spacings  [vertices] wanted distance of neighbouring sites around each vertex of the surface, > 0
/// @param sites     sites in narrow places move
/// @param stop      polled regularly; after a stop the sites must not be used
/// @returns         whether any site moved
///
/// O(n log n) for n = sites + faces.
bool even_out_narrow_strips(const Surface& surface, const SurfaceDensity& density, double capacity,
                            std::vector<double> spacings, std::span<SurfacePoint> sites, Executor& executor,
                            const std::stop_token& stop);

}  // namespace ccdt
