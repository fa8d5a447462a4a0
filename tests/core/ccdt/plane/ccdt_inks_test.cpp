// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/ccdt.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/meshes.h"
#include "tests/support/pictures.h"

namespace ccdt {
namespace {

using test::grid_of;

const Domain kSquare = Domain::rectangle(1, 1).value();

bool same_bytes(const std::vector<Point>& a, const std::vector<Point>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Point)) == 0;
}

/// Returns the densities of three inks, each dense where another one is sparse.
std::vector<Density> ramps() {
    const auto ramp = [](double x, double y) {
        return grid_of(64, 64, [=](int i, int j) { return 0.2 + x * i / 64 + y * j / 64; });
    };
    return {ramp(1, 0), ramp(-0.1, 0.8), ramp(0, 0)};
}

TEST(DistributeInks, GivesEachInkItsSitesInsideTheDomain) {
    const std::vector<std::size_t> counts{500, 0, 1};
    const auto inks = distribute_inks(kSquare, ramps(), counts, {.seed = 3}).value();
    ASSERT_EQ(inks.size(), counts.size());
    for (std::size_t i = 0; i < inks.size(); ++i) {
        EXPECT_EQ(inks[i].points.size(), counts[i]);
        for (const Point& p : inks[i].points) EXPECT_TRUE(p.x > 0 && p.x < 1 && p.y > 0 && p.y < 1);
        EXPECT_TRUE(std::isfinite(inks[i].variation()));
    }
}

TEST(DistributeInks, GivesOneInkTheDotsOfGrey) {
    const std::vector<Density> densities = ramps();
    for (const Quality quality : {Quality::Draft, Quality::Standard, Quality::Best}) {
        Options options{.seed = 5, .quality = quality};
        const auto inks = distribute_inks(kSquare, densities, std::vector<std::size_t>{0, 400, 0}, options).value();
        options.sites = 400;
        const auto grey = distribute(kSquare, densities[1], options).value();
        EXPECT_TRUE(same_bytes(inks[1].points, grey.points));
        EXPECT_EQ(inks[1].trace, grey.trace);
        EXPECT_EQ(inks[1].polished, grey.polished);
        EXPECT_EQ(inks[1].iterations, grey.iterations);
    }
}

TEST(DistributeInks, ReportsProgressOfAllInksAsOneRun) {
    std::vector<Progress> told;
    const Control control{{}, [&](const Progress& progress) { told.push_back(progress); }};
    const Options options{.iterations = 3};
    const auto inks =
        distribute_inks(kSquare, ramps(), std::vector<std::size_t>{300, 200, 100}, options, control).value();
    ASSERT_GT(told.size(), 4u);
    const int rounds = told[0].rounds;
    EXPECT_EQ(told.size(), 4u + static_cast<std::size_t>(rounds));
    for (std::size_t i = 0; i < told.size(); ++i) {
        const std::size_t iteration = std::min<std::size_t>(i, 3);
        EXPECT_EQ(told[i].iteration, static_cast<int>(iteration));
        EXPECT_EQ(told[i].iterations, 3);
        EXPECT_EQ(told[i].round, static_cast<int>(i - iteration));
        EXPECT_EQ(told[i].rounds, rounds);
        double largest = 0;
        for (const Distribution& ink : inks) largest = std::max(largest, ink.trace[iteration]);
        EXPECT_EQ(told[i].variation, largest);
    }
}

TEST(DistributeInks, ReturnsTheCurrentSitesOfAllInksWhenStopped) {
    std::stop_source source;
    const Control control{source.get_token(), [&](const Progress& progress) {
                              if (progress.iteration == 2) source.request_stop();
                          }};
    const std::vector<std::size_t> counts{300, 200, 100};
    const auto inks = distribute_inks(kSquare, ramps(), counts, {}, control).value();
    for (std::size_t i = 0; i < inks.size(); ++i) {
        EXPECT_TRUE(inks[i].stopped);
        EXPECT_EQ(inks[i].iterations, 2);
        EXPECT_EQ(inks[i].points.size(), counts[i]);
    }
}

TEST(DistributeInks, FailsIfStoppedDuringTheStart) {
    std::stop_source source;
    source.request_stop();
    const auto inks =
        distribute_inks(kSquare, ramps(), std::vector<std::size_t>{300, 200, 100}, {}, {source.get_token(), {}});
    ASSERT_FALSE(inks);
    EXPECT_EQ(inks.error().code, ErrorCode::Stopped);
}

