// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/narrow_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "core/ccdt/plane/ccdt.h"

namespace ccdt {
namespace {

constexpr std::array kQualities{Quality::Draft, Quality::Standard, Quality::Best};

/// Returns a strip of a given width around a line.
PolygonPart strip(const std::vector<Point>& line, const std::function<double(double share)>& width) {
    Ring left, right;
    for (std::size_t i = 0; i < line.size(); ++i) {
        const Point along = line[std::min(i + 1, line.size() - 1)] - line[i > 0 ? i - 1 : 0];
        const double share = static_cast<double>(i) / static_cast<double>(line.size() - 1);
        const Point across = width(share) / 2 / std::sqrt(dot(along, along)) * Point{-along.y, along.x};
        left.push_back(line[i] + across);
        right.push_back(line[i] - across);
    }
    right.insert(right.end(), left.rbegin(), left.rend());
    return {right, {}};
}

/// Returns the length of a line up to the place that is nearest to a point.
double length_to(const std::vector<Point>& line, Point p) {
    double nearest = 1e300, found = 0, length = 0;
    for (std::size_t i = 1; i < line.size(); ++i) {
        const Point step = line[i] - line[i - 1];
        const double part = std::clamp(dot(p - line[i - 1], step) / dot(step, step), 0.0, 1.0);
        const Point apart = line[i - 1] + part * step - p;
        const double own = std::sqrt(dot(step, step));
        if (dot(apart, apart) < nearest) {
            nearest = dot(apart, apart);
            found = length + part * own;
        }
        length += own;
    }
    return found;
}

/// Expects that sites along a line are at equal steps of capacity.
/// @param capacity  returns the capacity up to a length along the line
void expect_even_steps(const std::vector<Point>& line, const std::vector<Point>& points,
                       const std::function<double(double length)>& capacity, const char* name) {
    std::vector<double> at;
    for (const Point p : points) at.push_back(capacity(length_to(line, p)));
    std::ranges::sort(at);
    const double mean = capacity(length_to(line, line.back())) / static_cast<double>(points.size());
    for (std::size_t i = 1; i < at.size(); ++i) {
        EXPECT_GT(at[i] - at[i - 1], 0.7 * mean) << name << ' ' << i;
        EXPECT_LT(at[i] - at[i - 1], 1.3 * mean) << name << ' ' << i;
    }
}

Distribution run(const Domain& domain, Quality quality, std::size_t sites,
                 const Density& density = Density::uniform()) {
    Options options;
    options.sites = sites;
    options.seed = sites;
    options.quality = quality;
    return distribute(domain, density, options).value();
}

std::vector<Point> river() {
    std::vector<Point> line;
    for (int i = 0; i <= 400; ++i) line.push_back({2.5 * i, 80 * std::sin(i / 24.0)});
    return line;
}

TEST(NarrowPlaces, HaveEvenSteps) {
    const std::vector<Point> straight{{0, 1}, {1000, 1}}, corner{{0, 0}, {600, 0}, {600, 500}};
    const auto same = [](double length) { return length; };
    for (const Quality quality : kQualities) {
        for (const std::size_t sites : {60u, 100u}) {
            const auto placed = [&](const Domain& domain) {
                Distribution result = run(domain, quality, sites);
                EXPECT_LT(result.variation(), 0.2) << sites;
                return std::move(result.points);
            };
            const auto points = [&](const PolygonPart& part) { return placed(Domain::create({part}).value()); };
            expect_even_steps(straight, placed(Domain::rectangle(1000, 2).value()), same, "rectangle");
            for (const double width : {0.5, 0.01})
                expect_even_steps(straight, points(strip(straight, [&](double) { return width; })), same, "thread");
            expect_even_steps(corner, points({{{0, -1}, {601, -1}, {601, 500}, {599, 500}, {599, 1}, {0, 1}}, {}}),
                              same, "corner");
            expect_even_steps(river(), points(strip(river(), [](double) { return 4; })), same, "river");
            const double length = length_to(river(), river().back());
            expect_even_steps(
                river(), points(strip(river(), [](double share) { return 6 - 5 * share; })),
                [&](double at) { return 6 * at - 2.5 * at * at / length; }, "tapering river");
        }
    }
}

TEST(NarrowPlaces, HaveEvenStepsInRings) {
    constexpr int kCorners = 300;
    std::vector<Point> line;
    PolygonPart ring{{}, {{}}};
    for (int i = 0; i <= kCorners; ++i) {
        const double angle = 2 * std::numbers::pi * i / kCorners;
        const Point way{std::cos(angle), std::sin(angle)};
        line.push_back(100 * way);
        if (i == kCorners) break;
        ring.outer.push_back(101 * way);
        ring.holes[0].push_back(99 * way);
    }
    std::ranges::reverse(ring.holes[0]);
    for (const Quality quality : kQualities)
        expect_even_steps(
            line, run(Domain::create({ring}).value(), quality, 50).points, [](double at) { return at; }, "ring");
}

TEST(NarrowPlaces, HaveEvenStepsBesideWidePlaces) {
    const PolygonPart lake_and_river{
        {{0, 0}, {100, 0}, {100, 48}, {500, 48}, {500, 52}, {100, 52}, {100, 100}, {0, 100}}, {}};
    for (const Quality quality : kQualities) {
        auto points = run(Domain::create({lake_and_river}).value(), quality, 150).points;
        std::erase_if(points, [](Point p) { return p.x < 100; });
        expect_even_steps(
            {{100, 50}, {500, 50}}, points, [](double at) { return at; }, "river");
    }
}

TEST(NarrowPlaces, HaveEvenStepsInEachPart) {
    const auto road = [](double y) { return PolygonPart{{{0, y}, {1000, y}, {1000, y + 2}, {0, y + 2}}, {}}; };
    for (const Quality quality : kQualities) {
        const auto points = run(Domain::create({road(0), road(100)}).value(), quality, 80).points;
        for (const bool first : {true, false}) {
            auto own = points;
            std::erase_if(own, [&](Point p) { return (p.y < 50) != first; });
            EXPECT_EQ(own.size(), 40u);
            expect_even_steps(
                {{0, 0}, {1000, 0}}, own, [](double at) { return at; }, "road");
        }
    }
}

TEST(NarrowPlaces, FollowTheDensity) {
    std::vector<double> values;
    for (int i = 0; i < 200; ++i) values.push_back(1 + 0.02 * i);
    const Density density = Density::grid(200, 1, std::span<const double>(values)).value();
    for (const Quality quality : kQualities) {
        const auto points = run(Domain::rectangle(1000, 2).value(), quality, 100, density).points;
        expect_even_steps(
            {{0, 1}, {1000, 1}}, points, [](double at) { return at + 0.002 * at * at; }, "density");
    }
}

TEST(NarrowPlaces, AreFoundInStripsOnly) {
    const auto narrow = [](const Domain& domain, std::size_t sites) {
        Options options;
        options.sites = sites;
        options.iterations = 0;  // initial sites are uneven
        Distribution result = distribute(domain, Density::uniform(), options).value();
        for (Point& p : result.points) p = domain.to_unit(p);
        const auto before = result.points;
        const Density density = Density::uniform();
        const CapacityIntegral capacity(domain, density);
        const auto moved =
            even_out_narrow_places(domain, capacity, result.points, capacity.total() / static_cast<double>(sites), {});
        for (std::size_t i = 0; i < sites; ++i)
            EXPECT_EQ(!moved.empty() && moved[i] != 0, result.points[i] != before[i]) << i;
        return !moved.empty();
    };
    EXPECT_FALSE(narrow(Domain::rectangle(1, 1).value(), 200));
    EXPECT_FALSE(narrow(Domain::rectangle(20, 1).value(), 200));
    EXPECT_TRUE(narrow(Domain::rectangle(1000, 2).value(), 50));
}

}  // namespace
}  // namespace ccdt
