// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>

#include "core/base/result.h"
#include "core/geometry/point.h"
#include "core/geometry/point3.h"
#include "core/points/analysis/analysis.h"

namespace ccdt::api {

/// Draws an analysis as SVG, in the style of figure 4 of Xu et al. 2011: points, spectrum, radially averaged power and
/// anisotropy.
///
/// @param points         points of the first set; if there are very many points, only those in the middle of the domain
///                       are drawn
/// @param sides          sides of the domain that was analysed
/// @param max_frequency  last frequency on the frequency axes
/// The same input gives the same bytes. Errors: Internal if memory runs out.
Result<std::string> plot_spectrum(const Analysis& analysis, std::span<const Point> points, Point sides,
                                  double max_frequency);

/// Draws an analysis of points in space in the same way. The points are those of four slabs in the middle, next to each
/// other and perpendicular to z.
Result<std::string> plot_spectrum(const Analysis& analysis, std::span<const Point3> points, Point3 sides,
                                  double max_frequency);

}  // namespace ccdt::api
