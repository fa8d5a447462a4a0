// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <string>
#include <vector>

#include "api/analyze/point_file_reader.h"
#include "api/text/numbers.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

constexpr api::Limits kLimits = {.max_sites = 64, .max_pixels = 1};

std::string csv_of(const std::vector<Point>& points) {
    std::string text = "x,y\r\n";
    for (const Point& point : points) {
        api::append_shortest(text, point.x);
        text += ',';
        api::append_shortest(text, point.y);
        text += "\r\n";
    }
    return text;
}

}  // namespace
}  // namespace ccdt::fuzz

/// Reads a file of points, which must be finite. Written as CSV, they are read again as the same points.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const auto points = api::read_point_file(fuzz::text_of(data, size), fuzz::kLimits);
    if (!points) {
        fuzz::check_error(points.error());
        CCDT_CHECK(points.error().field.empty());
        return 0;
    }
    CCDT_CHECK(points->size() <= fuzz::kLimits.max_sites);
    for (const Point& point : *points) CCDT_CHECK(std::isfinite(point.x) && std::isfinite(point.y));
    CCDT_CHECK(api::read_point_file(fuzz::csv_of(*points), fuzz::kLimits) == *points);
    return 0;
}
