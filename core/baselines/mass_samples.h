// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Returns points in the unit frame that represent equal shares of the domain's mass, the integral of the density.
///
/// Triangles are bisected across their longest edges until each contains at most one share. The shares are ordered
/// along these triangles. Each sample lies at random in the triangle that contains the middle of its share. So the
/// number of samples in any triangle of the bisection differs from the triangle's number of shares by at most one.
///
/// @param mesh   mesh of the domain: the initial triangles, unless the domain is a box
/// @param count  >= 1
/// @param stop   polled regularly
/// @returns      [count] samples, with mostly neighbouring samples in succession; some are missing after a stop
///
/// Depends on domain, mesh, density and seed alone. O(count): at least 0.1 microseconds per sample.
std::vector<Point> mass_samples(const Domain& domain, const Triangulation& mesh, const Density& density,
                                std::size_t count, std::uint64_t seed, const std::stop_token& stop);

}  // namespace ccdt
