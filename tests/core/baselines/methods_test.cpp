// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "core/baselines/ccvt.h"
#include "core/baselines/cvt.h"
#include "core/baselines/odt.h"
#include "core/baselines/random_sites.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::domain_of;
using test::grid_of;
using test::Parts;

const Parts kSquare{{test::box(0, 0, 1, 1), {}}};

struct Baseline {
    std::string name;
    decltype(&distribute) run;
    bool iterates = true;
};

std::vector<Baseline> baselines() {
    return {{"cvt", cvt}, {"odt", odt}, {"ccvt", ccvt}, {"random", random_sites, false}};
}

/// Contract of all methods. The parameter is the number of a method.
class Baselines : public testing::TestWithParam<std::size_t> {
protected:
    Result<Distribution> run(const Domain& domain, const Density& density, const Options& options,
                             const Control& control = {}) const {
        return method_.run(domain, density, options, control);
    }

    const Baseline method_ = baselines()[GetParam()];
    const Domain square_ = Domain::rectangle(1, 1).value();
    const Domain torus_ = Domain::torus(1, 1).value();
};

INSTANTIATE_TEST_SUITE_P(Methods, Baselines, testing::Range(std::size_t{0}, baselines().size()),
                         [](const auto& index) { return baselines()[index.param].name; });

std::vector<std::pair<std::string, Density>> densities() {
    return {{"uniform", Density::uniform()},
            {"ramp", grid_of(16, 16, [](int i, int) { return i + 0.5; })},
            {"half white", grid_of(64, 64, [](int i, int) { return i < 32 ? 0.0 : 1.0; })},
            {"one pixel", grid_of(64, 64, [](int i, int j) { return i == 40 && j == 20 ? 1.0 : 0.0; })},
            {"extreme", grid_of(16, 16, [](int i, int j) { return std::pow(10.0, (7 * i + 5 * j) % 24 - 12); })}};
}

TEST_P(Baselines, PlaceAllSitesStrictlyInside) {
    const Parts lshape{{test::l_shape(), {}}};
    const std::vector<std::pair<std::string, Parts>> positions = {
        {"square", kSquare},
        {"L", lshape},
        {"U", {{test::u_shape(), {}}}},
        {"thin parallelogram", {{{{0, 0}, {1, 0.7}, {1, 0.71}, {0, 0.01}}, {}}}},
        {"needle", {{{{0, 0}, {1, 0}, {0.5, 0.02}}, {}}}},
        {"sliver", {{test::box(0, 0, 1, 1e-8), {}}}},
        {"needles", {{test::star({0, 0}, 1, 0.05, 24), {}}}},
        {"island in a hole", {{test::box(0, 0, 8, 8), {test::box(2, 2, 4, 4)}}, {test::box(3, 3, 1, 1), {}}}},
        {"far from the origin", test::moved(test::scaled(lshape, 64), {5e6, 4.5e6})},
        {"Switzerland", test::read_geojson("Switzerland-10m.geojson")}};
    for (const auto& [position, parts] : positions) {
        const Domain domain = domain_of(parts);
        for (const auto& [name, density] : densities()) {
            for (const std::size_t sites : {1, 2, 3, 10, 100}) {
                const auto result = run(domain, density, {.sites = sites, .seed = 7 * sites, .iterations = 4});
                if (!result) {
                    EXPECT_EQ(result.error().code, ErrorCode::Unusable) << position << ", " << name;
                    EXPECT_NE(name, "uniform") << position << ": " << result.error().message;
                    continue;
                }
                EXPECT_EQ(result->points.size(), sites);
                EXPECT_EQ(test::count_outside(parts, result->points), 0u) << position << ", " << name << ", " << sites;
                EXPECT_EQ(test::count_distinct(result->points), sites) << position << ", " << name << ", " << sites;
                EXPECT_EQ(result->trace.size(), static_cast<std::size_t>(result->iterations) + 1);
                for (const double variation : result->trace) EXPECT_TRUE(std::isfinite(variation)) << position << name;
            }
        }
    }
}

