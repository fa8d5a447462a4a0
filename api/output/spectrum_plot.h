// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>

#include "core/analysis/analysis.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/result.h"

namespace ccdt::api {

/// Draws an analysis as SVG, in the style of figure 4 of Xu et al. 2011: points, spectrum, radially averaged power and
/// anisotropy.
///
/// @param points         points of the first set; if there are very many points, only those in the middle of the domain
///                       are drawn
/// @param domain         domain that was analysed
/// @param max_frequency  last frequency on the frequency axes
/// The same input gives the same bytes. Errors: Internal if memory runs out.
Result<std::string> plot_spectrum(const Analysis& analysis, std::span<const Point> points, const Domain& domain,
                                  double max_frequency);

}  // namespace ccdt::api
