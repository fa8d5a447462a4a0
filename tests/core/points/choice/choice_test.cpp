// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/choice/choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>

#include "core/base/random.h"
#include "core/base/thread_executor.h"
#include "core/geometry/point.h"
#include "core/points/analysis/analysis.h"

namespace ccdt {
namespace {

std::vector<Point3> random_positions(std::size_t count, std::uint64_t seed, bool in_space = false) {
    Random random(seed, 0);
    std::vector<Point3> positions(count);
    for (Point3& p : positions) {
        p.x = random.uniform();
        p.y = random.uniform();
        p.z = in_space ? random.uniform() : 0;
    }
    return positions;
}

std::vector<std::uint32_t> chosen(const Candidates& candidates, std::size_t count, std::uint64_t seed = 1) {
    auto choice = choose_points(candidates, count, seed);
    EXPECT_TRUE(choice) << choice.error().message;
    return std::move(choice->rows);
}

void expect_distinct(const std::vector<std::uint32_t>& rows, std::size_t count, std::size_t candidates) {
    EXPECT_EQ(rows.size(), count);
    for (std::size_t i = 1; i < rows.size(); ++i) EXPECT_LT(rows[i - 1], rows[i]);
    EXPECT_TRUE(rows.empty() || rows.back() < candidates);
}

/// Number of chosen candidates that match a condition.
template <class Condition>
double number_of(const std::vector<std::uint32_t>& rows, Condition&& condition) {
    return static_cast<double>(std::ranges::count_if(rows, condition));
}

struct Aim {
    std::size_t ratio;  ///< candidates per point
    double min, mean, power;
};

/// Farthest points reach 0.640, 0.763 and 0.138 with 5 candidates per point; elimination reaches 0.693, 0.791 and
/// 0.105.
TEST(Choice, IsEvenWithLittlePowerInLongWaves) {
    constexpr std::size_t kPoints = 4'096;
    for (const auto& [ratio, min, mean, power] : {Aim{5, 0.64, 0.79, 0.0316}, Aim{20, 0.75, 0.845, 0.01}}) {
        const auto positions = random_positions(ratio * kPoints, ratio);
        std::vector<Point> points;
        for (const std::uint32_t row : chosen({.positions = positions, .torus = Point3{1, 1, 0}}, kPoints))
            points.push_back({positions[row].x, positions[row].y});
        const std::vector<std::vector<Point>> sets = {points};
        const Analysis analysis = *analyse(sets, *Domain::torus(1, 1), {.max_frequency = 1});
        EXPECT_GT(analysis.min_distance, min) << ratio;
        EXPECT_GT(analysis.mean_distance, mean) << ratio;
        EXPECT_LT(analysis.low_frequency_power, power) << ratio;
    }
}

/// A search that visits points in the order of the list makes points drift towards its start.
TEST(Choice, DoesNotDrift) {
    const auto positions = random_positions(20'000, 2);
    const auto rows = chosen({.positions = positions}, 1'000);
    EXPECT_NEAR(number_of(rows, [&](std::uint32_t row) { return positions[row].x < 0.5; }), 500, 10);
    EXPECT_NEAR(number_of(rows, [&](std::uint32_t row) { return positions[row].y < 0.5; }), 500, 10);
}

TEST(Choice, HasExactlyTheWantedNumber) {
    const auto positions = random_positions(1'000, 3), solid = random_positions(1'000, 4, true);
    for (const std::size_t count : {0, 1, 2, 10, 333, 998, 999, 1'000}) {
        expect_distinct(chosen({.positions = positions}, count), count, 1'000);
        expect_distinct(chosen({.positions = solid, .extent = choice::Extent::Solid}, count), count, 1'000);
    }
    expect_distinct(chosen({}, 0), 0, 0);
}

TEST(Choice, DoesNotDependOnThreads) {
    const auto positions = random_positions(20'000, 5);
    ThreadExecutor threads(3);
    const Candidates candidates{.positions = positions};
    EXPECT_EQ(choose_points(candidates, 4'000, 7)->rows, choose_points(candidates, 4'000, 7, {}, threads)->rows);
    EXPECT_NE(chosen(candidates, 4'000, 7), chosen(candidates, 4'000, 8));
}

/// Returns the mean distance to the nearest other point, relative to the hexagonal one.
double mean_distance(const std::vector<Point3>& positions, const std::vector<std::uint32_t>& rows) {
    std::vector<std::vector<Point>> sets(1);
    for (const std::uint32_t row : rows) sets[0].push_back({positions[row].x, positions[row].y});
    return analyse(sets, *Domain::torus(1, 1), {})->mean_distance;
}

/// Evenly spread points have 0.85, and random ones 0.46.
TEST(Choice, SpreadsEachClassAndAllTogether) {
    constexpr std::size_t kPoints = 2'000;
    const auto positions = random_positions(20 * kPoints, 3);
    std::vector<std::uint32_t> classes;
    for (std::size_t i = 0; i < positions.size(); ++i) classes.push_back(i % 10 < 6 ? 0 : i % 10 < 9 ? 1 : 2);
    Candidates candidates{.positions = positions};
    candidates.classes = classes;
    candidates.torus = Point3{1, 1, 0};
    const auto rows = chosen(candidates, kPoints);
    expect_distinct(rows, kPoints, positions.size());
    std::vector<std::vector<std::uint32_t>> parts(3);
    for (const std::uint32_t row : rows) parts[classes[row]].push_back(row);
    EXPECT_EQ(parts[0].size(), 1'200);
    EXPECT_EQ(parts[1].size(), 600);
    EXPECT_GT(mean_distance(positions, rows), 0.78);
    for (const auto& part : parts) EXPECT_GT(mean_distance(positions, part), 0.75) << part.size();
    ThreadExecutor threads(2);
    EXPECT_EQ(choose_points(candidates, kPoints, 1, {}, threads)->rows, rows);

    const std::vector<std::size_t> counts{5, 0, 95};
    candidates.counts = counts;
    const auto few = chosen(candidates, 100);
    EXPECT_EQ(number_of(few, [&](std::uint32_t row) { return classes[row] == 2; }), 95);
    const std::vector<std::size_t> many{0, 0, 4'001};
    candidates.counts = many;
    EXPECT_EQ(choose_points(candidates, 4'001, 1).error().field, "sites");
}

/// With 8 candidates per square of the spacing, a random maximal set has 0.58 points in it.
TEST(Choice, FitsManyCandidatesThatAreApart) {
    constexpr double kSpacing = 0.02;
    const auto positions = random_positions(20'000, 5);
    Candidates candidates{.positions = positions};
    candidates.torus = Point3{1, 1, 0};
    const auto rows = choose_apart(candidates, kSpacing)->rows;
    const auto distance = [&](std::uint32_t i, std::uint32_t j) {
        const double x = positions[i].x - positions[j].x, y = positions[i].y - positions[j].y;
        return std::hypot(x - std::round(x), y - std::round(y));
    };
    EXPECT_GT(static_cast<double>(rows.size()), 0.72 / (kSpacing * kSpacing));
    const auto is_near = [&](std::uint32_t i) {
        return std::ranges::any_of(rows, [&](std::uint32_t j) { return i != j && distance(i, j) < kSpacing; });
    };
    EXPECT_TRUE(std::ranges::none_of(rows, is_near));
    std::vector<std::uint32_t> others(positions.size());
    std::iota(others.begin(), others.end(), 0U);
    std::erase_if(others, [&](std::uint32_t i) { return std::ranges::binary_search(rows, i); });
    EXPECT_TRUE(std::ranges::all_of(others, is_near));

    std::vector<double> priority(positions.size(), 0);
    std::vector<std::uint8_t> kept(positions.size(), 0);
    priority[77] = 1;
    kept[8] = kept[9] = 1;
    candidates.priority = priority;
    candidates.kept = kept;
    const auto with = choose_apart(candidates, 0.05)->rows;
    for (const std::uint32_t row : {8U, 9U, 77U}) EXPECT_TRUE(std::ranges::binary_search(with, row)) << row;
}

TEST(Choice, FitsCoincidentAndExtremeCandidates) {
    const std::vector<Point3> same(100'000, Point3{1, 2, 3});
    EXPECT_EQ(choose_apart({.positions = same}, 1e-300)->rows.size(), 1);
    EXPECT_EQ(choose_apart({.positions = same}, 1e300)->rows.size(), 1);
    const std::vector<Point3> far{{-1.7e308, 0, 0}, {1.7e308, 0, 0}, {0, 1e-308, 0}, {0, 0, 0}};
    EXPECT_EQ(choose_apart({.positions = far}, 1e308)->rows.size(), 3);
    EXPECT_EQ(choose_apart({.positions = far}, 1.7e308)->rows.size(), 3);
    EXPECT_TRUE(choose_apart({}, 1)->rows.empty());
}

/// 18,000 candidates lie in the left tenth, and 2,000 elsewhere.
TEST(Choice, IsEvenAmongClumpedCandidates) {
    auto positions = random_positions(20'000, 6);
    for (std::size_t i = 0; i < 18'000; ++i) positions[i].x *= 0.1;
    for (std::size_t i = 18'000; i < 20'000; ++i) positions[i].x = 0.1 + 0.9 * positions[i].x;
    const auto choice = *choose_points({.positions = positions}, 400, 1);
    EXPECT_NEAR(number_of(choice.rows, [](std::uint32_t row) { return row < 18'000; }), 40, 6);
    EXPECT_EQ(choice.shortfall, 0);
}

TEST(Choice, ReportsTheShortfallWhereCandidatesLack) {
    auto positions = random_positions(10'100, 7);
    for (std::size_t i = 0; i < 10'000; ++i) positions[i].x *= 0.5;
    for (std::size_t i = 10'000; i < 10'100; ++i) positions[i].x = 0.5 + 0.5 * positions[i].x;
    std::vector<double> density(10'100, 1);
    std::fill(density.begin() + 10'000, density.end(), 9);
    const auto choice = *choose_points({.positions = positions, .density = density}, 1'000, 1);
    expect_distinct(choice.rows, 1'000, 10'100);
    EXPECT_GT(number_of(choice.rows, [](std::uint32_t row) { return row >= 10'000; }), 90);
    EXPECT_GT(choice.shortfall, 200);
    double sum = 0;
    for (const auto& [row, points] : choice.shortfalls) {
        EXPECT_GE(row, 10'000);
        sum += points;
    }
    EXPECT_EQ(static_cast<std::size_t>(sum), choice.shortfall);
    EXPECT_GE(choice.shortfalls.front().points, choice.shortfalls.back().points);
}

TEST(Choice, FollowsTheDensity) {
    const auto positions = random_positions(40'000, 8);
    std::vector<double> density;
    for (const Point3 p : positions) density.push_back(p.x < 0.5 ? 3 : 1);
    const auto rows = chosen({.positions = positions, .density = density}, 4'000);
    EXPECT_NEAR(number_of(rows, [&](std::uint32_t row) { return positions[row].x < 0.5; }), 3'000, 60);
    for (double& each : density) each = each == 3 ? 1 : 0;
    const auto half = chosen({.positions = positions, .density = density}, 4'000);
    EXPECT_EQ(number_of(half, [&](std::uint32_t row) { return positions[row].x < 0.5; }), 4'000);
}

TEST(Choice, ContainsKeptCandidates) {
    const auto positions = random_positions(5'000, 9);
    std::vector<std::uint8_t> kept(5'000);
    for (std::size_t i = 0; i < 5'000; i += 25) kept[i] = 1;
    const auto rows = chosen({.positions = positions, .kept = kept}, 500);
    expect_distinct(rows, 500, 5'000);
    EXPECT_EQ(number_of(rows, [](std::uint32_t row) { return row % 25 == 0; }), 200);
    expect_distinct(chosen({.positions = positions, .kept = kept}, 200), 200, 5'000);
    EXPECT_EQ(choose_points({.positions = positions, .kept = kept}, 199, 1).error().field, "keep");
}

TEST(Choice, PrefersHigherPriorities) {
    const auto positions = random_positions(20'000, 10);
    std::vector<double> priority;
    for (std::size_t i = 0; i < 20'000; ++i) priority.push_back(static_cast<double>(i % 100));
    const auto rows = chosen({.positions = positions, .priority = priority}, 2'000);
    double sum = 0;
    for (const std::uint32_t row : rows) sum += priority[row];
    EXPECT_GT(sum / 2'000, 60);  // the mean of all candidates is 49.5
}

/// A quadratic method would take minutes.
TEST(Choice, TakesCoincidentCandidates) {
    const std::vector<Point3> same(300'000, Point3{5, 7, 0});
    expect_distinct(chosen({.positions = same}, 100'000), 100'000, 300'000);
    auto few = random_positions(300'000, 11);
    for (std::size_t i = 0; i < few.size(); ++i) few[i] = few[i % 10];
    const auto rows = chosen({.positions = few}, 1'000);
    expect_distinct(rows, 1'000, 300'000);
    for (std::uint32_t place = 0; place < 10; ++place)
        EXPECT_GE(number_of(rows, [&](std::uint32_t row) { return row % 10 == place; }), 16) << place;
    std::vector<double> priority(same.size(), 0);
    priority[1'234] = 1;
    EXPECT_EQ(chosen({.positions = same, .priority = priority}, 1), std::vector<std::uint32_t>{1'234});
}

TEST(Choice, IsEvenAlongALine) {
    std::vector<Point3> line;
    for (int i = 0; i < 10'000; ++i) line.push_back({i * 1.0, i * 2.0, 0});
    const auto rows = chosen({.positions = line}, 100);
    expect_distinct(rows, 100, 10'000);
    for (std::size_t i = 1; i < rows.size(); ++i) EXPECT_GT(rows[i] - rows[i - 1], 30);
}

TEST(Choice, DoesNotDependOnTheUnit) {
    const auto positions = random_positions(2'000, 12);
    const auto expected = chosen({.positions = positions}, 200);
    for (const double unit : {0x1p-1000, 0x1p1000, -0x1p1000}) {
        std::vector<Point3> scaled;
        for (const Point3 p : positions) scaled.push_back(std::abs(unit) * p);
        EXPECT_EQ(chosen({.positions = scaled}, 200), expected) << unit;
    }
    const std::vector<Point3> extreme = {{-1e308, 0, 0}, {1e308, 0, 0}, {0, 1e308, 0}, {1e-308, 0, 0}, {0, 0, 0}};
    expect_distinct(chosen({.positions = extreme}, 3), 3, 5);
}

TEST(Choice, CoversASphere) {
    std::vector<Point3> sphere;
    for (const Point3 p : random_positions(60'000, 13, true)) {
        const Point3 q = p - Point3{0.5, 0.5, 0.5};
        if (length(q) < 0.5 && length(q) > 0.05) sphere.push_back((1 / length(q)) * q);
    }
    const auto rows = chosen({.positions = sphere, .extent = choice::Extent::Surface}, 1'000);
    double nearest = 2;
    for (const std::uint32_t i : rows)
        for (const std::uint32_t j : rows)
            if (i < j) nearest = std::min(nearest, length(sphere[i] - sphere[j]));
    EXPECT_GT(nearest, 0.65 * std::sqrt(4 * 3.14159 / 1'000 * 1.1547));
    EXPECT_NEAR(number_of(rows, [&](std::uint32_t row) { return sphere[row].z > 0; }), 500, 12);
}

TEST(Choice, NamesTheFaultyValue) {
    auto positions = random_positions(10, 14);
    const std::vector<double> density = {1, 1, 0, 0, 0, 0, 0, 0, 0, 0}, negative = {1, -1, 1, 1, 1, 1, 1, 1, 1, 1};
    EXPECT_EQ(choose_points({.positions = positions}, 11, 1).error().field, "sites");
    EXPECT_EQ(choose_points({.positions = positions, .density = density}, 3, 1).error().field, "sites");
    EXPECT_EQ(choose_points({.positions = positions, .density = negative}, 3, 1).error().field, "density/1");
    positions[4].y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(choose_points({.positions = positions}, 3, 1).error().field, "candidates/4");
}

TEST(Choice, IsValidAfterAStop) {
    const auto positions = random_positions(5'000, 15);
    std::stop_source source;
    source.request_stop();
    expect_distinct(choose_points({.positions = positions}, 700, 1, source.get_token())->rows, 700, 5'000);
}

}  // namespace
}  // namespace ccdt
