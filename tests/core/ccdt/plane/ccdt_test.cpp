// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/ccdt.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/base/thread_executor.h"
#include "core/geometry/delaunay.h"
#include "tests/support/meshes.h"
#include "tests/support/pictures.h"

namespace ccdt {
namespace {

using test::domain_of;
using test::grid_of;
using test::Parts;

const Parts kSquare{{test::box(0, 0, 1, 1), {}}};

Distribution run(const Parts& parts, const Density& density, const Options& options) {
    return distribute(domain_of(parts), density, options).value();
}

bool same_bytes(const std::vector<Point>& a, const std::vector<Point>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Point)) == 0;
}

Density portrait() {
    return grid_of(96, 128, [](int i, int j) {
        const double x = i / 96.0 - 0.5, y = j / 128.0 - 0.5;
        return 0.05 + std::exp(-16 * (x * x + y * y)) + (i > 60 && j > 80 ? 0.7 : 0.0) + 0.04 * std::sin(0.3 * i);
    });
}

struct Position {
    std::string name;
    Parts parts;
};

std::vector<Position> positions() {
    const Parts lshape{{test::l_shape(), {}}};
    return {{"square", kSquare},
            {"thin rectangle", {{test::box(0, 0, 1, 0.01), {}}}},
            {"thin parallelogram", {{{{0, 0}, {1, 0.7}, {1, 0.71}, {0, 0.01}}, {}}}},
            {"triangle", {{{{0, 0}, {1, 0}, {0.1, 0.8}}, {}}}},
            {"needle", {{{{0, 0}, {1, 0}, {0.5, 0.02}}, {}}}},
            {"L", lshape},
            {"U", {{test::u_shape(), {}}}},
            {"star", {{test::star({0, 0}, 1, 0.4, 10), {}}}},
            {"needles", {{test::star({0, 0}, 1, 0.05, 24), {}}}},
            {"many corners", {{test::circle({0, 0}, 1, 10'000), {}}}},
            {"hole", {{test::box(0, 0, 4, 4), {test::box(1, 1, 2, 2)}}}},
            {"sieve", {test::sieve(6)}},
            {"island in a hole", {{test::box(0, 0, 8, 8), {test::box(2, 2, 4, 4)}}, {test::box(3, 3, 1, 1), {}}}},
            {"far from the origin", test::moved(test::scaled(lshape, 64), {5e6, 4.5e6})},
            {"tiny", test::scaled(lshape, 1e-9)},
            {"large", test::scaled(lshape, 1e9)},
            {"Italy", test::read_geojson("Italy-110m.geojson")},
            {"South Africa", test::read_geojson("South-Africa-50m.geojson")},
            {"Switzerland", test::read_geojson("Switzerland-10m.geojson")}};
}

std::vector<std::pair<std::string, Density>> densities() {
    Random random(77, 0);
    return {{"uniform", Density::uniform()},
            {"ramp", grid_of(16, 16, [](int i, int) { return i + 0.5; })},
            {"coarse", grid_of(3, 2, [](int i, int j) { return 1.0 + i + 2 * j; })},
            {"fine", grid_of(300, 300, [](int i, int j) { return 1 + std::sin(0.1 * i) * std::cos(0.07 * j); })},
            {"half white", grid_of(64, 64, [](int i, int) { return i < 32 ? 0.0 : 1.0; })},
            {"nearly all white", grid_of(64, 64, [&](int, int) { return random.uniform() < 0.95 ? 0.0 : 1.0; })},
            {"extreme", grid_of(16, 16, [&](int, int) { return std::pow(10.0, 24 * random.uniform() - 12); })}};
}

class Distribute : public testing::TestWithParam<std::size_t> {};

/// Tests the contract of distribute(): n distinct sites, strictly inside.
TEST_P(Distribute, PlacesDistinctSitesStrictlyInside) {
    const Position position = positions()[GetParam()];
    const Domain domain = domain_of(position.parts);
    for (const auto& [name, density] : densities()) {
        for (const std::size_t sites : {1, 2, 3, 10, 300}) {
            const auto result = distribute(domain, density, {.sites = sites, .seed = 7 * sites});
            if (!result) {
                EXPECT_EQ(result.error().code, ErrorCode::Unusable) << position.name << ", " << name;
                EXPECT_NE(name, "uniform") << position.name << ": " << result.error().message;
                continue;
            }
            EXPECT_EQ(result->points.size(), sites);
            EXPECT_EQ(test::count_outside(position.parts, result->points), 0u)
                << position.name << ", " << name << ", " << sites;
            EXPECT_EQ(test::count_distinct(result->points), sites) << position.name << ", " << name << ", " << sites;
            ASSERT_EQ(result->trace.size(), 6u);
            for (const double variation : result->trace)
                EXPECT_TRUE(std::isfinite(variation)) << position.name << ", " << name << ", " << sites;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Positions, Distribute, testing::Range(std::size_t{0}, std::size_t{19}), [](const auto& index) {
    std::string name = positions()[index.param].name;
    std::replace(name.begin(), name.end(), ' ', '_');
    return name;
});

TEST(Distribute, PlacesAThousandSites) {
    for (const Position& position : positions()) {
        const auto result = run(position.parts, Density::uniform(), {.sites = 1000, .seed = 3});
        EXPECT_EQ(test::count_outside(position.parts, result.points), 0u) << position.name;
        EXPECT_EQ(test::count_distinct(result.points), 1000u) << position.name;
    }
}

TEST(Distribute, FillsASinglePixelWithInk) {
    const Density dot = grid_of(100, 100, [](int i, int j) { return i == 70 && j == 50 ? 1.0 : 0.0; });
    const auto result = run(kSquare, dot, {.sites = 1000, .seed = 3});
    EXPECT_EQ(test::count_outside(kSquare, result.points), 0u);
    EXPECT_EQ(test::count_distinct(result.points), 1000u);
    const auto in_pixel = std::count_if(result.points.begin(), result.points.end(), [](Point p) {
        return p.x > 0.699 && p.x < 0.711 && p.y > 0.499 && p.y < 0.511;
    });
    EXPECT_GT(in_pixel, 950);
}

TEST(Distribute, StartsInTheOnlyPixelWithDensity) {
    const Density pixel = grid_of(1000, 1000, [](int i, int j) { return i == 700 && j == 500 ? 1.0 : 0.0; });
    for (const Point& p : run(kSquare, pixel, {.sites = 1000, .seed = 1, .iterations = 0}).points) {
        EXPECT_TRUE(p.x >= 0.700 && p.x <= 0.701 && p.y >= 0.500 && p.y <= 0.501) << p.x << " " << p.y;
    }
}

TEST(Distribute, HandlesBorderVerticesThatMeetAHole) {
    // A vertex set on the outer edge is rounded to the corner of the hole.
    const Parts parts{{{{0, 0}, {1, 0.67211498554141436}, {0.16277443304464762, 1}},
                       {{{0.056603773584905662, 0.038044244464608364}, {0.4, 0.5}, {0.41, 0.52}}}}};
    EXPECT_EQ(run(parts, Density::uniform(), {.sites = 1000, .seed = 1}).points.size(), 1000u);
}

TEST(Distribute, SetsFewVerticesOnTheBorderOfASliver) {
    const Parts sliver{{test::box(0, 0, 1, 1e-8), {}}};
    const auto result = run(sliver, Density::uniform(), {.sites = 1000, .seed = 1, .keep_mesh = true});
    EXPECT_LT(result.mesh->vertices.size(), 6000u);
    for (const Point& p : result.points) EXPECT_TRUE(p.y > 0 && p.y < 1e-8) << p.y;
}

/// The two cells with density overlap the triangle's bounding box, but not the triangle.
TEST(Distribute, RefusesADensityInsideOnlyByRounding) {
    const Parts triangle{{{{1, 0}, {1, 1}, {0, 1}}, {}}};
    Random random(1, 1);
    for (int i = 0; i < 200; ++i) {
        const int width = 5 + static_cast<int>(60 * random.uniform()),
                  height = 5 + static_cast<int>(60 * random.uniform());
        const double first = random.uniform(), second = random.uniform();
        const Density corner = grid_of(width, height, [&](int x, int y) {
            return y > 0 ? 0.0 : x == 0 ? first : x == 1 ? second : 0.0;
        });
        const auto result = distribute(domain_of(triangle), corner, {.sites = 10});
        ASSERT_FALSE(result) << width << " x " << height;
        EXPECT_EQ(result.error().code, ErrorCode::Unusable);
    }
}

TEST(Distribute, RefusesADensityOutsideTheDomain) {
    // The domain is the half of its box beyond the diagonal.
    const Parts half{{{{1, 0}, {1, 1}, {0, 1}}, {}}};
    for (int size = 4; size < 64; ++size) {
        const Density corner = grid_of(size, size + 5, [](int i, int j) { return i + j < 2 ? 0.1 + 0.7 * i : 0.0; });
        const auto result = distribute(domain_of(half), corner, {.sites = 10});
        ASSERT_FALSE(result) << size;
        EXPECT_EQ(result.error().code, ErrorCode::Unusable);
        EXPECT_EQ(result.error().field, "density");
    }
}

TEST(Distribute, RefusesOptionsOutOfRange) {
    const Domain domain = domain_of(kSquare);
    const auto expect_refused = [&](const Options& options, const std::string& field) {
        const auto result = distribute(domain, Density::uniform(), options);
        ASSERT_FALSE(result) << field;
        EXPECT_EQ(result.error().code, ErrorCode::Malformed);
        EXPECT_EQ(result.error().field, field);
    };
    expect_refused({}, "sites");
    expect_refused({.sites = (std::size_t{1} << 28) + 1}, "sites");
    expect_refused({.sites = 5, .iterations = -1}, "iterations");
    expect_refused({.sites = 5, .iterations = 1001}, "iterations");
    expect_refused({.sites = 5, .passes = 0}, "passes");
    expect_refused({.sites = 5, .passes = 101}, "passes");
    for (const double bad : {0.0, -1.0, std::nan("")}) expect_refused({.sites = 5, .tolerance = bad}, "tolerance");
}

TEST(Distribute, IsDeterministicForASeed) {
    const Density picture = portrait();
    for (const Density& density : {Density::uniform(), picture}) {
        const Options options{.sites = 2000, .seed = 11};
        const auto first = run(kSquare, density, options);
        EXPECT_TRUE(same_bytes(first.points, run(kSquare, density, options).points));
        EXPECT_FALSE(same_bytes(first.points, run(kSquare, density, {.sites = 2000, .seed = 12}).points));
    }
}

TEST(Distribute, IsIdenticalInConcurrentRuns) {
    const Domain domain = domain_of(test::read_geojson("South-Africa-50m.geojson"));
    const Density density = portrait();
    const Options options{.sites = 1500, .seed = 11};
    const auto expected = distribute(domain, density, options)->points;
    std::vector<std::vector<Point>> results(4);
    {
        std::vector<std::jthread> threads;
        for (auto& result : results) {
            threads.emplace_back([&] { result = distribute(domain, density, options)->points; });
        }
    }
    for (const auto& result : results) EXPECT_TRUE(same_bytes(result, expected));
}

/// An executor that counts its tasks.
class CountingExecutor : public Executor {
public:
    void run(std::size_t count, const std::function<void(std::size_t)>& task) override {
        ++runs;
        inline_executor().run(count, task);
    }
    int runs = 0;
};

TEST(Distribute, RunsThePolishOnTheExecutorToo) {
    const auto runs_of = [](Quality quality) {
        CountingExecutor executor;
        Control control;
        control.executor = &executor;
        const auto result =
            distribute(domain_of(kSquare), Density::uniform(), {.sites = 20'000, .quality = quality}, control);
        EXPECT_TRUE(result);
        return executor.runs;
    };
    const int draft = runs_of(Quality::Draft), standard = runs_of(Quality::Standard);
    EXPECT_GT(draft, 60);
    EXPECT_GT(standard, draft + 100) << "a polish of 15 rounds, each of several steps";
}

TEST(Distribute, IsIdenticalOnAnyNumberOfThreads) {
    constexpr std::size_t kSites = 20'000;  // enough for several blocks of sites, on several levels
    const Domain land = domain_of(test::read_geojson("South-Africa-50m.geojson"));
    const Domain square = domain_of(kSquare), torus = Domain::torus(1, 0.8).value();
    const Density uniform = Density::uniform(), picture = portrait();
    struct Case {
        std::string name;
        const Domain& domain;
        const Density& density;
        Options options;
    };
    const std::vector<Case> cases{
        {"square", square, uniform, {.sites = kSites, .quality = Quality::Best, .keep_mesh = true}},
        {"random start", square, uniform, {.sites = kSites, .start = Start::Random, .quality = Quality::Draft}},
        {"picture", square, picture, {.sites = kSites, .keep_mesh = true}},
        {"torus", torus, uniform, {.sites = kSites, .quality = Quality::Stealthy}},
        {"picture on a torus", torus, picture, {.sites = kSites}},
        {"polygon", land, uniform, {.sites = kSites, .keep_mesh = true}},
        {"picture in a polygon", land, picture, {.sites = kSites, .quality = Quality::Draft}},
        {"fixed points", square, uniform, {.sites = kSites, .fixed = {{0.5, 0.5}, {0.51, 0.5}, {0.1, 0.9}}}}};
    for (const Case& c : cases) {
        SCOPED_TRACE(c.name);
        const auto expected = distribute(c.domain, c.density, c.options).value();
        for (const std::size_t size : {2, 3, 16}) {
            ThreadExecutor executor(size);
            Control control;
            control.executor = &executor;
            const auto found = distribute(c.domain, c.density, c.options, control).value();
            EXPECT_TRUE(same_bytes(found.points, expected.points)) << size << " threads";
            EXPECT_EQ(found.trace, expected.trace);
            EXPECT_EQ(found.polished, expected.polished);
            if (!c.options.keep_mesh) continue;
            EXPECT_TRUE(same_bytes(found.mesh->vertices, expected.mesh->vertices));
            EXPECT_EQ(found.mesh->triangles, expected.mesh->triangles);
        }
    }
}

TEST(Distribute, IsEquivariantUnderTranslationAndScaling) {
    for (const char* name : {"Italy-110m.geojson", "Switzerland-10m.geojson"}) {
        // Coordinates on a lattice, so that translations are exact.
        Parts parts = test::scaled(test::read_geojson(name), 0x1p20);
        for (PolygonPart& part : parts) {
            for (Point& p : part.outer) p = {std::round(p.x), std::round(p.y)};
        }
        const Options options{.sites = 500, .seed = 4};
        const Point by{0x1p24, -0x1p23};
        const auto points = run(parts, Density::uniform(), options).points;
        const auto moved = run(test::moved(parts, by), Density::uniform(), options).points;
        const auto large = run(test::scaled(parts, 0x1p10), Density::uniform(), options).points;
        const double size = domain_of(parts).bounds().width();
        for (std::size_t i = 0; i < points.size(); ++i) {
            EXPECT_NEAR(moved[i].x, points[i].x + by.x, 1e-12 * (size + by.x));
            EXPECT_NEAR(moved[i].y, points[i].y + by.y, 1e-12 * (size + by.x));
            EXPECT_EQ(large[i], 0x1p10 * points[i]);
        }
    }
}

TEST(Distribute, DependsOnRatiosOfTheDensityOnly) {
    const Density ramp = grid_of(16, 16, [](int i, int j) { return 1.0 + i * j; });
    const Density scaled = grid_of(16, 16, [](int i, int j) { return 0x1p40 * (1.0 + i * j); });
    const Options options{.sites = 500, .seed = 4};
    EXPECT_TRUE(same_bytes(run(kSquare, ramp, options).points, run(kSquare, scaled, options).points));
}

TEST(Distribute, WorksEquallyWellWhenRotated) {
    const Density density = portrait();
    const Density turned =
        grid_of(128, 96, [&](int i, int j) { return density.value(j, 127 - i); });  // clockwise by a right angle
    const Parts tall{{test::box(0, 0, 3, 4), {}}}, wide{{test::box(0, 0, 4, 3), {}}};
    double before = 0, after = 0;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
        before += run(tall, density, {.sites = 1000, .seed = seed}).variation() / 4;
        after += run(wide, turned, {.sites = 1000, .seed = seed}).variation() / 4;
    }
    EXPECT_NEAR(before, after, 0.1 * before);
}

TEST(Distribute, KeepsADelaunayMesh) {
    const Density picture = portrait();
    for (const Position& position : {positions()[0], positions()[6], positions()[12], positions()[17]}) {
        std::size_t holes = 0;
        for (const PolygonPart& part : position.parts) holes += part.holes.size();
        // Tests in the unit frame by exact predicates. If a domain is not scaled by a power of two, only counts
        // triangles.
        const bool exact = position.name != "South Africa";
        for (const int iterations : {0, 1, 2, 5}) {
            for (const Density& density : {Density::uniform(), picture}) {
                SCOPED_TRACE(position.name + ", " + std::to_string(iterations));
                const auto result = run(position.parts, density,
                                        {.sites = 600, .seed = 2, .iterations = iterations, .keep_mesh = true});
                ASSERT_TRUE(result.mesh);
                const TriangleMesh& mesh = *result.mesh;
                std::size_t border = 0;
                for (const auto& loop : mesh.boundary) border += loop.size();
                EXPECT_EQ(mesh.boundary.size(), position.parts.size() + holes);
                EXPECT_EQ(mesh.vertices.size(), 600 + border);
                EXPECT_EQ(mesh.triangles.size(), 2 * 600 + border + 2 * holes - 2 * position.parts.size());
                EXPECT_TRUE(std::equal(result.points.begin(), result.points.end(), mesh.vertices.begin()));
                double area = 0;
                std::size_t inverted = 0;
                for (const auto& [a, b, c] : mesh.triangles) {
                    const Point p = mesh.vertices[a], q = mesh.vertices[b], r = mesh.vertices[c];
                    area += cross(q - p, r - p) / 2;
                    inverted += exact && exact_orientation(p, q, r) <= 0 ? 1 : 0;
                }
                EXPECT_EQ(inverted, 0u);
                const double whole = domain_of(position.parts).area();
                EXPECT_NEAR(area, whole, 1e-9 * whole);
            }
        }
    }
}

TEST(Distribute, KeepsNoMeshUnlessAsked) {
    EXPECT_FALSE(run(kSquare, Density::uniform(), {.sites = 10}).mesh);
}

TEST(Distribute, LowersTheVariation) {
    const Parts large{{test::box(0, 0, 5, 5), {}}};
    const auto draft = run(large, Density::uniform(), {.sites = 16384, .seed = 1, .quality = Quality::Draft});
    EXPECT_GT(draft.trace.front(), 0.55);
    EXPECT_LT(draft.variation(), 0.06);
    EXPECT_LT(draft.trace[1], draft.trace[0]);
    EXPECT_LT(run(kSquare, portrait(), {.sites = 4096, .seed = 1, .quality = Quality::Draft}).variation(), 0.08);
    // The polish trades some variation for distance and for fewer long waves.
    EXPECT_LT(run(large, Density::uniform(), {.sites = 16384, .seed = 1}).variation(), 0.08);
    EXPECT_LT(run(kSquare, portrait(), {.sites = 4096, .seed = 1}).variation(), 0.085);
}

/// Pushes use the local spacing of the density, so they do not make capacities unequal.
TEST(Distribute, KeepsTheVariationLowInPolygonsOfVaryingDensity) {
    std::vector<double> values;
    for (int i = 0; i < 64; ++i) values.push_back(4 + 15 * i);
    const auto steep = Density::grid(64, 1, std::span<const double>(values)).value();
    const Parts house{{{{0, 0}, {1, 0}, {1, 1}, {0.5, 1.2}, {0, 1}}, {}}};
    EXPECT_LT(run(house, steep, {.sites = 2000}).variation(), 0.11);
}

TEST(Distribute, DoesNotStallNextToWhite) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
        const auto draft = run(kSquare, test::pear(), {.sites = 3000, .seed = seed, .quality = Quality::Draft});
        EXPECT_GT(draft.trace[4], 0.13) << "before the exact passes";
        EXPECT_LT(draft.variation(), 0.1);
    }
}

TEST(Distribute, ReportsTheVariationOfThePolishedPoints) {
    const Options options{.sites = 1000, .seed = 2, .quality = Quality::Draft};
    const auto draft = run(kSquare, portrait(), options);
    EXPECT_FALSE(draft.polished);
    EXPECT_EQ(draft.variation(), draft.trace.back());
    const auto start = run(kSquare, portrait(), {.sites = 1000, .seed = 2, .iterations = 0});
    EXPECT_FALSE(start.polished) << "the start is returned as it is";
    const auto standard = run(kSquare, portrait(), {.sites = 1000, .seed = 2});
    ASSERT_TRUE(standard.polished);
    EXPECT_EQ(standard.variation(), *standard.polished);
    EXPECT_NE(standard.variation(), standard.trace.back());
    EXPECT_EQ(standard.trace.size(), 6u);
}

TEST(Distribute, EndsAtTheTolerance) {
    const auto result = run(kSquare, Density::uniform(), {.sites = 2000, .iterations = 50, .tolerance = 0.2});
    EXPECT_LT(result.iterations, 10);
    EXPECT_GT(result.iterations, 0);
    EXPECT_LT(result.variation(), 0.2);
    EXPECT_GE(result.trace[result.trace.size() - 2], 0.2);
    EXPECT_EQ(result.trace.size(), static_cast<std::size_t>(result.iterations) + 1);
    EXPECT_FALSE(result.stopped);
}

TEST(Distribute, ReturnsTheStartWithoutIterations) {
    const auto start = run(kSquare, Density::uniform(), {.sites = 500, .seed = 5, .iterations = 0});
    EXPECT_EQ(start.iterations, 0);
    EXPECT_EQ(start.trace.size(), 1u);
    const auto result = run(kSquare, Density::uniform(), {.sites = 500, .seed = 5});
    EXPECT_EQ(start.trace[0], result.trace[0]);
    double longest = 0;
    for (std::size_t i = 0; i < 500; ++i) {
        const Point d = start.points[i] - result.points[i];
        longest = std::max(longest, std::sqrt(dot(d, d)));
    }
    EXPECT_GT(longest, 0);
    EXPECT_LT(longest, 3 / std::sqrt(500.0));
}

TEST(Distribute, ReportsEachIterationAndRound) {
    std::vector<Progress> seen;
    Control control;
    control.progress = [&](const Progress& progress) { seen.push_back(progress); };
    const auto result = distribute(domain_of(kSquare), Density::uniform(), {.sites = 200, .iterations = 3}, control);
    ASSERT_TRUE(result);
    ASSERT_GT(seen.size(), 4u);
    const int rounds = seen[0].rounds;
    EXPECT_EQ(seen.size(), 4u + static_cast<std::size_t>(rounds));
    double before = 0;
    for (int i = 0; i < 4 + rounds; ++i) {
        const Progress& progress = seen[static_cast<std::size_t>(i)];
        EXPECT_EQ(progress.iteration, std::min(i, 3));
        EXPECT_EQ(progress.iterations, 3);
        EXPECT_EQ(progress.variation, result->trace[static_cast<std::size_t>(std::min(i, 3))]);
        EXPECT_EQ(progress.round, std::max(i - 3, 0));
        EXPECT_EQ(progress.rounds, rounds);
        EXPECT_GT(progress.done(), before);
        before = progress.done();
    }
    EXPECT_LT(before, 1);
}

TEST(Distribute, ReportsNoPolishOfDrafts) {
    std::vector<Progress> seen;
    Control control;
    control.progress = [&](const Progress& progress) { seen.push_back(progress); };
    const Options options{.sites = 200, .iterations = 3, .quality = Quality::Draft};
    ASSERT_TRUE(distribute(domain_of(kSquare), Density::uniform(), options, control));
    ASSERT_EQ(seen.size(), 4u);
    EXPECT_EQ(seen.back().rounds, 0);
    EXPECT_EQ(seen.back().done(), 5.0 / 6);
}

TEST(Distribute, StopsBeforeTheStart) {
    std::stop_source source;
    source.request_stop();
    for (const std::size_t sites : {100, 20000}) {
        const auto result = distribute(domain_of(kSquare), Density::uniform(), {.sites = sites},
                                       Control{.stop = source.get_token(), .progress = {}});
        if (result) {
            EXPECT_TRUE(result->stopped);
            EXPECT_EQ(result->iterations, 0);
            EXPECT_EQ(result->points.size(), sites);
        } else {
            EXPECT_EQ(result.error().code, ErrorCode::Stopped);
        }
    }
}

TEST(Distribute, StopsBetweenIterations) {
    std::stop_source source;
    Control control{.stop = source.get_token(), .progress = {}};
    control.progress = [&](const Progress& progress) {
        if (progress.iteration == 2) source.request_stop();
    };
    const auto result = distribute(domain_of(kSquare), Density::uniform(), {.sites = 1000, .iterations = 40}, control);
    ASSERT_TRUE(result);
    EXPECT_TRUE(result->stopped);
    EXPECT_EQ(result->iterations, 2);
    EXPECT_EQ(result->trace.size(), 3u);
    EXPECT_EQ(test::count_outside(kSquare, result->points), 0u);
    EXPECT_EQ(test::count_distinct(result->points), 1000u);
}

TEST(Distribute, StopsDuringThePolish) {
    std::stop_source source;
    Control control{.stop = source.get_token(), .progress = {}};
    control.progress = [&](const Progress& progress) {
        if (progress.iteration == progress.iterations) source.request_stop();
    };
    const Options options{.sites = 1000, .keep_mesh = true};
    const auto result = distribute(domain_of(kSquare), Density::uniform(), options, control);
    ASSERT_TRUE(result);
    EXPECT_TRUE(result->stopped);
    EXPECT_EQ(result->iterations, options.iterations);
    EXPECT_FALSE(result->polished);
    EXPECT_EQ(result->variation(), result->trace.back());
    Options draft = options;
    draft.quality = Quality::Draft;
    EXPECT_EQ(test::count_outside(kSquare, result->points), 0u);
    EXPECT_EQ(result->mesh->triangles.size(), run(kSquare, Density::uniform(), draft).mesh->triangles.size());
}

/// Returns the share of sites within each of some distances of the border, divided by the share of the area there.
std::vector<double> crowding(const Parts& parts, std::size_t sites, const std::vector<double>& spacings, int seeds) {
    const Domain domain = domain_of(parts);
    std::vector<std::pair<Point, Point>> edges;
    for (const PolygonPart& part : parts) {
        std::vector<Ring> rings = part.holes;
        rings.push_back(part.outer);
        for (const Ring& ring : rings) {
            for (std::size_t i = 0; i < ring.size(); ++i) edges.emplace_back(ring[i], ring[(i + 1) % ring.size()]);
        }
    }
    const auto distance = [&](Point p) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& [a, b] : edges) {
            const Point along = b - a, to = p - a;
            const double length = dot(along, along);
            const double t = length > 0 ? std::clamp(dot(to, along) / length, 0.0, 1.0) : 0;
            const Point off = to - t * along;
            nearest = std::min(nearest, dot(off, off));
        }
        return std::sqrt(nearest);
    };
    const double spacing = std::sqrt(domain.area() / static_cast<double>(sites));
    const auto shares = [&](const std::vector<Point>& points) {
        std::vector<double> within(spacings.size(), 0);
        for (const Point& p : points) {
            const double d = distance(p);
            for (std::size_t k = 0; k < spacings.size(); ++k) within[k] += d < spacings[k] * spacing ? 1 : 0;
        }
        for (double& share : within) share /= static_cast<double>(points.size());
        return within;
    };
    std::vector<double> ratio(spacings.size(), 0);
    for (int seed = 0; seed < seeds; ++seed) {
        const auto points = run(parts, Density::uniform(), {.sites = sites, .seed = static_cast<std::uint64_t>(seed)});
        const auto share = shares(points.points);
        for (std::size_t k = 0; k < spacings.size(); ++k) ratio[k] += share[k] / seeds;
    }
    // The share of the area is estimated from a stratified start with many sites.
    const auto area = shares(run(parts, Density::uniform(), {.sites = 30'000, .seed = 99, .iterations = 0}).points);
    for (std::size_t k = 0; k < spacings.size(); ++k) ratio[k] /= area[k];
    return ratio;
}

TEST(Distribute, CrowdsNoSitesAtTheBorderOfASquare) {
    for (const double ratio : crowding(kSquare, 4096, {1, 1.5, 2, 4}, 4)) EXPECT_NEAR(ratio, 1, 0.08);
}

TEST(Distribute, CrowdsNoSitesAtTheBorderOfACountry) {
    for (const char* name : {"South-Africa-50m.geojson", "Switzerland-10m.geojson"}) {
        for (const double ratio : crowding(test::read_geojson(name), 1024, {1.5, 2, 4}, 4)) {
            EXPECT_NEAR(ratio, 1, 0.15) << name;
        }
    }
}

/// Each site of the first row faces dozens of edges.
TEST(Distribute, CrowdsNoSitesAtABorderOfVeryShortEdges) {
    const Parts circle = {{test::circle({0, 0}, 1, 5000), {}}};
    for (const double ratio : crowding(circle, 1024, {1, 1.5, 2, 4}, 4)) EXPECT_NEAR(ratio, 1, 0.15);
}

/// The islands get from one site to most of the sites. After the start, sites cannot move between islands.
TEST(Distribute, GivesEachPartItsShare) {
    const std::vector<double> sides{10, 4, 3, 2, 1.5, 1, 0.7, 0.3};
    Parts parts;
    double area = 0, x = 0;
    for (const double side : sides) {
        parts.push_back({test::box(x, 0, side, side), {}});
        area += side * side;
        x += side + 0.05;
    }
    const Domain domain = test::domain_of(parts);
    constexpr std::size_t kSites = 800;
    for (const Quality quality : {Quality::Draft, Quality::Standard}) {
        for (const std::uint64_t seed : {1, 2, 3}) {
            const auto points =
                distribute(domain, Density::uniform(), {.sites = kSites, .seed = seed, .quality = quality})->points;
            double left = 0;
            for (std::size_t i = 0; i < sides.size(); ++i) {
                const auto count =
                    std::ranges::count_if(points, [&](Point p) { return p.x > left && p.x < left + sides[i]; });
                EXPECT_NEAR(static_cast<double>(count), kSites * sides[i] * sides[i] / area, 1) << sides[i];
                left += sides[i] + 0.05;
            }
        }
    }
}

/// Most of 400 equal islands have no site.
TEST(Distribute, SpreadsFewSitesOverManyParts) {
    constexpr int kSide = 20;
    Parts parts;
    for (int i = 0; i < kSide * kSide; ++i) parts.push_back({test::box(i % kSide, i / kSide, 0.8, 0.8), {}});
    const auto points = distribute(test::domain_of(parts), Density::uniform(), {.sites = 150})->points;
    for (int quarter = 0; quarter < 4; ++quarter) {
        const auto is_in_quarter = [&](double v) { return v >= 5 * quarter && v < 5 * quarter + 5; };
        EXPECT_NEAR(static_cast<double>(std::ranges::count_if(points, [&](Point p) { return is_in_quarter(p.x); })),
                    37.5, 2);
        EXPECT_NEAR(static_cast<double>(std::ranges::count_if(points, [&](Point p) { return is_in_quarter(p.y); })),
                    37.5, 2);
    }
}

}  // namespace
}  // namespace ccdt