TEST(DistributeInks, IsDeterministic) {
    const std::vector<std::size_t> counts{400, 300, 200};
    const auto once = distribute_inks(kSquare, ramps(), counts, {.seed = 9}).value();
    const auto again = distribute_inks(kSquare, ramps(), counts, {.seed = 9}).value();
    for (std::size_t i = 0; i < counts.size(); ++i) EXPECT_TRUE(same_bytes(once[i].points, again[i].points));
    EXPECT_FALSE(same_bytes(once[0].points, distribute_inks(kSquare, ramps(), counts, {}).value()[0].points));
}

/// Distributes each ink separately, with independent seeds.
std::vector<Distribution> each_alone(const Domain& domain, const std::vector<Density>& densities,
                                     const std::vector<std::size_t>& counts) {
    std::vector<Distribution> inks;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        inks.push_back(distribute(domain, densities[i], {.sites = counts[i], .seed = 100 + i}).value());
    }
    return inks;
}

/// Returns the distances from each site to the nearest site of another ink, in ascending order.
std::vector<double> distances_between(const std::vector<Distribution>& inks) {
    std::vector<double> distances;
    for (std::size_t a = 0; a < inks.size(); ++a) {
        for (const Point& p : inks[a].points) {
            double least = 1e9;
            for (std::size_t b = 0; b < inks.size(); ++b) {
                if (a == b) continue;
                for (const Point& q : inks[b].points) least = std::min(least, dot(q - p, q - p));
            }
            distances.push_back(std::sqrt(least));
        }
    }
    std::ranges::sort(distances);
    return distances;
}

TEST(DistributeInks, KeepsDotsOfDifferentInksApart) {
    const std::vector<std::size_t> counts{600, 450, 300};
    const auto distances = distances_between(distribute_inks(kSquare, ramps(), counts, {.seed = 2}).value());
    const auto alone = distances_between(each_alone(kSquare, ramps(), counts));
    const std::size_t first = distances.size() / 100, tenth = distances.size() / 10;
    EXPECT_GT(distances[first], 4 * alone[first]);
    EXPECT_GT(distances[tenth], 1.8 * alone[tenth]);
}

/// Returns the mean power of the density error in waves of up to 4 periods per side; 1 for independent sites.
double tone_error(const Density& density, const std::vector<Point>& points) {
    constexpr int kWaves = 8;  // in half periods
    constexpr double kPi = 3.141592653589793;
    const double scale = static_cast<double>(points.size()) / density.total();
    double power = 0;
    for (int k = 0; k <= kWaves; ++k) {
        for (int l = k == 0 ? 1 : 0; l <= kWaves; ++l) {
            const auto wave = [&](double x, double y) { return std::cos(kPi * k * x) * std::cos(kPi * l * y); };
            double amplitude = 0;
            for (const Point& p : points) amplitude += wave(p.x, p.y);
            for (int row = 0; row < density.height(); ++row) {
                for (int column = 0; column < density.width(); ++column) {
                    const double x = (column + 0.5) / density.width(), y = (row + 0.5) / density.height();
                    amplitude -= scale * density.value(column, row) * wave(x, y);
                }
            }
            power += (k > 0 ? 2 : 1) * (l > 0 ? 2 : 1) * amplitude * amplitude / static_cast<double>(points.size());
        }
    }
    return power / ((kWaves + 1) * (kWaves + 1) - 1);
}

TEST(DistributeInks, KeepsTheToneOfEachInk) {
    const std::vector<Density> densities = ramps();
    const std::vector<std::size_t> counts{1200, 900, 600};
    constexpr int kSeeds = 4;
    double error = 0;  // mean error
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        const auto inks = distribute_inks(kSquare, densities, counts, {.seed = seed}).value();
        for (std::size_t i = 0; i < counts.size(); ++i) {
            error += tone_error(densities[i], inks[i].points) / (3 * kSeeds);
            EXPECT_LT(inks[i].variation(), 0.25) << i;
        }
    }
    EXPECT_LT(error, 1.3e-5);
}

