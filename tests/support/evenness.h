// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt::test {

/// Returns the mean squared error of the blurred density of sites, in dB relative to the same number of independent
/// sites. Positions where the domain fills less than nine tenths of the blur are ignored.
/// @param domain  not a torus; its density is uniform
/// @param sites   in the domain's coordinates
/// @param blur    standard deviation of a Gaussian, in mean spacings of the sites
double noise(const Domain& domain, const std::vector<Point>& sites, double blur);

/// Returns the distance of each site to its nearest neighbour, relative to the hexagonal distance, in ascending order.
std::vector<double> sorted_distances(const Domain& domain, const std::vector<Point>& sites);

}  // namespace ccdt::test
