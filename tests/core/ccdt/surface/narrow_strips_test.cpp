// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/narrow_strips.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/ccdt/surface/distribute.h"

namespace ccdt {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// The centre line of a strip, of length 1 if it is straight and nearly 1 if it consists of many segments.
struct Line {
    std::string name;
    std::vector<Point3> points, across;  ///< positions, and unit vectors across the strip
    bool is_closed = false;

    std::size_t segments() const { return points.size() - (is_closed ? 0 : 1); }
    Point3 end(std::size_t segment) const { return points[(segment + 1) % points.size()]; }
    double length_of(std::size_t segment) const { return length(end(segment) - points[segment]); }
    double length_before(std::size_t segment) const {
        double sum = 0;
        for (std::size_t i = 0; i < segment; ++i) sum += length_of(i);
        return sum;
    }
    /// Returns the length up to the place on the line that is nearest to a point.
    double length_to(Point3 p) const {
        double nearest = 1e300, found = 0;
        for (std::size_t i = 0; i < segments(); ++i) {
            const Point3 step = end(i) - points[i];
            const double share = std::clamp(dot(p - points[i], step) / dot(step, step), 0.0, 1.0);
            const Point3 apart = points[i] + share * step - p;
            if (dot(apart, apart) >= nearest) continue;
            nearest = dot(apart, apart);
            found = length_before(i) + share * length_of(i);
        }
        return found;
    }
};

Line straight(std::size_t segments) {
    Line line{"straight", {}, {}, false};
    for (std::size_t i = 0; i <= segments; ++i) {
        line.points.push_back({static_cast<double>(i) / static_cast<double>(segments), 0, 0});
        line.across.push_back({0, 1, 0});
    }
    return line;
}

/// Returns a circle, or three fifths of one.
Line round(std::size_t segments, bool is_closed, bool is_flat) {
    Line line{std::string(is_closed ? "closed" : "open") + (is_flat ? " road" : " wall"), {}, {}, is_closed};
    const double angle = is_closed ? kTurn : 0.6 * kTurn;
    for (std::size_t i = 0; i < segments + (is_closed ? 0 : 1); ++i) {
        const double at = angle * static_cast<double>(i) / static_cast<double>(segments);
        const Point3 out{std::cos(at), std::sin(at), 0};
        line.points.push_back(1 / angle * out);
        line.across.push_back(is_flat ? out : Point3{0, 0, 1});
    }
    return line;
}

/// Appends a strip of two triangles per segment.
void append(TriangleSoup& soup, const Line& line, double width) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (std::size_t i = 0; i < line.points.size(); ++i) {
        soup.vertices.push_back(line.points[i] - width / 2 * line.across[i]);
        soup.vertices.push_back(line.points[i] + width / 2 * line.across[i]);
    }
    const auto all = static_cast<std::uint32_t>(2 * line.points.size());
    for (std::uint32_t i = 0; i < line.segments(); ++i) {
        const std::uint32_t a = first + 2 * i, b = first + (2 * i + 2) % all;
        soup.triangles.push_back({a, b, b + 1});
        soup.triangles.push_back({a, b + 1, a + 1});
    }
}

/// Rotates a point about an oblique axis, by an angle in radians.
Point3 rotated(Point3 p, double angle) {
    const Point3 axis{2.0 / 7, 3.0 / 7, 6.0 / 7};
    return std::cos(angle) * p + std::sin(angle) * cross(axis, p) + (1 - std::cos(angle)) * dot(axis, p) * axis;
}

/// @param variation  receives the capacity variation if not null
std::vector<Point3> distributed(const TriangleSoup& soup, const SurfaceOptions& options, double* variation = nullptr) {
    const Surface surface = Surface::create(soup, {}).value().surface;
    std::vector<Point3> positions;
    const auto dots = distribute_on_surface(surface, SurfaceDensity::uniform(), options).value();
    if (variation != nullptr) *variation = dots.variation();
    for (const SurfacePoint& point : dots.points) positions.push_back(surface.to_input(surface.position(point)));
    return positions;
}

/// Returns the distances of successive sites along a line, in units of their mean.
std::vector<double> gaps(const Line& line, const std::vector<Point3>& positions) {
    const double whole = line.length_before(line.segments()), mean = whole / static_cast<double>(positions.size());
    std::vector<double> at, found;
    for (const Point3& position : positions) at.push_back(line.length_to(position));
    std::ranges::sort(at);
    for (std::size_t i = 1; i < at.size(); ++i) found.push_back((at[i] - at[i - 1]) / mean);
    if (line.is_closed) found.push_back((at.front() + whole - at.back()) / mean);
    return found;
}

