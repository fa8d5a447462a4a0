// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/parallel/executor.h"

namespace ccdt {

/// Area, in pixels of the picture, below which dots are counted as if they had it, however small their radius: so the
/// numbers of dots that fill a picture are finite.
inline constexpr double kLeastDotArea = 1e-12;

/// What is settled of the dots: number or radius at least.
struct DotWish {
    std::optional<std::size_t> sites;  ///< of all inks together, >= 1
    std::optional<double> radius;      ///< pixels of the picture, > 0
    double detail = 0;                 ///< >= 0: how far dots blur the picture, in their radii, which is undone before
};

/// How many dots there are to be, where, and how large.
struct DotPlan {
    double radius = 0;                        ///< pixels of the picture
    double tone = 1;                          ///< what they cover in all, over what they should
    std::vector<std::vector<float>> density;  ///< [inks][width * height] dots wanted, per pixel of the picture
    std::vector<double> dots;                 ///< [inks] the sum of these
};

/// Plans dots, those of all inks of one size, that cover in each place what they are to cover there, overlaps within an
/// ink counted once: by what dots cover at the density that is theirs around there. Where nothing is to be covered
/// there are none. What is settled beforehand makes the rest:
/// - the number of sites the radius;
/// - the radius the number of sites, which is that of `dots`;
/// - both one factor by which all that is covered differs, as long as places are not solid already.
///
/// @param cover  [inks][width * height] in [0, 1], one > 0
/// @param stop   asked now and then; a stop ends it early, with nothing of use
/// Same input, same bytes, whatever the executor. O(pixels).
DotPlan plan_dots(std::vector<std::vector<float>> cover, int width, int height, const DotWish& wish,
                  const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt
