// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cmath>

#include "core/ccdt/globe/globe.h"
#include "core/ccdt/globe/inside.h"
#include "core/ccdt/globe/region.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/part_reader.h"
#include "tests/fuzz/shape_checks.h"

namespace ccdt::fuzz {
namespace {

using Parts = std::vector<PolygonPart>;

constexpr std::size_t kMaxVertices = 32;

/// Reads polygons with corners at crossings of certain meridians and parallels, including the poles and longitudes
/// beyond 180 degrees. Some corners are anywhere.
Parts read_parts(Bytes& input) {
    constexpr std::array<double, 21> kLongitudes = {-540, -360, -190, -180, -179, -120, -90, -30, -1,  0,  1,
                                                    10,   30,   90,   120,  170,  179,  180, 190, 360, 540};
    constexpr std::array<double, 12> kLatitudes = {-90, -89.999, -60, -30, -1, 0, 1, 30, 45, 60, 89.999, 90};
    constexpr double kFar = 1000;
    return take_parts(
        input, kMaxVertices, kFar,
        [&](unsigned byte) {
            return Point{kLongitudes[byte % kLongitudes.size()], kLatitudes[byte / kLongitudes.size()]};
        },
        [](Bytes& from) {
            const double x = from.take<std::int16_t>() / 60.0;
            return Point{x, from.take<std::int16_t>() / 360.0};
        });
}

void check_on_globe(const Domain& degrees, const GlobeDistribution& placed, std::size_t sites) {
    CCDT_CHECK(placed.sites.points.size() == sites);
    CCDT_CHECK(placed.pitch > 0 && std::isfinite(placed.pitch));
    for (const Point p : placed.sites.points) CCDT_CHECK(std::abs(p.x) <= 180 && std::abs(p.y) <= 90);
    CCDT_CHECK(placed.sites.mesh->vertices.size() >= sites);
    for (const Point p : placed.sites.mesh->vertices) CCDT_CHECK(std::isfinite(p.x) && std::isfinite(p.y));
    constexpr double kSurface = 510.1e12;
    CCDT_CHECK(placed.pitch * placed.pitch * static_cast<double>(sites) < kSurface);
    CCDT_CHECK(degrees.area() > 0);
}

void check(const Parts& parts, std::size_t sites) {
    const auto turned = unrolled(parts);
    if (!turned) return check_location(turned.error(), parts);
    const auto repaired = Domain::repair(*turned);
    if (!repaired) return;
    Options options;
    options.sites = sites;
    options.iterations = 1;
    options.passes = 2;
    options.keep_mesh = true;
    const auto run = [&] { return distribute_on_globe(repaired->domain, Density::uniform(), options, distribute); };
    const auto placed = run();
    if (!placed) return check_error(placed.error());
    check_on_globe(repaired->domain, *placed, sites);
    CCDT_CHECK(placed->sites.points == run()->sites.points);
}

}  // namespace
}  // namespace ccdt::fuzz

/// Distributes points in polygons on the globe, which may cross the antimeridian, contain a pole or wind around it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt::fuzz;
    Bytes input(text_of(data, size));
    const std::size_t sites = input.take<std::uint8_t>() % 24U + 1;
    check(read_parts(input), sites);
    return 0;
}