TEST_P(Baselines, PlaceAllSitesOnATorus) {
    for (const Point sides : {Point{1, 1}, Point{3, 2}, Point{1e-3, 0.5}}) {
        const Domain torus = Domain::torus(sides.x, sides.y).value();
        for (const auto& [name, density] : densities()) {
            for (const std::size_t sites : {1, 2, 3, 10, 100}) {
                const auto result = run(torus, density, {.sites = sites, .seed = sites, .iterations = 4});
                ASSERT_TRUE(result) << name << ", " << sites;
                EXPECT_EQ(test::count_distinct(result->points), sites) << name << ", " << sites;
                for (const Point& p : result->points) {
                    EXPECT_TRUE(p.x >= 0 && p.y >= 0 && p.x < sides.x && p.y < sides.y) << p.x << " " << p.y;
                }
            }
        }
    }
}

TEST_P(Baselines, AreDeterministicForASeed) {
    const Density ramp = densities()[1].second;
    for (const Domain& domain : {square_, torus_}) {
        const Options options{.sites = 200, .seed = 11, .iterations = 5};
        const auto points = run(domain, ramp, options)->points;
        EXPECT_EQ(run(domain, ramp, options)->points, points);
        EXPECT_NE(run(domain, ramp, {.sites = 200, .seed = 12, .iterations = 5})->points, points);
    }
}

TEST_P(Baselines, DependOnRatiosOfTheDensityOnly) {
    const Density ramp = grid_of(16, 16, [](int i, int j) { return 1.0 + i * j; });
    const Density scaled = grid_of(16, 16, [](int i, int j) { return 0x1p40 * (1.0 + i * j); });
    const Options options{.sites = 200, .seed = 4, .iterations = 5};
    EXPECT_EQ(run(square_, ramp, options)->points, run(square_, scaled, options)->points);
}

/// Returns the shares of points in four vertical strips, from left to right.
std::vector<double> quarters(const std::vector<Point>& points) {
    std::vector<double> shares(4, 0);
    for (const Point& p : points) shares[static_cast<std::size_t>(4 * p.x)] += 1 / static_cast<double>(points.size());
    return shares;
}

TEST_P(Baselines, FollowTheDensity) {
    // Moments weighted by the density, not by its square, would give the shares a sixth and a third.
    const Density steps = grid_of(64, 64, [](int i, int) { return i < 16 || i >= 48 ? 1.0 : 4.0; });
    const std::vector<double> wanted{0.1, 0.4, 0.4, 0.1};
    for (const Domain& domain : {square_, torus_}) {
        std::vector<double> shares(4, 0);
        for (std::uint64_t seed = 0; seed < 3; ++seed) {
            const auto found = quarters(run(domain, steps, {.sites = 200, .seed = seed, .iterations = 60})->points);
            for (std::size_t i = 0; i < 4; ++i) shares[i] += found[i] / 3;
        }
        for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(shares[i], wanted[i], 0.03) << i;
    }
}

double distance_around(Point a, Point b) {
    const Point way = a - b;
    return std::hypot(way.x - std::round(way.x), way.y - std::round(way.y));
}

/// Returns the mean distance to the nearest other point, over all points for which `which` is true.
template <class Which>
double mean_nearest(const std::vector<Point>& points, Which&& which) {
    double sum = 0, count = 0;
    for (const Point& p : points) {
        if (!which(p)) continue;
        double nearest = std::numeric_limits<double>::infinity();
        for (const Point& q : points) {
            if (p != q) nearest = std::min(nearest, distance_around(p, q));
        }
        sum += nearest;
        count += 1;
    }
    return sum / count;
}

TEST_P(Baselines, HaveNoSeamOnATorus) {
    const auto near_seam = [](Point p) { return std::min({p.x, p.y, 1 - p.x, 1 - p.y}) < 0.04; };
    double at_seam = 0, all = 0, share = 0;
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
        const auto points = run(torus_, Density::uniform(), {.sites = 400, .seed = seed, .iterations = 30})->points;
        at_seam += mean_nearest(points, near_seam) / 8;
        all += mean_nearest(points, [](Point) { return true; }) / 8;
        share += static_cast<double>(std::ranges::count_if(points, near_seam)) / 400 / 8;
    }
    EXPECT_NEAR(at_seam, all, (method_.iterates ? 0.03 : 0.15) * all);
    EXPECT_NEAR(share, 1 - 0.92 * 0.92, 0.015);
}