TEST(DistributeInks, AcceptsAllKindsOfDomains) {
    const std::vector<std::size_t> counts{300, 200, 100};
    const std::vector<Density> uniform(3, Density::uniform());
    for (const Domain& domain : {Domain::torus(1, 1).value(), test::domain_of({{test::l_shape(), {}}})}) {
        for (const auto& densities : {uniform, ramps()}) {
            const auto inks = distribute_inks(domain, densities, counts, {}).value();
            const auto distances = distances_between(inks);
            const auto alone = distances_between(each_alone(domain, densities, counts));
            EXPECT_GT(distances[6], 2 * alone[6]);
            for (std::size_t i = 0; i < counts.size(); ++i) EXPECT_EQ(inks[i].points.size(), counts[i]);
        }
    }
}

/// Returns the same move for all sites.
std::vector<std::vector<Point>> moved_by(Point move, std::span<const std::vector<Point>> sites) {
    std::vector<std::vector<Point>> moves;
    for (const auto& ink : sites) moves.emplace_back(ink.size(), move);
    return moves;
}

TEST(DistributeInks, RetouchesAllInksAtTheEnd) {
    const Domain domain = Domain::rectangle(20, 10).value();
    const std::vector<std::size_t> counts{300, 0, 100};
    const std::vector<Density> densities(3, grid_of(8, 8, [](int, int) { return 1; }));
    int calls = 0;
    const Retouch retouch = [&](std::span<const std::vector<Point>> sites) {
        ++calls;
        EXPECT_EQ(sites.size(), counts.size());
        for (std::size_t i = 0; i < counts.size(); ++i) EXPECT_EQ(sites[i].size(), counts[i]);
        for (const Point& site : sites[0]) EXPECT_TRUE(site.x > 0 && site.x < 20 && site.y > 0 && site.y < 10);
        return moved_by({0.01, -0.02}, sites);
    };
    const auto plain = distribute_inks(domain, densities, counts, {}).value();
    const auto inks = distribute_inks(domain, densities, counts, {}, {}, retouch).value();
    ASSERT_GT(calls, 0);
    double x = 0, y = 0;
    for (std::size_t i = 0; i < counts[2]; ++i) {
        x += inks[2].points[i].x - plain[2].points[i].x;
        y += inks[2].points[i].y - plain[2].points[i].y;
    }
    EXPECT_NEAR(x / 100, calls * 0.01, 0.002);
    EXPECT_NEAR(y / 100, calls * -0.02, 0.004);
}

TEST(DistributeInks, RetouchesNeitherDraftsNorOneInk) {
    const Retouch retouch = [](std::span<const std::vector<Point>> sites) {
        ADD_FAILURE();
        return moved_by({}, sites);
    };
    const std::vector<std::size_t> counts{300, 200, 100}, one{0, 200, 0};
    EXPECT_TRUE(distribute_inks(kSquare, ramps(), counts, {.quality = Quality::Draft}, {}, retouch));
    EXPECT_TRUE(distribute_inks(kSquare, ramps(), one, {}, {}, retouch));
}

TEST(DistributeInks, SkipsThePolishWhenStoppedBeforeIt) {
    std::stop_source source;
    const Control control{source.get_token(), [&](const Progress& progress) {
                              if (progress.iteration == progress.iterations) source.request_stop();
                          }};
    const std::vector<std::size_t> counts{300, 200, 100};
    const auto inks = distribute_inks(kSquare, ramps(), counts, {}, control).value();
    for (const Distribution& ink : inks) {
        EXPECT_TRUE(ink.stopped);
        EXPECT_FALSE(ink.polished);
        EXPECT_EQ(ink.iterations, 5);
    }
}

TEST(DistributeInks, RefusesDensitiesOfDifferentGrids) {
    const auto flat = grid_of(8, 8, [](int, int) { return 1; });
    const std::vector<Density> densities{ramps()[0], flat};
    const auto inks = distribute_inks(kSquare, densities, std::vector<std::size_t>{9, 9}, {});
    ASSERT_FALSE(inks);
    EXPECT_EQ(inks.error().field, "density");
    EXPECT_TRUE(distribute_inks(kSquare, densities, std::vector<std::size_t>{9, 0}, {}));
}

TEST(DistributeInks, RefusesTheSameInputsAsDistribute) {
    const std::vector<Density> densities = ramps();
    const auto none = distribute_inks(kSquare, densities, std::vector<std::size_t>{0, 0, 0}, {});
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().field, "sites");
    const auto passes = distribute_inks(kSquare, densities, std::vector<std::size_t>{9, 9, 9}, {.passes = 0});
    ASSERT_FALSE(passes);
    EXPECT_EQ(passes.error().field, "passes");
}

}  // namespace
}  // namespace ccdt
