// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/dot_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/random.h"
#include "core/base/thread_executor.h"
#include "core/geometry/hexagonal_spacing.h"
#include "tests/support/shapes.h"

namespace ccdt {
namespace {

using test::box;
using test::Parts;

struct Given {
    Parts parts;
    std::vector<std::size_t> dots;
};

std::vector<MapFeature> features_of(const std::vector<Given>& given) {
    std::vector<MapFeature> features;
    for (const auto& [parts, dots] : given) features.push_back({Domain::repair(parts).value().domain, dots});
    return features;
}

Box box_of(const std::vector<MapFeature>& features) {
    Box all = features.front().area.bounds();
    for (const MapFeature& each : features) {
        all.include(each.area.bounds().min);
        all.include(each.area.bounds().max);
    }
    return all;
}

Result<std::vector<ClassDots>> distribute(const std::vector<MapFeature>& features,
                                          const Density& density = Density::uniform(), const Options& options = {},
                                          const Control& control = {}) {
    return distribute_dots(features, box_of(features), density, options, control);
}

/// Checks that each feature has its dots of a class strictly inside, and that dots are in the order of features.
void check(const std::vector<Given>& given, const ClassDots& dots, std::size_t number = 0) {
    ASSERT_EQ(dots.dots.points.size(), dots.feature_of.size());
    EXPECT_TRUE(std::ranges::is_sorted(dots.feature_of));
    std::vector<std::size_t> counts(given.size(), 0);
    for (std::size_t i = 0; i < dots.feature_of.size(); ++i) {
        const std::uint32_t feature = dots.feature_of[i];
        ++counts[feature];
        EXPECT_TRUE(test::contains(given[feature].parts, dots.dots.points[i]));
    }
    for (std::size_t i = 0; i < given.size(); ++i) EXPECT_EQ(counts[i], given[i].dots[number]);
    EXPECT_EQ(test::count_distinct(dots.dots.points), dots.dots.points.size());
}

/// Returns the distance from each dot to the nearest dot of another feature (if `across`) or of its own, relative to
/// the mean of both hexagonal distances, in ascending order. Omits distances of 1.5 and more.
std::vector<double> distances(const ClassDots& dots, const std::vector<MapFeature>& features, bool across) {
    std::vector<double> found;
    const auto spacing = [&](std::size_t i) {
        const MapFeature& feature = features[dots.feature_of[i]];
        return hexagonal_spacing(static_cast<double>(feature.dots[0]) / feature.area.area());
    };
    const auto& points = dots.dots.points;
    for (std::size_t i = 0; i < points.size(); ++i) {
        double least = 2;
        for (std::size_t j = 0; j < points.size(); ++j) {
            if (i == j || (dots.feature_of[i] == dots.feature_of[j]) == across) continue;
            const double distance = std::hypot(points[i].x - points[j].x, points[i].y - points[j].y);
            least = std::min(least, 2 * distance / (spacing(i) + spacing(j)));
        }
        if (least < 1.5) found.push_back(least);
    }
    std::ranges::sort(found);
    return found;
}

const std::vector<Given> kNeighbours = {
    {{{box(0, 0, 1, 1), {}}}, {300}}, {{{box(1, 0, 1, 1), {}}}, {900}}, {{{box(0, 1, 2, 1), {}}}, {600}}};

TEST(DistributeDots, GivesEachFeatureItsDots) {
    const auto features = features_of(kNeighbours);
    const auto classes = distribute(features);
    ASSERT_TRUE(classes) << classes.error().message;
    ASSERT_EQ(classes->size(), 1U);
    check(kNeighbours, classes->front());
}

TEST(DistributeDots, KeepsDistanceAcrossBorders) {
    const auto features = features_of(kNeighbours);
    const auto classes = distribute(features);
    ASSERT_TRUE(classes);
    const auto across = distances(classes->front(), features, true);
    const auto within = distances(classes->front(), features, false);
    ASSERT_GT(across.size(), 80U);
    EXPECT_GT(across[across.size() / 100], 0.6);
    EXPECT_GT(within[within.size() / 100], 0.75);
}

TEST(DistributeDots, LeavesNoStripAlongBorders) {
    const auto features = features_of(kNeighbours);
    const auto classes = distribute(features);
    ASSERT_TRUE(classes);
    // Counts the dots in strips of one row's height above the border at y = 1.
    const auto& points = classes->front().dots.points;
    const double row = hexagonal_spacing(600.0 / 2) * std::sqrt(0.75);
    std::vector<int> rows(6, 0);
    for (const Point& p : points) {
        const double above = (p.y - 1) / row;
        if (above >= 0 && above < 6) ++rows[static_cast<std::size_t>(above)];
    }
    const double mean = 300 * 2 * row;
    for (const int count : rows) EXPECT_NEAR(count, mean, 0.35 * mean);
}

TEST(DistributeDots, KeepsTheCountsOfOverlappingFeatures) {
    const std::vector<Given> given = {{{{box(0, 0, 2, 2), {}}}, {200}},
                                      {{{box(1, 1, 2, 2), {}}}, {300}},
                                      {{{box(1, 1, 2, 2), {}}}, {50}},
                                      {{{box(5, 5, 1, 1), {}}, {box(7, 5, 1, 1), {}}}, {40}}};
    const auto features = features_of(given);
    const auto classes = distribute(features);
    ASSERT_TRUE(classes) << classes.error().message;
    check(given, classes->front());
}

TEST(DistributeDots, HandlesStrongContrasts) {
    const std::vector<Given> given = {{{{box(0, 0, 100, 100), {box(50, 50, 1, 1)}}}, {100}},
                                      {{{box(50, 50, 1, 1), {}}}, {700}}};
    const auto features = features_of(given);
    const auto classes = distribute(features);
    ASSERT_TRUE(classes) << classes.error().message;
    check(given, classes->front());
    const auto within = distances(classes->front(), features, false);
    EXPECT_GT(within[within.size() / 100], 0.7);
}

TEST(DistributeDots, SkipsFeaturesWithoutDots) {
    const std::vector<Given> given = {
        {{{box(0, 0, 1, 1), {}}}, {1}}, {{{box(1, 0, 1, 1), {}}}, {0}}, {{{box(2, 0, 1, 1), {}}}, {2}}};
    const auto features = features_of(given);
    const auto classes = distribute(features);
    ASSERT_TRUE(classes) << classes.error().message;
    check(given, classes->front());
}

TEST(DistributeDots, FillsSliversAndIslands) {
    Given islands{{}, {60}};
    for (int i = 0; i < 20; ++i) islands.parts.push_back({box(3 * i, 0, 1, 0.5), {}});
    const std::vector<Given> given = {
        islands, {{{{{0, 2}, {60, 2}, {60, 2.0001}}, {}}}, {30}}, {{{test::star({30, 20}, 15, 0.5, 30), {}}}, {500}}};
    const auto features = features_of(given);
    const auto classes = distribute(features);
    ASSERT_TRUE(classes) << classes.error().message;
    check(given, classes->front());
}

TEST(DistributeDots, KeepsClassesApart) {
    const std::vector<Given> given = {{{{box(0, 0, 1, 1), {}}}, {200, 100, 0}},
                                      {{{box(1, 0, 1, 1), {}}}, {50, 300, 0}}};
    const auto features = features_of(given);
    const auto classes = distribute(features);
    ASSERT_TRUE(classes) << classes.error().message;
    ASSERT_EQ(classes->size(), 3U);
    for (std::size_t number = 0; number < 3; ++number) check(given, (*classes)[number], number);
    std::vector<double> found;
    for (const Point& a : (*classes)[0].dots.points) {
        double least = 1;
        for (const Point& b : (*classes)[1].dots.points) least = std::min(least, std::hypot(a.x - b.x, a.y - b.y));
        found.push_back(least / hexagonal_spacing(325));
    }
    std::ranges::sort(found);
    // The fifth percentile of independent dots would be 0.1.
    EXPECT_GT(found[found.size() / 20], 0.4);
}

/// Uses 60 random fixed points on two features, of which one is twice as dense, and 100 coincident fixed points.
TEST(DistributeDots, KeepsDistanceFromFixedPoints) {
    const std::vector<Given> given = {{{{box(0, 0, 1, 1), {}}}, {400, 30}}, {{{box(1, 0, 1, 1), {}}}, {800, 0}}};
    Options options;
    Random random(7, 0);
    for (int i = 0; i < 60; ++i) {
        const double x = 2.2 * random.uniform();
        options.fixed.push_back({x, random.uniform()});
    }
    options.fixed.insert(options.fixed.end(), 100, {0.5, 0.5});
    for (const Quality quality : {Quality::Standard, Quality::Best}) {
        options.quality = quality;
        const auto classes = distribute(features_of(given), Density::uniform(), options);
        ASSERT_TRUE(classes) << classes.error().message;
        for (std::size_t number = 0; number < 2; ++number) check(given, (*classes)[number], number);
        const auto& [placed, feature_of] = classes->front();
        std::vector<double> from_fixed(options.fixed.size(), 2);
        for (std::size_t i = 0; i < placed.points.size(); ++i) {
            for (std::size_t k = 0; k < options.fixed.size(); ++k) {
                const Point off = placed.points[i] - options.fixed[k];
                const double spacing = hexagonal_spacing(feature_of[i] == 0 ? 430 : 830);
                from_fixed[k] = std::min(from_fixed[k], std::sqrt(dot(off, off)) / spacing);
            }
        }
        std::ranges::sort(from_fixed);
        EXPECT_GT(from_fixed.front(), 0.6);
        // No hole is left around the fixed points either.
        EXPECT_LT(from_fixed[from_fixed.size() / 2], 1.1);
    }
}

TEST(DistributeDots, FollowsADensityInEachFeature) {
    const std::vector<double> values = {1, 3, 1, 3};
    const auto density = Density::grid(4, 1, std::span<const double>(values)).value();
    const std::vector<Given> given = {{{{box(0, 0, 2, 1), {}}}, {400}}, {{{box(2, 0, 2, 1), {}}}, {800}}};
    const auto classes = distribute(features_of(given), density);
    ASSERT_TRUE(classes) << classes.error().message;
    check(given, classes->front());
    std::vector<int> columns(4, 0);
    for (const Point& p : classes->front().dots.points) ++columns[static_cast<std::size_t>(p.x)];
    const int wanted[] = {100, 300, 200, 600};
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(columns[i], wanted[i], 0.06 * wanted[i] + 5);
}

TEST(DistributeDots, RefusesAFeatureWithoutDensity) {
    const std::vector<double> values = {0, 1};
    const auto density = Density::grid(2, 1, std::span<const double>(values)).value();
    const auto features = features_of({{{{box(0, 0, 1, 1), {}}}, {4}}, {{{box(1, 0, 1, 1), {}}}, {8}}});
    const auto classes = distribute(features, density);
    ASSERT_FALSE(classes);
    EXPECT_EQ(classes.error().code, ErrorCode::Unusable);
    EXPECT_EQ(classes.error().field, "features/0");
}

TEST(DistributeDots, IsDeterministic) {
    const auto features = features_of(kNeighbours);
    const auto once = distribute(features), again = distribute(features);
    EXPECT_EQ(once->front().dots.points, again->front().dots.points);
    Options other;
    other.seed = 1;
    EXPECT_NE(once->front().dots.points, distribute(features, Density::uniform(), other)->front().dots.points);
}

TEST(DistributeDots, IsIdenticalOnAnyNumberOfThreads) {
    const auto features = features_of({{{{box(0, 0, 1, 1), {}}}, {9000, 500}},
                                       {{{box(1, 0, 1, 1), {}}}, {6000, 2500}},
                                       {{{box(0, 1, 2, 1), {}}}, {12000, 0}},
                                       {{{box(0.5, 0.5, 1, 1), {}}}, {700, 5000}}});
    std::vector<double> values(32 * 32);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = 1 + static_cast<double>(i % 32) / 16;
    const auto ramp = Density::grid(32, 32, std::span<const double>(values)).value();
    const auto uniform = Density::uniform();
    for (const Density* density : {&uniform, &ramp}) {
        const auto expected = distribute(features, *density).value();
        for (const std::size_t size : {2, 16}) {
            ThreadExecutor executor(size);
            Control control;
            control.executor = &executor;
            const auto found = distribute(features, *density, {}, control).value();
            for (std::size_t i = 0; i < expected.size(); ++i) {
                EXPECT_TRUE(found[i].dots.points == expected[i].dots.points) << size << " threads";
                EXPECT_EQ(found[i].dots.trace, expected[i].dots.trace);
                EXPECT_EQ(found[i].feature_of, expected[i].feature_of);
            }
        }
    }
}

TEST(DistributeDots, ReportsProgressAndStops) {
    const auto features = features_of(kNeighbours);
    std::vector<double> done;
    std::stop_source source;
    Control control{source.get_token(), [&](const Progress& progress) { done.push_back(progress.done()); }};
    ASSERT_TRUE(distribute(features, Density::uniform(), {}, control));
    ASSERT_GT(done.size(), 6U);
    EXPECT_TRUE(std::ranges::is_sorted(done));
    control.progress = [&](const Progress& progress) {
        if (progress.iteration == 2) source.request_stop();
    };
    const auto stopped = distribute(features, Density::uniform(), {}, control);
    ASSERT_TRUE(stopped);
    EXPECT_TRUE(stopped->front().dots.stopped);
    EXPECT_EQ(stopped->front().dots.iterations, 2);
    check(kNeighbours, stopped->front());
    EXPECT_EQ(distribute(features, Density::uniform(), {}, control).error().code, ErrorCode::Stopped);
}

}  // namespace
}  // namespace ccdt
