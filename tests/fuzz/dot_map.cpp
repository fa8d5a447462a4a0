// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cmath>
#include <vector>

#include "core/ccdt/maps/dot_map.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/part_reader.h"
#include "tests/support/shapes.h"

namespace ccdt::fuzz {
namespace {

constexpr std::size_t kMaxVertices = 40;
constexpr std::size_t kMaxDots = 40;  ///< limit for one class in one feature

struct Map {
    std::vector<std::vector<PolygonPart>> parts;  ///< [features]; empty if the polygon was repaired
    std::vector<MapFeature> features;
};

/// Reads polygons, one for each feature, on a grid of 16 x 16 points, so that they touch, overlap and share borders.
std::vector<PolygonPart> read_polygons(Bytes& input) {
    constexpr std::array<double, 6> kSpacings = {1, 0.1, 1e-100, 1e-9, 1e9, 1e100};
    const double spacing = kSpacings[input.take<std::uint8_t>() % kSpacings.size()];
    const double far = 1000 * spacing;
    return take_parts(
        input, kMaxVertices, far,
        [=](unsigned byte) {
            return Point{spacing * (byte % 16U), spacing * (byte / 16U)};
        },
        [=](Bytes& from) {
            const double x = from.take<std::int16_t>() / 1024.0;
            return Point{spacing * x, spacing * (from.take<std::int16_t>() / 1024.0)};
        });
}

Map read_map(Bytes& input) {
    const std::size_t classes = input.take<std::uint8_t>() % 3U + 1;
    std::array<std::size_t, 8> dots{};
    for (std::size_t& each : dots) each = input.take<std::uint8_t>() % (kMaxDots + 1);
    Map map;
    std::size_t number = 0;
    for (const PolygonPart& polygon : read_polygons(input)) {
        auto repaired = Domain::repair({polygon});
        if (!repaired) continue;
        map.parts.push_back(repaired->repairs.empty() ? std::vector{polygon} : std::vector<PolygonPart>());
        map.features.push_back({std::move(repaired->domain), {}});
        for (std::size_t i = 0; i < classes; ++i) map.features.back().dots.push_back(dots[number++ % dots.size()]);
    }
    return map;
}

void check_class(const Map& map, const ClassDots& dots, std::size_t number) {
    CCDT_CHECK(dots.dots.points.size() == dots.feature_of.size());
    std::vector<std::size_t> counts(map.features.size(), 0);
    for (std::size_t i = 0; i < dots.feature_of.size(); ++i) {
        const std::uint32_t feature = dots.feature_of[i];
        CCDT_CHECK(i == 0 || dots.feature_of[i - 1] <= feature);
        ++counts[feature];
        const Point p = dots.dots.points[i];
        CCDT_CHECK(std::isfinite(p.x) && std::isfinite(p.y));
        CCDT_CHECK(map.parts[feature].empty() || test::contains(map.parts[feature], p));
    }
    for (std::size_t i = 0; i < counts.size(); ++i) CCDT_CHECK(counts[i] == map.features[i].dots[number]);
    CCDT_CHECK(std::isfinite(dots.dots.variation()));
}

void check(const Map& map) {
    std::size_t all = 0;
    Box box;
    for (const MapFeature& feature : map.features) {
        for (const std::size_t dots : feature.dots) all += dots;
        if (&feature == &map.features.front()) box = feature.area.bounds();
        box.include(feature.area.bounds().min);
        box.include(feature.area.bounds().max);
    }
    if (all == 0) return;
    Options options;
    options.iterations = 2;
    options.passes = 2;
    const auto run = [&] { return distribute_dots(map.features, box, Density::uniform(), options); };
    const auto classes = run();
    if (!classes) return check_error(classes.error());
    const auto again = run();
    for (std::size_t i = 0; i < classes->size(); ++i) {
        check_class(map, (*classes)[i], i);
        CCDT_CHECK((*classes)[i].dots.points == (*again)[i].dots.points);
    }
}

}  // namespace
}  // namespace ccdt::fuzz

/// Computes dot maps with several classes for polygons that overlap, touch and share borders.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt::fuzz;
    Bytes input(text_of(data, size));
    check(read_map(input));
    return 0;
}