TEST(NarrowStrips, HaveEvenGaps) {
    constexpr std::size_t kSites = 40;
    std::vector<Line> lines;
    for (const std::size_t segments : {1u, 10u, 100u}) {
        lines.push_back(straight(segments));
        for (const bool is_closed : {false, true}) {
            for (const bool is_flat : {false, true})
                lines.push_back(round(std::max<std::size_t>(segments, 4), is_closed, is_flat));
        }
    }
    for (const Line& line : lines) {
        for (const double spacings : {0.001, 0.2, 0.6}) {
            for (std::uint64_t seed = 0; seed < 3; ++seed) {
                TriangleSoup soup;
                append(soup, line, spacings * spacings / kSites);
                for (Point3& vertex : soup.vertices) vertex = rotated(vertex, static_cast<double>(seed));
                const Quality quality = std::array{Quality::Standard, Quality::Draft, Quality::Best}[seed];
                double variation = 0;
                auto positions = distributed(soup, {.sites = kSites, .seed = seed, .quality = quality}, &variation);
                for (Point3& position : positions) position = rotated(position, -static_cast<double>(seed));
                const auto found = gaps(line, positions);
                const std::string name = line.name + ' ' + std::to_string(line.segments()) + ", " +
                                         std::to_string(spacings) + " spacings, " + std::to_string(seed);
                EXPECT_GT(std::ranges::min(found), 0.99) << name;
                EXPECT_LT(std::ranges::max(found), 1.01) << name;
                EXPECT_LT(variation, 0.2) << name;
            }
        }
    }
}

TEST(NarrowStrips, HaveEvenGapsOnOneLongFace) {
    constexpr std::size_t kSites = 2000;
    for (const double spacings : {0.01, 0.6}) {
        const Line line = straight(1);
        TriangleSoup soup;
        append(soup, line, spacings * spacings / kSites);
        double variation = 0;
        const auto found = gaps(line, distributed(soup, {.sites = kSites}, &variation));
        EXPECT_GT(std::ranges::min(found), 0.99) << spacings;
        EXPECT_LT(std::ranges::max(found), 1.01) << spacings;
        EXPECT_LT(variation, 0.2) << spacings;
    }
}

TEST(NarrowStrips, KeepTheSharesOfComponents) {
    constexpr std::size_t kStrips = 10, kSites = 3;
    TriangleSoup soup;
    const Line line = straight(1);
    for (std::size_t i = 0; i < kStrips; ++i) {
        Line other = line;
        for (Point3& point : other.points) point.z += 0.01 * static_cast<double>(i);
        append(soup, other, 1e-3);
    }
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
        std::array<std::vector<Point3>, kStrips> positions;
        for (const Point3& position : distributed(soup, {.sites = kStrips * kSites, .seed = seed}))
            positions[static_cast<std::size_t>(std::lround(100 * position.z))].push_back(position);
        for (const auto& own : positions) {
            EXPECT_EQ(own.size(), kSites) << seed;
            EXPECT_GT(std::ranges::min(gaps(line, own)), 0.8) << seed;
            EXPECT_LT(std::ranges::max(gaps(line, own)), 1.2) << seed;
        }
    }
}

TEST(NarrowStrips, AreEvenBesideWidePlaces) {
    // A square of side 1 with a road from the middle of its right side.
    constexpr std::size_t kSites = 500;
    constexpr double kRoad = 0.02, kAll = 1 + 3 * kRoad, kMean = kAll / kSites / kRoad;
    TriangleSoup soup;
    soup.vertices = {{0, 0, 0},    {1, 0, 0},    {1, 0.49, 0}, {4, 0.49, 0},
                     {4, 0.51, 0}, {1, 0.51, 0}, {1, 1, 0},    {0, 1, 0}};
    soup.triangles = {{0, 1, 2}, {0, 2, 5}, {0, 5, 7}, {5, 6, 7}, {2, 3, 4}, {2, 4, 5}};
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
        std::vector<double> at;
        for (const Point3& position : distributed(soup, {.sites = kSites, .seed = seed})) {
            if (position.x > 1) at.push_back(position.x);
        }
        std::ranges::sort(at);
        EXPECT_NEAR(static_cast<double>(at.size()), 3 * kRoad / kAll * kSites, 3) << seed;
        for (std::size_t i = 1; i < at.size(); ++i) {
            EXPECT_GT((at[i] - at[i - 1]) / kMean, 0.8) << seed;
            EXPECT_LT((at[i] - at[i - 1]) / kMean, 1.2) << seed;
        }
    }
}

}  // namespace
}  // namespace ccdt
