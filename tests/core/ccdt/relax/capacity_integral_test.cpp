// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/relax/capacity_integral.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/mesh/insertion.h"
#include "core/mesh/inside.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::domain_of;
using test::grid_of;
using test::Parts;
using test::StartMesh;

/// Returns the triangulation of a domain with given sites.
Triangulation mesh_of(const Domain& domain, const std::vector<Point>& sites) {
    Triangulation mesh = mesh_of_border(sites.size(), triangulate(bare_border(domain)).value());
    for (std::uint32_t i = 0; i < sites.size(); ++i) EXPECT_TRUE(insert_site(mesh, i, sites[i])) << i;
    trim(mesh);
    return mesh;
}

std::vector<double> capacities_of(const CapacityIntegral& capacity, const Triangulation& mesh) {
    std::vector<double> capacities;
    capacity.of_triangles(mesh, capacities);
    return capacities;
}

double sum_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

const Parts kSquare{{test::box(0, 0, 1, 1), {}}};

TEST(CapacityIntegral, IsTheAreaForAUniformDensity) {
    const Domain domain = domain_of({{test::l_shape(), {}}});
    const Density uniform = Density::uniform();
    const CapacityIntegral capacity(domain, uniform);
    EXPECT_DOUBLE_EQ(capacity.total(), domain.unit_area());
    const Triangulation mesh = mesh_of(domain, {{0.2, 0.3}, {0.7, 0.2}});
    const auto capacities = capacities_of(capacity, mesh);
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        EXPECT_DOUBLE_EQ(capacities[t], mesh.doubled_area(t) / 2);
    }
    EXPECT_NEAR(sum_of(capacities), capacity.total(), 1e-15);
}

TEST(CapacityIntegral, IsTheAreaForASingleCell) {
    const Domain domain = domain_of({{test::u_shape(), {}}});
    const Density one = grid_of(1, 1, [](int, int) { return 3.0; });
    const CapacityIntegral capacity(domain, one);
    const Triangulation mesh = mesh_of(domain, {{0.1, 0.3}, {0.9, 0.6}});
    const auto capacities = capacities_of(capacity, mesh);
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        EXPECT_NEAR(capacities[t], one.value(0, 0) * mesh.doubled_area(t) / 2, 1e-15);
    }
}

TEST(CapacityIntegral, IsTheSumOfTheCellsOverTheBox) {
    const Domain domain = domain_of(kSquare);
    Random random(1, 0);
    const Density noise = grid_of(37, 53, [&](int, int) { return random.uniform(); });
    EXPECT_NEAR(CapacityIntegral(domain, noise).total(), noise.total(), 1e-12 * noise.total());
}

/// The ramp is sampled at cell centres, so its deviation from the linear function is of second order in the cell size.
TEST(CapacityIntegral, FollowsALinearRamp) {
    constexpr int kCells = 512;
    const Domain domain = domain_of(kSquare);
    const auto ramp = [](double x, double y) { return 0.25 + x + 2 * y; };
    const Density density =
        grid_of(kCells, kCells, [&](int i, int j) { return ramp((i + 0.5) / kCells, (j + 0.5) / kCells); });
    const double unit = density.largest() / ramp(1 - 0.5 / kCells, 1 - 0.5 / kCells);
    const CapacityIntegral capacity(domain, density);
    const Triangulation mesh = mesh_of(domain, {{0.31, 0.42}, {0.77, 0.13}, {0.52, 0.91}, {0.11, 0.86}});
    const auto capacities = capacities_of(capacity, mesh);
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.corners(t);
        const Point middle = (1.0 / 3) * (mesh.point(a) + mesh.point(b) + mesh.point(c));
        const double exact = unit * mesh.doubled_area(t) / 2 * ramp(middle.x, middle.y) * kCells * kCells;
        EXPECT_NEAR(capacities[t], exact, 1e-4 * exact);
    }
}

