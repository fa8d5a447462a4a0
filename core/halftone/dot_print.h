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

/// Returns the area of the intersection of two discs.
/// @param first, second  radii
/// @param distance       distance between the centres
double common_area(double first, double second, double distance);

/// Returns the approximate centroid of the intersection of two discs.
/// @param first, second  radii
Point middle_of_overlap(Point one, double first, Point other, double second);

/// Adds light to an image [cells] at a position, divided among the four nearest cells as in bilinear interpolation.
void add_light(const CellGrid& cells, Point place, float amount, std::vector<float>& image);

/// Finds the pairs of dots that overlap or nearly touch.
/// @param areas  [sites] areas of the dots, in cells
std::vector<std::array<std::uint32_t, 2>> close_pairs(const CellGrid& cells, std::span<const Point> sites,
                                                      std::span<const float> areas);

inline constexpr int kSamplesOfDisc = 32, kSamplesOfRim = 8;

/// Returns unit vectors in equally spaced directions.
const std::array<Point, kSamplesOfRim>& rim_samples();

/// Returns positions that are spread evenly over the unit disc, on a spiral with the golden angle.
const std::array<Point, kSamplesOfDisc>& disc_samples();

}  // namespace ccdt
