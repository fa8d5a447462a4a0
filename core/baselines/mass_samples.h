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

/// Points of the unit frame that stand for equal shares of the density over a domain.
///
/// Triangles are bisected across their longest edges until each holds one share at most; in that order, the sample of a
/// share lies at random in the triangle where its middle falls. So whatever the domain, a triangle on the way holds its
/// number of shares to within one.
///
/// @param mesh   of the domain: the triangles to begin with, unless the domain is a box
/// @param count  >= 1
/// @param stop   asked now and then
/// @returns      [count], neighbours in the list being neighbours mostly; some are missing if it was stopped
/// A function of domain, mesh, density and seed. O(count), 0.1 microseconds each, and a little more with a density.
std::vector<Point> mass_samples(const Domain& domain, const Triangulation& mesh, const Density& density,
                                std::size_t count, std::uint64_t seed, const std::stop_token& stop);

}  // namespace ccdt
