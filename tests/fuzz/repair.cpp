// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <limits>

#include "tests/fuzz/checks.h"
#include "tests/fuzz/part_reader.h"
#include "tests/fuzz/shape_checks.h"
#include "tests/support/shapes.h"

namespace ccdt::fuzz {
namespace {

using Parts = std::vector<PolygonPart>;

constexpr std::size_t kMaxVertices = 48;  ///< limits the number of crossings, which grows quadratically

/// Reads polygons with vertices on a grid of 16 x 16 points, where edges touch and overlap in many ways. Some vertices
/// are off the grid by a rounding error, and some are anywhere.
Parts read_parts(Bytes& input) {
    const double spacing = input.take<std::uint8_t>() % 2U == 0 ? 1 : 0.1;  // multiples of 0.1 are rounded
    constexpr double kFar = 100;
    return take_parts(
        input, kMaxVertices, kFar,
        [=](unsigned byte) {
            return Point{spacing * (byte % 16U), spacing * (byte / 16U)};
        },
        [](Bytes& from) {
            const double x = from.take<std::int16_t>() / 1024.0;
            return Point{x, from.take<std::int16_t>() / 1024.0};
        });
}

void check_repair(const Parts& parts) {
    const auto repaired = Domain::repair(parts);
    const auto valid = Domain::create(parts);
    CCDT_CHECK(valid.has_value() == (repaired && repaired->repairs.empty()));
    if (!repaired) return check_location(repaired.error(), parts);
    for (const Repair& repair : repaired->repairs) check_location(repair, parts);
    check_domain(repaired->domain);
    check_cover(repaired->domain, parts);

    if (valid) CCDT_CHECK(valid->rings() == repaired->domain.rings());
    Options options;
    options.sites = 12;
    options.iterations = 1;
    options.passes = 2;
    check_distribution(repaired->domain, {}, Density::uniform(), options);
}

}  // namespace
}  // namespace ccdt::fuzz

/// Repairs rings that cross, touch and overlap, and distributes points in the result.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt::fuzz;
    Bytes input(text_of(data, size));
    check_repair(read_parts(input));
    return 0;
}