TEST(CapacityIntegral, IsExactWhereEdgesLieOnCellLines) {
    // Four cells of values 1/8, 1/4, 1/2 and 1 with a site at the centre: each triangle covers half of two cells.
    const Domain domain = domain_of(kSquare);
    const Density density = grid_of(2, 2, [](int i, int j) { return std::ldexp(1.0, i + 2 * j - 3); });
    const Triangulation mesh = mesh_of(domain, {{0.5, 0.5}});
    const auto capacities = capacities_of(CapacityIntegral(domain, density), mesh);
    ASSERT_EQ(capacities.size(), 4u);
    for (std::uint32_t t = 0; t < 4; ++t) {
        const auto [a, b, c] = mesh.corners(t);
        const Point sum = mesh.point(a) + mesh.point(b) + mesh.point(c);
        const double expected = sum.y < 1 ? 1.5 : sum.x > 2 - 1e-9 && sum.y < 2 ? 5 : sum.x < 1 ? 2.5 : 6;
        EXPECT_DOUBLE_EQ(8 * capacities[t], expected) << "triangle about " << sum.x / 3 << ' ' << sum.y / 3;
    }
}

TEST(CapacityIntegral, IsExactForTrianglesSmallerThanACell) {
    const Domain domain = domain_of(kSquare);
    Random random(3, 0);
    const Density density = grid_of(8, 8, [&](int, int) { return random.uniform(); });
    const CapacityIntegral capacity(domain, density);
    std::vector<Point> sites;  // all within one cell
    for (int i = 0; i < 100; ++i) sites.push_back({0.38 + 0.11 * random.uniform(), 0.63 + 0.11 * random.uniform()});
    const Triangulation mesh = mesh_of(domain, sites);
    const auto capacities = capacities_of(capacity, mesh);
    const double height = 64 * density.value(3, 5);
    int inner = 0;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto corners = mesh.corners(t);
        if (!std::all_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return mesh.is_site(v); })) continue;
        ++inner;
        EXPECT_NEAR(capacities[t], height * mesh.doubled_area(t) / 2, 1e-13 * density.total());
    }
    EXPECT_GT(inner, 100);
    EXPECT_NEAR(sum_of(capacities), capacity.total(), 1e-12 * capacity.total());
}

TEST(CapacityIntegral, RotatesWithItsDensity) {
    const Domain domain = domain_of(kSquare);
    const Density density = grid_of(5, 5, [](int i, int j) { return 1.0 + 3 * i + 7 * j; });
    const Density turned = grid_of(5, 5, [](int i, int j) { return 1.0 + 3 * j + 7 * (4 - i); });
    const Triangulation mesh = mesh_of(domain, {{0.3, 0.4}});
    const Triangulation turned_mesh = mesh_of(domain, {{1 - 0.4, 0.3}});
    auto before = capacities_of(CapacityIntegral(domain, density), mesh);
    auto after = capacities_of(CapacityIntegral(domain, turned), turned_mesh);
    std::sort(before.begin(), before.end());
    std::sort(after.begin(), after.end());
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(before[i], after[i], 1e-12 * density.total());
}

class CapacitySum : public testing::TestWithParam<int> {};

