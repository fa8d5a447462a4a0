// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/halftone/inks/coverage_curve.h"

namespace ccdt {

/// Lower limit of a dot's area, in pixels of the picture. Keeps the computed number of dots finite.
inline constexpr double kMinDotArea = 1e-12;

/// Requested properties of the dots: their number, their radius, or both.
struct DotRequest {
    std::optional<std::size_t> sites;  ///< number of dots of all inks together, >= 1
    std::optional<double> radius;      ///< radius of the dots, in pixels of the picture, > 0
    double detail = 0;                 ///< standard deviation, in radii, of the blur that sharpening compensates; >= 0
    Mark mark = Mark::Disc;            ///< the radius of a line is half its width
    bool may_show_contrast = false;    ///< whether dots may show local contrast if they are few
};

/// Size and density of dots.
struct DotPlan {
    double radius = 0;                        ///< radius of all dots, in pixels of the picture
    double tone = 1;                          ///< area that dots cover, divided by the area that they should cover
    std::vector<std::vector<float>> density;  ///< [inks][width * height] number of dots per pixel of the picture
    std::vector<double> dots;                 ///< [inks] number of dots: the sum of the density
    bool shows_contrast = false;  ///< whether dots are too few for half of the tone, and show local contrast instead
};

/// Plans dots of the same size in all inks, such that the dots of each ink cover the wanted share of each part of the
/// picture. Overlaps within an ink count once (see CoverageCurve). The density of dots at a pixel follows from the mean
/// coverage around it. Pixels without coverage get no dots.
///
/// If only the number of sites is given, the radius follows from it. If only the radius is given, the number of sites
/// follows from it. If both are given, the covered share differs from the wanted share by the same factor everywhere,
/// except where the picture is already solid. If this factor is below 1/2, lighter and darker tones would hardly
/// differ. Dots that may show local contrast then do so: darkness in CIE L*, less a part of the mean darkness around.
///
/// @param cover  [inks][width * height] wanted coverage in [0, 1], at least one value > 0
/// @param stop   polled once per ink; after a stop the result must not be used
/// Deterministic for any number of threads. O(pixels).
DotPlan plan_dots(std::vector<std::vector<float>> cover, int width, int height, const DotRequest& request,
                  const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt
