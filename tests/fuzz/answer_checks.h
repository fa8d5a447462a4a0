// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "api/run/options.h"
#include "core/geometry/point.h"

namespace ccdt::fuzz {

/// Checks that an estimate of the cost is finite and plausible.
void check_cost(const api::Cost& cost);

/// Returns the points of a JSON answer, ink by ink. Checks that all required numbers are present.
std::vector<Point> points_of_json(const std::string& body);

/// Returns the points of a GeoJSON answer, and checks its numbers.
std::vector<Point> points_of_feature(const std::string& body);

/// Returns the points of an answer that has one GeoJSON Feature per line.
std::vector<Point> points_of_lines(std::string_view body);

/// Returns the points of a CSV answer.
std::vector<Point> points_of_csv(std::string_view body);

/// Returns the points of a NumPy array.
/// @param columns  2; 3 with the number of an ink or a rank; 4 with radius and side
std::vector<Point> points_of_npy(std::string_view body, std::size_t columns);

/// Checks that an SVG document is complete and contains no NaN or infinity.
void check_svg(std::string_view body);

/// Checks that a file begins with the signature of its format.
void check_signature(std::string_view body, std::string_view signature);

/// Removes the elapsed time from a JSON answer.
std::string without_time(std::string body);

}  // namespace ccdt::fuzz