TEST_P(CapacitySum, IsTheTotal) {
    Random random(static_cast<std::uint64_t>(GetParam()), 5);
    const int width = 1 + static_cast<int>(90 * random.uniform()), height = 1 + static_cast<int>(90 * random.uniform());
    const int kind = GetParam() % 4;
    const Density density = grid_of(width, height, [&](int, int) {
        if (kind == 0) return random.uniform();
        if (kind == 1) return random.uniform() < 0.9 ? 0.0 : random.uniform();
        if (kind == 2) return std::pow(10.0, 24 * random.uniform() - 12);
        return 1.0;
    });
    std::vector<Parts> domains{kSquare, {test::sieve(4)}, {{test::star({0, 0}, 1, 0.3, 14), {}}}};
    for (const char* name : {"Italy-110m.geojson", "South-Africa-50m.geojson", "Switzerland-10m.geojson"}) {
        domains.push_back(test::read_geojson(name));
    }
    for (const Parts& parts : domains) {
        const Domain domain = domain_of(parts);
        for (const std::size_t sites : {1, 30, 2000}) {
            if (!(CapacityIntegral(domain, density).total() > 0)) continue;
            StartMesh start(domain, density, Options{.sites = sites, .seed = 7});
            start.measure();
            // Intermediate sums include the rest of each row, so the rounding error is relative to the whole grid.
            EXPECT_NEAR(sum_of(start.capacities), start.capacity.total(), 1e-12 * density.total());
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Grids, CapacitySum, testing::Range(0, 8));

TEST(CapacityIntegral, AddsUpWhereVerticesLieOnCellLines) {
    const Domain domain = domain_of(kSquare);
    Random random(9, 0);
    const Density density = grid_of(16, 16, [&](int, int) { return random.uniform(); });
    const CapacityIntegral capacity(domain, density);
    std::vector<Point> sites;
    for (int j = 1; j < 16; ++j) {
        for (int i = 1; i < 16; ++i) sites.push_back({i / 16.0, j / 16.0});
    }
    const Triangulation mesh = mesh_of(domain, sites);
    const auto capacities = capacities_of(capacity, mesh);
    EXPECT_NEAR(sum_of(capacities), density.total(), 1e-12 * density.total());
    // Triangles between sites are halves of cells.
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.corners(t);
        if (!mesh.is_site(a) || !mesh.is_site(b) || !mesh.is_site(c)) continue;
        const Point middle = (1.0 / 3) * (mesh.point(a) + mesh.point(b) + mesh.point(c));
        const double cell = density.value(static_cast<int>(middle.x * 16), static_cast<int>(middle.y * 16));
        EXPECT_NEAR(capacities[t], cell / 2, 1e-13 * density.total());
    }
}

/// To first order, a small move of a corner changes a triangle's capacity by the integrals that its edges sweep.
TEST(CapacityIntegral, ChangesByTheSweptIntegrals) {
    Random random(11, 0);
    const Density density = grid_of(24, 16, [&](int, int) { return random.uniform() < 0.3 ? 0.0 : random.uniform(); });
    for (const Domain& domain : {Domain::rectangle(3, 2).value(), Domain::torus(3, 2).value()}) {
        StartMesh start(domain, density, {.sites = 40, .seed = 12});
        Triangulation& mesh = start.mesh;
        std::vector<TriangleFlows> flows;
        start.capacity.of_edges(mesh, flows);
        const auto swept = [&](std::uint32_t h) {
            return flows[Triangulation::triangle_of(h)].swept[Triangulation::number_of(h)];
        };
        const auto measured = capacities_of(start.capacity, mesh);
        ASSERT_EQ(flows.size(), measured.size());
        for (std::size_t t = 0; t < flows.size(); ++t) EXPECT_EQ(flows[t].capacity, measured[t]);
        for (std::uint32_t v = 0; v < mesh.site_count(); ++v) {
            for (const Point by : {Point{0x1p-30, 0}, Point{0, 0x1p-30}}) {
                const Point here = mesh.point(v);
                mesh.points()[v] = here + by;
                const auto forth = capacities_of(start.capacity, mesh);
                mesh.points()[v] = here - by;
                const auto back = capacities_of(start.capacity, mesh);
                mesh.points()[v] = here;
                std::uint32_t h = mesh.edge_of(v);
                do {
                    const std::uint32_t t = Triangulation::triangle_of(h);
                    const std::uint32_t after = mesh.twin(Triangulation::previous(h));
                    // The first edge sweeps into the triangle, the second one out of it.
                    const double wanted =
                        swept(h) * -cross(mesh.along(h), by) + swept(after) * cross(mesh.along(after), by);
                    EXPECT_NEAR((forth[t] - back[t]) / 2, wanted, 1e-4 * density.total() * 0x1p-30) << v;
                    h = after;
                } while (h != mesh.edge_of(v));
            }
        }
    }
}

/// Returns all numbers that exact passes need.
std::vector<double> flows_of(const CapacityIntegral& capacity, const Triangulation& mesh) {
    std::vector<TriangleFlows> flows;
    capacity.of_edges(mesh, flows);
    std::vector<double> numbers;
    for (const TriangleFlows& flow : flows) {
        numbers.push_back(flow.capacity);
        numbers.insert(numbers.end(), flow.swept.begin(), flow.swept.end());
    }
    return numbers;
}

TEST(CapacityIntegral, IntegratesFourEdgesAtOnceAsTwo) {
    Random random(13, 0);
    const Density density = grid_of(37, 23, [&](int, int) { return random.uniform() < 0.3 ? 0.0 : random.uniform(); });
    for (const Domain& domain :
         {Domain::rectangle(3, 2).value(), Domain::torus(3, 2).value(), domain_of({{test::u_shape(), {}}})}) {
        for (const std::size_t sites : {1, 2, 3, 40, 3000}) {
            SCOPED_TRACE(sites);
            const StartMesh start(domain, density, {.sites = sites, .seed = 14});
            EXPECT_EQ(flows_of(CapacityIntegral(domain, density, true), start.mesh),
                      flows_of(CapacityIntegral(domain, density, false), start.mesh));
        }
    }
}

}  // namespace
}  // namespace ccdt