TEST_P(Baselines, KeepADelaunayMeshIfAsked) {
    const Options options{.sites = 300, .seed = 2, .iterations = 5, .keep_mesh = true};
    const auto plane = run(domain_of({{test::box(0, 0, 4, 4), {test::box(1, 1, 2, 2)}}}), Density::uniform(), options);
    const TriangleMesh& mesh = plane->mesh.value();
    EXPECT_EQ(mesh.boundary.size(), 2u);
    EXPECT_TRUE(std::equal(plane->points.begin(), plane->points.end(), mesh.vertices.begin()));
    double area = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        area += cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]) / 2;
    }
    EXPECT_NEAR(area, 12, 1e-9);
    const auto around = run(torus_, Density::uniform(), options);
    EXPECT_EQ(around->mesh->triangles.size(), 600u);
    EXPECT_EQ(around->mesh->vertices, around->points);
    EXPECT_TRUE(around->mesh->boundary.empty());
    EXPECT_FALSE(run(square_, Density::uniform(), {.sites = 10, .iterations = 1})->mesh);
}

TEST_P(Baselines, RefuseOptionsOutOfRange) {
    const auto expect_refused = [&](const Options& options, const std::string& field) {
        const auto result = run(square_, Density::uniform(), options);
        ASSERT_FALSE(result) << field;
        EXPECT_EQ(result.error().code, ErrorCode::Malformed);
        EXPECT_EQ(result.error().field, field);
    };
    expect_refused({}, "sites");
    expect_refused({.sites = 5, .tolerance = -1.0}, "tolerance");
    if (method_.iterates) expect_refused({.sites = 5, .iterations = -1}, "iterations");
}

TEST_P(Baselines, RefuseADensityOutsideTheDomain) {
    const Domain half = domain_of({{{{1, 0}, {1, 1}, {0, 1}}, {}}});
    const Density corner = grid_of(16, 16, [](int i, int j) { return i + j < 2 ? 1.0 : 0.0; });
    const auto result = run(half, corner, {.sites = 10});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Unusable);
    EXPECT_EQ(result.error().field, "density");
}

TEST_P(Baselines, EndAtTheTolerance) {
    const auto result = run(square_, Density::uniform(), {.sites = 400, .iterations = 100, .tolerance = 0.3});
    if (!method_.iterates) {
        EXPECT_EQ(result->iterations, 0);
        return;
    }
    EXPECT_LT(result->variation(), 0.3);
    EXPECT_GT(result->iterations, 0);
    EXPECT_GE(result->trace[result->trace.size() - 2], 0.3);
}

TEST_P(Baselines, ReportEachIteration) {
    std::vector<Progress> seen;
    Control control;
    control.progress = [&](const Progress& progress) { seen.push_back(progress); };
    const auto result = run(square_, Density::uniform(), {.sites = 200, .iterations = 3}, control);
    ASSERT_EQ(seen.size(), method_.iterates ? 4u : 1u);
    EXPECT_EQ(result->iterations, method_.iterates ? 3 : 0);
    for (std::size_t i = 0; i < seen.size(); ++i) {
        EXPECT_EQ(seen[i].iteration, static_cast<int>(i));
        EXPECT_EQ(seen[i].variation, result->trace[i]);
    }
}

TEST_P(Baselines, StopBetweenIterations) {
    std::stop_source source;
    Control control{.stop = source.get_token(), .progress = {}};
    control.progress = [&](const Progress& progress) {
        if (progress.iteration == (method_.iterates ? 2 : 0)) source.request_stop();
    };
    const auto result = run(square_, Density::uniform(), {.sites = 300, .iterations = 40}, control);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->stopped, method_.iterates);
    EXPECT_EQ(result->iterations, method_.iterates ? 2 : 0);
    EXPECT_EQ(test::count_outside(kSquare, result->points), 0u);
}

TEST_P(Baselines, StopBeforeTheStart) {
    std::stop_source source;
    source.request_stop();
    for (const std::size_t sites : {100, 5000}) {
        const auto result = run(square_, Density::uniform(), {.sites = sites, .iterations = 10},
                                Control{.stop = source.get_token(), .progress = {}});
        if (result) {
            EXPECT_EQ(result->iterations, 0);
            EXPECT_EQ(result->points.size(), sites);
        } else {
            EXPECT_EQ(result.error().code, ErrorCode::Stopped);
        }
    }
}

}  // namespace
}  // namespace ccdt
