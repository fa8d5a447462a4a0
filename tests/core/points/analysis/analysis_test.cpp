// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/analysis/analysis.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "core/ccdt/maps/feature_area.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt {
namespace {

using Set = std::vector<Point>;
using Sets = std::vector<Set>;

Domain torus(double width = 1, double height = 1) {
    return Domain::torus(width, height).value();
}

Domain window(double width = 1, double height = 1) {
    return Domain::rectangle(width, height).value();
}

Sets white_noise(std::size_t sets, std::size_t points, Point sides = {1, 1}) {
    Sets result(sets, Set(points));
    for (std::size_t s = 0; s < sets; ++s) {
        Random random(42, s);
        for (Point& p : result[s]) p = {sides.x * random.uniform(), sides.y * random.uniform()};
    }
    return result;
}

/// Returns columns x rows points, one at the centre of each cell.
Set lattice(int columns, int rows, Point sides) {
    Set points;
    for (int r = 0; r < rows; ++r) {
        for (int c = 0; c < columns; ++c) points.push_back({(c + 0.5) / columns * sides.x, (r + 0.5) / rows * sides.y});
    }
    return points;
}

Analysis measured(const Sets& sets, const Domain& domain, const AnalysisOptions& options = {}) {
    auto analysis = analyse(sets, domain, options);
    EXPECT_TRUE(analysis) << analysis.error().message;
    return std::move(analysis).value_or(Analysis());
}

/// Means over all rings of frequencies but the innermost ten, which have too few frequencies for a reliable variance.
struct Means {
    double power = 0;
    double anisotropy = 0;
};

Means means_of(const Analysis& analysis) {
    constexpr std::size_t kFirst = 10;
    Means means;
    const auto count = static_cast<double>(analysis.frequency.size() - kFirst);
    for (std::size_t r = kFirst; r < analysis.frequency.size(); ++r) {
        means.power += analysis.power[r] / count;
        means.anisotropy += analysis.anisotropy_db[r] / count;
    }
    return means;
}

TEST(Analysis, MeasuresWhiteNoiseAsOneAndIsotropic) {
    // The mean over about 64,000 frequencies has a standard deviation of 0.4 % / sqrt(number of sets).
    for (const std::size_t count : {1, 10}) {
        for (const Point sides : {Point{1, 1}, Point{300, 100}}) {
            const auto analysis = measured(white_noise(count, 2500, sides), torus(sides.x, sides.y));
            const auto sets = static_cast<double>(count);
            EXPECT_EQ(analysis.sets, count);
            EXPECT_EQ(analysis.points, 2500u);
            EXPECT_EQ(analysis.frequency.size(), 200u);
            const Means means = means_of(analysis);
            EXPECT_NEAR(means.power, 1, 0.02 / std::sqrt(sets));
            EXPECT_NEAR(means.anisotropy, -10 * std::log10(sets), 0.15);
            EXPECT_NEAR(*analysis.low_frequency_power, 1, 0.1);
            // The mean nearest distance of n random points is half of 1 / sqrt(n) at unit area.
            EXPECT_NEAR(analysis.mean_distance, 0.5 / std::sqrt(2 / std::sqrt(3.0)), 0.015);
        }
    }
}

TEST(Analysis, MeasuresWhiteNoiseAsOneInAWindow) {
    for (const Point sides : {Point{1, 1}, Point{300, 100}}) {
        const auto analysis = measured(white_noise(10, 2500, sides), window(sides.x, sides.y));
        EXPECT_NEAR(means_of(analysis).power, 1, 0.02);
        EXPECT_NEAR(*analysis.low_frequency_power, 1, 0.15);
    }
}

TEST(Analysis, FindsTheReciprocalPointsOfALattice) {
    constexpr int kColumns = 12, kRows = 10;
    const auto analysis = measured({lattice(kColumns, kRows, {6, 4})}, torus(6, 4));
    const Spectrum& spectrum = analysis.spectrum;
    int peaks = 0;
    for (int j = -spectrum.height / 2; j <= spectrum.height / 2; ++j) {
        for (int i = -spectrum.width / 2; i <= spectrum.width / 2; ++i) {
            const bool peak = i % kColumns == 0 && j % kRows == 0 && (i != 0 || j != 0);
            EXPECT_NEAR(spectrum.at(i, j), peak ? kColumns * kRows : 0, 1e-8) << i << ", " << j;
            peaks += peak;
        }
    }
    EXPECT_GT(peaks, 40);
    EXPECT_NEAR(*analysis.low_frequency_power, 0, 1e-12);
    // The rows are closer together than the columns.
    const double densest = std::sqrt(2 / std::sqrt(3.0) * 24 / (kColumns * kRows));
    EXPECT_NEAR(analysis.min_distance, 0.4 / densest, 1e-12);
    EXPECT_NEAR(analysis.mean_distance, 0.4 / densest, 1e-12);
}

TEST(Analysis, PutsThePrincipalFrequencyOfASquareLatticeAtOne) {
    const auto analysis = measured({lattice(20, 20, {3, 3})}, torus(3, 3));
    const auto highest = std::ranges::max_element(analysis.power) - analysis.power.begin();
    EXPECT_DOUBLE_EQ(analysis.frequency[static_cast<std::size_t>(highest)], 1);
}

TEST(Analysis, RemovesTheMeanFromAWindow) {
    // A lattice has power only at its reciprocal points, which the window widens by about two frequencies.
    const auto analysis = measured({lattice(30, 30, {2, 2})}, window(2, 2));
    EXPECT_LT(*analysis.low_frequency_power, 1e-6);
    for (std::size_t r = 0; r < analysis.frequency.size(); ++r) {
        if (analysis.frequency[r] < 0.9) {
            EXPECT_LT(analysis.power[r], 1e-6) << analysis.frequency[r];
        }
    }
    EXPECT_GT(*std::ranges::max_element(analysis.power), 10);
}

TEST(Analysis, IsInvariantUnderScaling) {
    const auto small = measured(white_noise(2, 300, {2, 1}), torus(2, 1));
    const auto large = measured(white_noise(2, 300, {2048, 1024}), torus(2048, 1024));
    EXPECT_EQ(small.power, large.power);
    EXPECT_EQ(small.anisotropy_db, large.anisotropy_db);
    EXPECT_EQ(small.min_distance, large.min_distance);
}

TEST(Analysis, IsInvariantUnderShiftsOnATorus) {
    const Sets sets = white_noise(1, 400);
    Sets shifted = sets;
    for (Point& p : shifted[0]) p = {std::fmod(p.x + 0.3, 1), std::fmod(p.y + 0.7, 1)};
    const auto before = measured(sets, torus()), after = measured(shifted, torus());
    for (std::size_t r = 0; r < before.power.size(); ++r) EXPECT_NEAR(after.power[r], before.power[r], 1e-8);
    EXPECT_NEAR(after.min_distance, before.min_distance, 1e-12);
    EXPECT_NEAR(after.mean_distance, before.mean_distance, 1e-12);
}

TEST(Analysis, RotatesWithThePoints) {
    const Sets sets = white_noise(1, 200, {3, 1});
    Sets turned = sets;
    for (Point& p : turned[0]) p = {p.y, p.x};
    for (const bool periodic : {false, true}) {
        const auto flat = measured(sets, periodic ? torus(3, 1) : window(3, 1));
        const auto tall = measured(turned, periodic ? torus(1, 3) : window(1, 3));
        ASSERT_EQ(flat.spectrum.width, tall.spectrum.height);
        for (int j = -flat.spectrum.height / 2; j <= flat.spectrum.height / 2; ++j) {
            for (int i = -flat.spectrum.width / 2; i <= flat.spectrum.width / 2; ++i) {
                ASSERT_NEAR(flat.spectrum.at(i, j), tall.spectrum.at(j, i), 1e-8);
            }
        }
        ASSERT_EQ(flat.frequency.size(), tall.frequency.size());
        for (std::size_t r = 0; r < flat.power.size(); ++r) EXPECT_NEAR(flat.power[r], tall.power[r], 1e-8);
    }
}

TEST(Analysis, AveragesPowersAndDistances) {
    const Sets sets = white_noise(2, 100);
    const auto both = measured(sets, torus());
    const auto first = measured({sets[0]}, torus()), second = measured({sets[1]}, torus());
    EXPECT_DOUBLE_EQ(both.min_distance, (first.min_distance + second.min_distance) / 2);
    EXPECT_DOUBLE_EQ(both.mean_distance, (first.mean_distance + second.mean_distance) / 2);
    for (std::size_t r = 0; r < both.power.size(); ++r) {
        EXPECT_NEAR(both.power[r], (first.power[r] + second.power[r]) / 2, 1e-12);
    }
}

TEST(Analysis, ReachesTheRequestedFrequency) {
    for (const double most : {1.0, 2.5, 6.0}) {
        const auto analysis = measured(white_noise(1, 400), torus(), {most});
        EXPECT_DOUBLE_EQ(analysis.frequency.front(), 1 / 20.0);
        EXPECT_DOUBLE_EQ(analysis.frequency.back(), most);
        EXPECT_EQ(analysis.spectrum.width, 40 * most + 1);
        EXPECT_EQ(analysis.spectrum.values.size(), static_cast<std::size_t>((40 * most + 1) * (40 * most + 1)));
    }
}

TEST(Analysis, AcceptsTwoPoints) {
    const auto analysis = measured({{{0.25, 0.5}, {0.75, 0.5}}}, torus());
    EXPECT_FALSE(analysis.low_frequency_power);
    EXPECT_DOUBLE_EQ(analysis.min_distance, 0.5 / std::sqrt(1 / std::sqrt(3.0)));
    EXPECT_NEAR(analysis.spectrum.at(1, 0), 0, 1e-9);
    EXPECT_NEAR(analysis.spectrum.at(2, 0), 2, 1e-9);
    EXPECT_EQ(analysis.spectrum.at(0, 0), 0);
}

TEST(Analysis, AcceptsDomainsOfExtremeShapeAndSize) {
    for (const Point sides : {Point{1000, 1}, Point{1e-100, 1e-100}, Point{1e100, 2e100}}) {
        const auto analysis = measured(white_noise(1, 200, sides), torus(sides.x, sides.y));
        EXPECT_DOUBLE_EQ(analysis.unit, std::sqrt(200 / sides.x / sides.y));
        for (const double power : analysis.power) EXPECT_TRUE(std::isfinite(power));
        EXPECT_GT(analysis.mean_distance, 0);
        EXPECT_LT(analysis.mean_distance, 1.1);
    }
}

nlohmann::json read_data(const std::string& name) {
    std::ifstream file(CCDT_TEST_DATA "/analysis/" + name + ".json");
    return nlohmann::json::parse(file);
}

/// Returns the relative difference of a number from its expected value.
double relative_error(double found, double expected) {
    return std::abs(found / expected - 1);
}

TEST(Analysis, AgreesWithAnIndependentProgram) {
    constexpr double kTolerance = 1e-7;  // the numbers are written with 9 digits
    for (const std::string kind : {"torus", "rectangle"}) {
        const auto request = read_data(kind);
        Sets sets;
        for (const auto& set : request.at("sets")) {
            sets.emplace_back();
            for (const auto& point : set) sets.back().push_back({point[0], point[1]});
        }
        const auto expected = read_data(kind + "-expected");
        const auto analysis = measured(sets, kind == "torus" ? torus() : window());
        ASSERT_EQ(analysis.frequency.size(), expected.at("frequency").size()) << kind;
        ASSERT_GT(analysis.frequency.size(), 80u);
        for (std::size_t r = 0; r < analysis.frequency.size(); ++r) {
            EXPECT_LT(relative_error(analysis.frequency[r], expected["frequency"][r]), kTolerance) << kind << ' ' << r;
            EXPECT_LT(relative_error(analysis.power[r], expected["power"][r]), kTolerance) << kind << ' ' << r;
            EXPECT_NEAR(analysis.anisotropy_db[r], expected["anisotropy_db"][r], 1e-6) << kind << ' ' << r;
        }
        EXPECT_LT(relative_error(*analysis.low_frequency_power, expected["low_frequency_power"]), kTolerance) << kind;
        EXPECT_LT(relative_error(analysis.min_distance, expected["min_distance"]), kTolerance) << kind;
        EXPECT_LT(relative_error(analysis.mean_distance, expected["mean_distance"]), kTolerance) << kind;
    }
}

void expect_refused(const Sets& sets, const Domain& domain, ErrorCode code, const std::string& field,
                    const AnalysisOptions& options = {}) {
    const auto analysis = analyse(sets, domain, options);
    ASSERT_FALSE(analysis);
    EXPECT_EQ(analysis.error().code, code) << analysis.error().message;
    EXPECT_EQ(analysis.error().field, field) << analysis.error().message;
    EXPECT_FALSE(analysis.error().message.empty());
}

TEST(Analysis, RefusesInvalidSets) {
    const Sets good = white_noise(3, 10);
    Sets bad = good;
    bad[2].pop_back();
    expect_refused(bad, torus(), ErrorCode::Unusable, "/2");
    for (const Point outside : {Point{1.5, 0.5}, Point{0.5, -0.1}, Point{std::nan(""), 0}}) {
        bad = good;
        bad[1][7] = outside;
        expect_refused(bad, torus(), ErrorCode::Unusable, "/1/7");
        expect_refused(bad, window(), ErrorCode::Unusable, "/1/7");
    }
    expect_refused({}, torus(), ErrorCode::Unusable, "");
    expect_refused({{}}, torus(), ErrorCode::Unusable, "/0");
    expect_refused({{{0.5, 0.5}}}, torus(), ErrorCode::Unusable, "/0");
    expect_refused({{{0.01, 0.5}, {0.5, 0.99}}}, window(), ErrorCode::Unusable, "/0");
    expect_refused({{{0.5, 0.5}, {0.01, 0.99}}}, window(), ErrorCode::Unusable, "", {1});
    for (const double most : {0.0, 0.99, 16.1, std::nan("")}) {
        expect_refused(good, torus(), ErrorCode::Malformed, "max_frequency", {most});
    }
}

TEST(Analysis, ComputesLargeSpectraInParts) {
    const Sets sets = white_noise(1, 140'000);
    for (const Domain& domain : {torus(), window()}) {
        const auto whole = measured(sets, domain, {3.8}).spectrum, parts = measured(sets, domain, {4}).spectrum;
        ASSERT_GT(parts.width, whole.width);
        for (int j = -whole.height / 2; j <= whole.height / 2; ++j) {
            for (int i = -whole.width / 2; i <= whole.width / 2; ++i)
                ASSERT_NEAR(std::sqrt(parts.at(i, j)), std::sqrt(whole.at(i, j)), 1e-9) << i << ' ' << j;
        }
        EXPECT_EQ(std::ranges::count(parts.values, 0.0), 1) << "only (0, 0) is left out";
    }
}

TEST(Analysis, RefusesATransformThatIsTooLarge) {
    const Sets sets = white_noise(1, 140'000);
    expect_refused(sets, torus(), ErrorCode::LimitExceeded, "max_frequency", {16});
}

TEST(Analysis, StopsOnRequest) {
    std::stop_source stop;
    stop.request_stop();
    const auto analysis = analyse(white_noise(2, 1000), torus(), {}, stop.get_token());
    ASSERT_FALSE(analysis);
    EXPECT_EQ(analysis.error().code, ErrorCode::Stopped);
}

TEST(Analysis, IsDeterministic) {
    const Sets sets = white_noise(2, 500);
    const auto first = measured(sets, torus()), second = measured(sets, torus());
    EXPECT_EQ(first.power, second.power);
    EXPECT_EQ(first.spectrum.values, second.spectrum.values);
    EXPECT_EQ(first.mean_distance, second.mean_distance);
}

using SpaceSets = std::vector<std::vector<Point3>>;

SpaceSets white_noise(std::size_t sets, std::size_t points, Point3 sides) {
    SpaceSets result(sets, std::vector<Point3>(points));
    for (std::size_t s = 0; s < sets; ++s) {
        Random random(42, s);
        for (Point3& p : result[s])
            p = {sides.x * random.uniform(), sides.y * random.uniform(), sides.z * random.uniform()};
    }
    return result;
}

/// Polygons of different shapes within the unit square: a disc, an L, a star, a square with a hole, and two strips.
std::vector<std::vector<PolygonPart>> shapes() {
    Ring disc, star;
    for (int i = 0; i < 60; ++i) {
        const double angle = i * std::numbers::pi / 30, radius = i % 12 < 6 ? 0.48 : 0.25;
        disc.push_back({0.5 + 0.45 * std::cos(angle), 0.5 + 0.45 * std::sin(angle)});
        if (i % 6 == 3) star.push_back({0.5 + radius * std::cos(angle), 0.5 + radius * std::sin(angle)});
    }
    const Ring corner = {{0.05, 0.05}, {0.95, 0.05}, {0.95, 0.4}, {0.4, 0.4}, {0.4, 0.95}, {0.05, 0.95}};
    const Ring square = {{0.1, 0.1}, {0.9, 0.1}, {0.9, 0.9}, {0.1, 0.9}};
    const Ring hole = {{0.4, 0.4}, {0.6, 0.4}, {0.6, 0.6}, {0.4, 0.6}};
    const Ring low = {{0, 0.1}, {1, 0.2}, {1, 0.4}, {0, 0.3}}, high = {{0, 0.6}, {1, 0.7}, {1, 0.9}, {0, 0.8}};
    return {{{disc, {}}}, {{star, {}}}, {{corner, {}}}, {{square, {hole}}}, {{low, {}}, {high, {}}}};
}

Set inside(const Set& points, const Domain& domain) {
    const FeatureArea area(domain);
    Set kept;
    std::ranges::copy_if(points, std::back_inserter(kept), [&](Point p) { return area.contains(p); });
    return kept;
}

TEST(AnalysisInPolygons, IsThatOfTheLargerPattern) {
    const Set points = distribute(torus(), Density::uniform(), {.sites = 12'000}).value().points;
    const Analysis whole = measured({points}, torus());
    for (const auto& parts : shapes()) {
        const Domain domain = Domain::create(parts).value();
        const Analysis part = measured({inside(points, domain)}, domain);
        // The taper of narrow shapes blurs the spectrum, which rises steeply near the frequency 0.5. Of random points,
        // the power would be 37 dB larger.
        EXPECT_NEAR(10 * std::log10(*part.low_frequency_power / *whole.low_frequency_power), 0, 2.5);
        EXPECT_NEAR(part.mean_distance, whole.mean_distance, 0.005);
        EXPECT_GE(part.min_distance, 0.95 * whole.min_distance);
        EXPECT_NEAR(means_of(part).power, means_of(whole).power, 0.02);
    }
}

TEST(AnalysisInPolygons, MeasuresWhiteNoiseAsOne) {
    const Set noise = white_noise(1, 12'000).front();
    for (const auto& parts : shapes()) {
        const Domain domain = Domain::create(parts).value();
        const Analysis part = measured({inside(noise, domain)}, domain);
        EXPECT_NEAR(means_of(part).power, 1, 0.04);
        EXPECT_NEAR(*part.low_frequency_power, 1, 0.25);
        // Expected distance of random points, 1 / (2 sqrt(n)), relative to the hexagonal one.
        EXPECT_NEAR(part.mean_distance, 0.5 / std::sqrt(2 / std::sqrt(3)), 0.015);
    }
}

TEST(AnalysisInPolygons, DoesNotDependOnUnits) {
    const Set noise = white_noise(1, 500).front();
    const Ring ring = {{0.1, 0}, {0.9, 0.1}, {0.6, 0.9}};
    const Domain small = Domain::create({{ring, {}}}).value();
    const auto scaled = [](Set points) {
        for (Point& p : points) p = {1e100 * p.x - 3e100, 1e100 * p.y + 1e100};
        return points;
    };
    const Domain large = Domain::create({{scaled(ring), {}}}).value();
    const Analysis a = measured({inside(noise, small)}, small);
    const Analysis b = measured({scaled(inside(noise, small))}, large);
    ASSERT_EQ(a.power.size(), b.power.size());
    for (std::size_t r = 0; r < a.power.size(); ++r) EXPECT_NEAR(a.power[r], b.power[r], 1e-6);
    EXPECT_NEAR(a.mean_distance, b.mean_distance, 1e-9);
}

TEST(AnalysisInPolygons, RefusesPointsOutsideAndNarrowShapes) {
    const Domain triangle = Domain::create({{{{0, 0}, {1, 0}, {0, 1}}, {}}}).value();
    const Set points = {{0.1, 0.1}, {0.2, 0.3}, {0.7, 0.7}};
    const auto outside = analyse(Sets{points}, triangle, {});
    ASSERT_FALSE(outside);
    EXPECT_EQ(outside.error().code, ErrorCode::Unusable);
    EXPECT_EQ(outside.error().field, "/0/2");
    const Domain needle = Domain::create({{{{0, 0}, {1, 1}, {1, 1.0005}, {0, 0.0005}}, {}}}).value();
    const auto narrow = analyse(Sets{{{0.5, 0.5001}, {0.6, 0.6001}, {0.7, 0.7001}}}, needle, {});
    ASSERT_FALSE(narrow);
    EXPECT_EQ(narrow.error().field, "domain");
}

TEST(AnalysisInSpace, MeasuresWhiteNoiseAsOneAndIsotropic) {
    // The mean over about 17,000 or, in the window, 8,000 independent frequencies and 10 sets.
    for (const bool periodic : {true, false}) {
        for (const Point3 sides : {Point3{1, 1, 1}, Point3{300, 100, 200}}) {
            const auto analysis = analyse(white_noise(10, 1000, sides), sides, periodic, {.max_frequency = 2}).value();
            double power = 0, anisotropy = 0;
            const std::size_t shells = analysis.power.size();
            for (std::size_t r = 5; r < shells; ++r) {
                power += analysis.power[r] / static_cast<double>(shells - 5);
                anisotropy += analysis.anisotropy_db[r] / static_cast<double>(shells - 5);
            }
            EXPECT_EQ(analysis.frequency.size(), periodic ? 20U : 19U);
            EXPECT_NEAR(power, 1, 0.03);
            EXPECT_NEAR(*analysis.low_frequency_power, 1, 0.1);
            // The mean nearest distance of n random points is Gamma(4/3) (4 pi n / 3)^(-1/3) at unit volume.
            if (!periodic) continue;
            EXPECT_NEAR(analysis.unit, 10 / std::cbrt(sides.x * sides.y * sides.z), 1e-12);
            EXPECT_NEAR(anisotropy, -10, 0.3);
            EXPECT_NEAR(analysis.mean_distance, std::tgamma(4.0 / 3) / std::cbrt(4 * std::numbers::pi / 3) / 1.122462,
                        0.01);
        }
    }
}

TEST(AnalysisInSpace, FindsTheReciprocalPointsOfTheDensestPacking) {
    constexpr int kCells = 4;
    const Point3 sides{0.5, 0.5, 0.5};
    std::vector<Point3> points;
    for (int k = 0; k < 2 * kCells; ++k) {
        for (int j = 0; j < 2 * kCells; ++j) {
            for (int i = 0; i < 2 * kCells; ++i) {
                if ((i + j + k) % 2 == 0) points.push_back({i / 16.0, j / 16.0, k / 16.0});
            }
        }
    }
    const SpaceSets sets{points};
    const auto analysis = analyse(sets, sides, true, {.max_frequency = 2}).value();
    EXPECT_NEAR(analysis.min_distance, 1, 1e-12);
    EXPECT_NEAR(analysis.mean_distance, 1, 1e-12);
    EXPECT_NEAR(*analysis.low_frequency_power, 0, 1e-15);
    // The shortest reciprocal vectors, (1, 1, 1) / cell, have the principal frequency, twice the end of low
    // frequencies.
    const auto peak = std::ranges::max_element(analysis.power) - analysis.power.begin();
    EXPECT_NEAR(analysis.frequency[static_cast<std::size_t>(peak)], 1.0911, 0.5 / std::cbrt(points.size()));
    for (int j = -8; j <= 8; ++j) {
        for (int i = -8; i <= 8; ++i) {
            const bool is_peak = i % 8 == 0 && j % 8 == 0 && (i != 0 || j != 0);
            EXPECT_NEAR(analysis.spectrum.at(i, j), is_peak ? static_cast<double>(points.size()) : 0, 1e-7) << i << j;
        }
    }
}

TEST(AnalysisInSpace, ComputesLargeSpectraInParts) {
    const Point3 sides{4, 2, 1};
    const SpaceSets sets = white_noise(1, 1'000, sides);
    const auto whole = analyse(sets, sides, true, {.max_frequency = 7}).value(),
               parts = analyse(sets, sides, true, {.max_frequency = 8.3}).value();
    ASSERT_GT(parts.spectrum.width, whole.spectrum.width);
    for (std::size_t r = 0; r < whole.power.size(); ++r) EXPECT_NEAR(parts.power[r], whole.power[r], 1e-8) << r;
    EXPECT_EQ(std::ranges::count(parts.spectrum.values, 0.0), 1) << "only (0, 0, 0) is left out";
}

TEST(AnalysisInSpace, RefusesInvalidInput) {
    const auto expect = [](const SpaceSets& sets, Point3 sides, bool periodic, ErrorCode code,
                           const std::string& field) {
        const auto analysis = analyse(sets, sides, periodic, {.max_frequency = 2});
        ASSERT_FALSE(analysis);
        EXPECT_EQ(analysis.error().code, code) << analysis.error().message;
        EXPECT_EQ(analysis.error().field, field) << analysis.error().message;
    };
    SpaceSets sets = white_noise(2, 10, {1, 1, 1});
    for (const double side : {0.0, -1.0, std::nan(""), HUGE_VAL})
        expect(sets, {1, 1, side}, true, ErrorCode::Unusable, "domain");
    expect(sets, {1e-308, 1e-308, 1e308}, true, ErrorCode::Unusable, "/0/0");
    expect({{{0, 0, 0}, {0, 0, 1}}}, {1e-308, 1e-308, 1e308}, true, ErrorCode::LimitExceeded, "max_frequency");
    expect({{{0, 0, 0}, {0, 0, 1}}}, {1, 1, 1}, false, ErrorCode::Unusable, "/0");
    sets[1][7].z = 1.5;
    expect(sets, {1, 1, 1}, false, ErrorCode::Unusable, "/1/7");
}

}  // namespace
}  // namespace ccdt
