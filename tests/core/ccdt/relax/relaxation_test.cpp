// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/relax/relaxation.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/mesh/flips.h"
#include "core/mesh/insertion.h"
#include "core/mesh/inside.h"
#include "tests/support/meshes.h"
#include "tests/support/pictures.h"

namespace ccdt {
namespace {

using test::domain_of;
using test::grid_of;
using test::Parts;
using test::spot_and_corner;
using test::StartMesh;

const Parts kSquare{{test::box(0, 0, 1, 1), {}}};

struct Problem {
    Domain domain;
    Density density;
    Options options;
};

/// Runs iterations step by step and checks the invariants after each pass and each iteration.
void expect_descent(const Problem& problem) {
    StartMesh start(problem.domain, problem.density, problem.options);
    Relaxation relaxation(start.mesh, start.border.corner, problem.density.is_uniform(), {});
    for (int iteration = 0; iteration < problem.options.iterations; ++iteration) {
        start.measure();
        relaxation.prepare(start.goals);
        const double first = relaxation.energy();
        double before = first;
        for (int pass = 0; pass < problem.options.passes; ++pass) {
            relaxation.pass();
            const double after = relaxation.energy();
            ASSERT_LE(after, before * (1 + 1e-9)) << "iteration " << iteration << ", pass " << pass;
            before = after;
        }
        EXPECT_LE(before, first * (1 + 1e-12));
        ASSERT_EQ(test::count_inverted(start.mesh), 0u) << "iteration " << iteration;
        restore_delaunay(start.mesh);
        ASSERT_EQ(test::count_not_delaunay(start.mesh), 0u) << "iteration " << iteration;
        ASSERT_EQ(test::count_inverted(start.mesh), 0u) << "iteration " << iteration;
        ASSERT_EQ(test::count_bad_links(start.mesh), 0u) << "iteration " << iteration;
    }
}

TEST(Relaxation, DescendsOnASquare) {
    expect_descent({domain_of(kSquare), Density::uniform(), {.sites = 2000, .seed = 1}});
}

TEST(Relaxation, DescendsFromARandomStart) {
    expect_descent({domain_of(kSquare), Density::uniform(), {.sites = 2000, .seed = 2, .start = Start::Random}});
}

TEST(Relaxation, DescendsOnAPicture) {
    expect_descent({domain_of(kSquare), spot_and_corner(), {.sites = 2000, .seed = 3, .iterations = 8}});
}

TEST(Relaxation, DescendsWithWhiteAreas) {
    const Density half = grid_of(64, 64, [](int i, int) { return i < 32 ? 0.0 : 1.0; });
    expect_descent({domain_of(kSquare), half, {.sites = 1000, .seed = 4}});
}

TEST(Relaxation, DescendsInCountries) {
    for (const char* name : {"Italy-110m.geojson", "South-Africa-50m.geojson", "Switzerland-10m.geojson"}) {
        SCOPED_TRACE(name);
        expect_descent({domain_of(test::read_geojson(name)), Density::uniform(), {.sites = 1000, .seed = 5}});
    }
}

TEST(Relaxation, DescendsBetweenHoles) {
    expect_descent({domain_of({test::sieve(6)}), Density::uniform(), {.sites = 1000, .seed = 6}});
}

TEST(Relaxation, DescendsWithFewSites) {
    for (const std::size_t sites : {1, 2, 3, 10}) {
        SCOPED_TRACE(sites);
        expect_descent({domain_of(kSquare), Density::uniform(), {.sites = sites, .seed = sites, .iterations = 10}});
        expect_descent({domain_of({{test::l_shape(), {}}}), Density::uniform(), {.sites = sites, .seed = sites}});
    }
}

TEST(Relaxation, DescendsAroundATorus) {
    for (const std::size_t sites : {1, 2, 3, 7, 2000}) {
        SCOPED_TRACE(sites);
        expect_descent({Domain::torus(1, 1).value(), Density::uniform(), {.sites = sites, .seed = 7}});
        expect_descent({Domain::torus(3, 4).value(), spot_and_corner(), {.sites = sites, .seed = 8, .iterations = 8}});
    }
}

/// Returns the positions of vertices after some iterations, with two sites moved at once or one by one.
std::vector<Point> relaxed(const Domain& domain, const Density& density, std::size_t sites, bool by_two) {
    StartMesh start(domain, density, {.sites = sites, .seed = 4});
    RelaxationOptions options;
    options.by_two = by_two;
    Relaxation relaxation(start.mesh, start.border.corner, density.is_uniform(), options);
    for (int iteration = 0; iteration < 3; ++iteration) {
        start.measure();
        relaxation.prepare(start.goals);
        for (int pass = 0; pass < 5; ++pass) relaxation.pass();
        restore_delaunay(start.mesh);
    }
    return start.mesh.points();
}

TEST(Relaxation, MovesTwoSitesAtOnceAsInSequence) {
    for (const std::size_t sites : {1, 2, 5, 9, 64, 700, 6000}) {
        SCOPED_TRACE(sites);
        for (const Density& density : {Density::uniform(), spot_and_corner()}) {
            for (const Domain& domain : {domain_of(kSquare), Domain::torus(1, 1).value()})
                EXPECT_EQ(relaxed(domain, density, sites, true), relaxed(domain, density, sites, false));
        }
    }
}

/// Returns the variation after 12 iterations. If `exact`, the last 8 use exact passes.
double reached(const Domain& domain, const Density& density, bool exact) {
    StartMesh start(domain, density, {.sites = 2000, .seed = 3});
    Relaxation relaxation(start.mesh, start.border.corner, false, {});
    for (int iteration = 0; iteration < 12; ++iteration) {
        start.measure();
        const bool is_exact = exact && iteration >= 4;
        if (is_exact) {
            relaxation.prepare_exact(start.goals);
            relaxation.measure(start.capacity);
        } else {
            relaxation.prepare(start.goals);
        }
        for (int pass = 0; pass < 5; ++pass) {
            if (is_exact) {
                relaxation.exact_pass();
            } else {
                relaxation.pass();
            }
            EXPECT_EQ(test::count_inverted(start.mesh), 0u) << "iteration " << iteration;
        }
        restore_delaunay(start.mesh);
        EXPECT_EQ(test::count_inverted(start.mesh), 0u) << "iteration " << iteration;
        EXPECT_EQ(test::count_not_delaunay(start.mesh), 0u) << "iteration " << iteration;
        EXPECT_EQ(test::count_bad_links(start.mesh), 0u) << "iteration " << iteration;
    }
    return start.measure();
}

TEST(Relaxation, DoesNotStallNextToWhiteInExactPasses) {
    for (const Domain& domain : {domain_of(kSquare), Domain::torus(1, 1).value()}) {
        SCOPED_TRACE(domain.is_torus() ? "torus" : "box");
        EXPECT_LT(reached(domain, test::pear(), true), 0.07);
        EXPECT_GT(reached(domain, test::pear(), false), 0.1);
    }
}

TEST(Relaxation, KeepsExactPassesInsideTheBorder) {
    // The density ends within the domain, along a curve that meets the border.
    const Density cut = grid_of(80, 80, [](int i, int j) { return std::hypot(i, j - 40) < 30 ? 1.0 : 0.0; });
    EXPECT_LT(reached(domain_of(kSquare), cut, true), 0.06);
    EXPECT_GT(reached(domain_of(kSquare), cut, false), 0.1);
}

TEST(Relaxation, RestsAtTheMinimumOfExactPasses) {
    // A uniform density given as a grid: an exact pass equals a plain one without over-relaxation.
    const Density one = grid_of(20, 20, [](int, int) { return 1.0; });
    StartMesh start(domain_of(kSquare), one, {.sites = 120, .seed = 10});
    start.measure();
    Relaxation relaxation(start.mesh, start.border.corner, false, {});
    relaxation.prepare(start.goals);
    for (int pass = 0; pass < 20'000; ++pass) relaxation.pass();
    const auto rest = start.mesh.points();
    relaxation.prepare_exact(start.goals);
    relaxation.measure(start.capacity);
    relaxation.exact_pass();
    for (std::size_t v = 0; v < rest.size(); ++v) {
        EXPECT_NEAR(start.mesh.points()[v].x, rest[v].x, 1e-9);
        EXPECT_NEAR(start.mesh.points()[v].y, rest[v].y, 1e-9);
    }
}

TEST(Relaxation, MovesASingleSiteToTheCentre) {
    const Domain domain = domain_of(kSquare);
    Triangulation mesh = mesh_of_border(1, triangulate(bare_border(domain)).value());
    ASSERT_TRUE(insert_site(mesh, 0, {0.3, 0.8}));
    trim(mesh);
    Relaxation relaxation(mesh, std::vector<bool>(4, true), false, {});
    relaxation.prepare(std::vector<TriangleGoal>(4, TriangleGoal{2, 1}));
    for (int pass = 0; pass < 60; ++pass) relaxation.pass();
    EXPECT_NEAR(mesh.point(0).x, 0.5, 1e-9);
    EXPECT_NEAR(mesh.point(0).y, 0.5, 1e-9);
}

TEST(Relaxation, DividesASquareByItsTargets) {
    // Triangles over opposite edges always add up to half the square, so x and y can be chosen independently.
    const Domain domain = domain_of(kSquare);
    Triangulation mesh = mesh_of_border(1, triangulate(bare_border(domain)).value());
    ASSERT_TRUE(insert_site(mesh, 0, {0.5, 0.5}));
    trim(mesh);
    std::vector<TriangleGoal> goals(4);
    const Point wanted{0.375, 0.75};
    for (std::uint32_t t = 0; t < 4; ++t) {
        Point sum;
        for (const std::uint32_t v : mesh.corners(t)) sum = sum + mesh.point(v);
        const double height = sum.y < 1 ? wanted.y : sum.y > 2 ? 1 - wanted.y : sum.x < 1 ? wanted.x : 1 - wanted.x;
        goals[t] = {1, height};
    }
    Relaxation relaxation(mesh, std::vector<bool>(4, true), false, {.spring = 0, .border_spring = 0});
    relaxation.prepare(goals);
    for (int pass = 0; pass < 60; ++pass) relaxation.pass();
    EXPECT_NEAR(mesh.point(0).x, wanted.x, 1e-9);
    EXPECT_NEAR(mesh.point(0).y, wanted.y, 1e-9);
    EXPECT_NEAR(relaxation.energy(), 0, 1e-15);
}

/// Returns the height at which a site in a unit square comes to rest. The target of the upper edge, which is one piece,
/// requires 0.4. The targets of the lower edge, which is divided into pieces, require 0.2.
double height_above_pieces(std::size_t pieces) {
    Ring ring;
    for (std::size_t i = 0; i < pieces; ++i) ring.push_back({static_cast<double>(i) / static_cast<double>(pieces), 0});
    ring.insert(ring.end(), {{1, 0}, {1, 1}, {0, 1}});
    const Domain domain = domain_of({{ring, {}}});
    Triangulation mesh = mesh_of_border(1, triangulate(bare_border(domain)).value());
    EXPECT_TRUE(insert_site(mesh, 0, {0.5, 0.5}));
    trim(mesh);
    std::vector<TriangleGoal> goals(mesh.triangle_count());
    for (std::uint32_t t = 0; t < goals.size(); ++t) {
        double width = 0;
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Triangulation::edge(t, i);
            if (mesh.twin(h) == Triangulation::kNone) width = mesh.along(h).x;
        }
        const double height = width > 0 ? 0.2 : 0.6, share = std::abs(width);
        // Triangles on the other sides have weight 0.
        goals[t] = share > 0 ? TriangleGoal{1, height * share, share} : TriangleGoal{0, 0};
    }
    Relaxation relaxation(mesh, std::vector<bool>(ring.size(), true), false, {.border_spring = 0});
    relaxation.prepare(goals);
    for (int pass = 0; pass < 100; ++pass) relaxation.pass();
    return mesh.point(0).y;
}

TEST(Relaxation, CountsAFanAsOneTriangle) {
    const double whole = height_above_pieces(1);
    EXPECT_NEAR(whole, 0.3, 0.02);
    EXPECT_NEAR(height_above_pieces(3), whole, 0.02);
    EXPECT_NEAR(height_above_pieces(40), whole, 0.02);
}

TEST(Relaxation, KeepsVerticesOnTheBorder) {
    const Domain domain = domain_of(kSquare);
    StartMesh start(domain, Density::uniform(), {.sites = 500, .seed = 8});
    start.measure();
    const auto before = start.mesh.points();
    Relaxation relaxation(start.mesh, start.border.corner, true, {});
    relaxation.prepare(start.goals);
    for (int pass = 0; pass < 5; ++pass) relaxation.pass();
    std::size_t slid = 0;
    for (std::size_t v = 500; v < before.size(); ++v) {
        const Point p = start.mesh.points()[v];
        if (start.border.corner[v - 500]) {
            EXPECT_EQ(p, before[v]);
        } else {
            EXPECT_LT(std::min({std::abs(p.x), std::abs(1 - p.x), std::abs(p.y), std::abs(1 - p.y)}), 1e-15);
        }
        slid += p != before[v] ? 1 : 0;
    }
    EXPECT_GT(slid, 20u) << "vertices on straight borders slide";
}

TEST(Relaxation, MovesNothingWithoutWeight) {
    StartMesh start(domain_of(kSquare), Density::uniform(), {.sites = 100, .seed = 9});
    const auto before = start.mesh.points();
    Relaxation relaxation(start.mesh, start.border.corner, false, {});
    relaxation.prepare(std::vector<TriangleGoal>(start.mesh.triangle_count(), TriangleGoal{0, 1}));
    relaxation.pass();
    EXPECT_EQ(start.mesh.points(), before);
}

/// Both record layouts, the plain one and the one with a goal for each triangle, solve the same equations. So the
/// resting positions of one are resting positions of the other.
TEST(Relaxation, ConvergesToTheSamePositionsOnAllPaths) {
    StartMesh start(domain_of(kSquare), Density::uniform(), {.sites = 120, .seed = 10});
    start.measure();
    Relaxation plain(start.mesh, start.border.corner, true, {});
    plain.prepare(start.goals);
    for (int pass = 0; pass < 20'000; ++pass) plain.pass();
    const auto rest = start.mesh.points();

    Relaxation general(start.mesh, start.border.corner, false, {});
    general.prepare(start.goals);
    EXPECT_NEAR(general.energy(), plain.energy(), 1e-12 * plain.energy());
    general.pass();
    for (std::size_t v = 0; v < rest.size(); ++v) {
        EXPECT_NEAR(start.mesh.points()[v].x, rest[v].x, 1e-9);
        EXPECT_NEAR(start.mesh.points()[v].y, rest[v].y, 1e-9);
    }
}

}  // namespace
}  // namespace ccdt
