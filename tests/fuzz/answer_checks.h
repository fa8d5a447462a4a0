// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "api/run/options.h"
#include "core/geometry/point.h"

namespace ccdt::fuzz {

/// What was estimated is a number.
void check_cost(const api::Cost& cost);

/// Points of a JSON answer, of all inks one after the other. Wherever a number is promised there is one.
std::vector<Point> points_of_json(const std::string& body);

/// Those of GeoJSON, which holds numbers as well.
std::vector<Point> points_of_feature(const std::string& body);

/// Points of GeoJSON in lines, one Feature each.
std::vector<Point> points_of_lines(std::string_view body);

/// Those of CSV.
std::vector<Point> points_of_csv(std::string_view body);

/// Those of a NumPy array.
/// @param columns  2; 3 with the number of an ink; 4 with radius and side
std::vector<Point> points_of_npy(std::string_view body, std::size_t columns);

/// SVG whose numbers are finite.
void check_svg(std::string_view body);

/// A file that begins as it should.
void check_signature(std::string_view body, std::string_view signature);

/// JSON but for the time that it tells.
std::string without_time(std::string body);

}  // namespace ccdt::fuzz
