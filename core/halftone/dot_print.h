// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/point.h"
#include "core/halftone/reduction.h"

namespace ccdt {

/// Returns the area that two discs have in common.
double common_area(double first, double second, double distance);

/// Returns the centroid of the area that two discs have in common, approximately.
Point middle_of_overlap(Point one, double first, Point other, double second);

/// Adds an amount of light at a place, shared among the nearest cells.
void add_light(const CellGrid& cells, Point place, float amount, std::vector<float>& image);

/// Adds an amount of light at four places, which have the mean and the variance of a disc.
void add_disc(const CellGrid& cells, Point centre, double radius, float amount, std::vector<float>& image);

/// Finds pairs of dots that overlap, or nearly.
/// @param areas  [sites] in cells
std::vector<std::array<std::uint32_t, 2>> close_pairs(const CellGrid& cells, std::span<const Point> sites,
                                                      std::span<const float> areas);

inline constexpr int kSamplesOfDisc = 32, kSamplesOfRim = 8;

/// Returns directions all around.
const std::array<Point, kSamplesOfRim>& rim_samples();

/// Returns places spread evenly over the unit disc, by a spiral with the golden angle.
const std::array<Point, kSamplesOfDisc>& disc_samples();

}  // namespace ccdt
