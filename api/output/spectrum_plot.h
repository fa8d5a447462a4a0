// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>

#include "core/analysis/analysis.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/result.h"

namespace ccdt::api {

/// Draws an analysis as SVG, in the style of Xu et al. 2011, figure 4: points, spectrum, radially averaged power and
/// anisotropy.
///
/// @param points         of the first set; if there are very many, only those in the middle of the domain are shown
/// @param domain         domain that was analysed
/// @param max_frequency  end of the frequency axes
/// Same input, same bytes. Errors: Internal if memory runs out.
Result<std::string> plot_spectrum(const Analysis& analysis, std::span<const Point> points, const Domain& domain,
                                  double max_frequency);

}  // namespace ccdt::api
