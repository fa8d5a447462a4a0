// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt::test {

/// Squared error of the density of sites, blurred by a Gaussian of so many of their mean spacings, over that of as many
/// independent ones, in dB: the mean over all places where the domain fills nine tenths of the blur.
/// @param domain  not a torus; its density uniform
/// @param sites   in the domain's coordinates
double noise(const Domain& domain, const std::vector<Point>& sites, double blur);

/// Distances of all sites to the nearest other one, over that of a hexagonal grid of as many, in order.
std::vector<double> sorted_distances(const Domain& domain, const std::vector<Point>& sites);

}  // namespace ccdt::test
