// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/voronoi_cells.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "core/baselines/site_mesh.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::domain_of;
using test::grid_of;

struct Cells {
    std::vector<Point> sites;
    std::vector<Moments> moments;

    double mass() const {
        return std::accumulate(moments.begin(), moments.end(), 0.0,
                               [](double sum, const Moments& m) { return sum + m.mass; });
    }
};

Cells cells_of(const Domain& domain, const Density& density, std::size_t sites, Start start = Start::Random) {
    const auto mesh = SiteMesh::create(domain, density, {.sites = sites, .seed = sites, .start = start}, {}).value();
    const std::vector<Point> positions(mesh.sites().begin(), mesh.sites().end());
    return {positions, VoronoiCells(domain, mesh.mesh(), density).integrate(positions, {})};
}

TEST(VoronoiCells, FillTheDomain) {
    for (const std::size_t sites : {1, 2, 3, 50, 2000}) {
        for (const Domain& domain :
             {Domain::rectangle(3, 2).value(), Domain::torus(3, 2).value(), Domain::torus(1, 1000).value(),
              domain_of({{test::u_shape(), {}}}), domain_of({test::sieve(4)}),
              domain_of(test::read_geojson("South-Africa-50m.geojson"))}) {
            EXPECT_NEAR(cells_of(domain, Density::uniform(), sites).mass(), domain.unit_area(),
                        1e-12 * domain.unit_area());
        }
    }
}

/// Returns for each site the sums over those points of a fine grid in the unit square that are nearest to it.
std::vector<Moments> sums_of(const std::vector<Point>& sites, const Density& density, bool around) {
    constexpr int kPositions = 1000;
    std::vector<Moments> sums(sites.size());
    for (int j = 0; j < kPositions; ++j) {
        for (int i = 0; i < kPositions; ++i) {
            const Point position{(i + 0.5) / kPositions, (j + 0.5) / kPositions};
            std::size_t nearest = 0;
            Point shortest{2, 2};
            for (std::size_t s = 0; s < sites.size(); ++s) {
                Point way = position - sites[s];
                if (around) way = {way.x - std::round(way.x), way.y - std::round(way.y)};
                if (dot(way, way) >= dot(shortest, shortest)) continue;
                nearest = s;
                shortest = way;
            }
            const double value = density.is_uniform() ? 1
                                                      : density.value(static_cast<int>(position.x * density.width()),
                                                                      static_cast<int>(position.y * density.height()));
            sums[nearest].mass += value * value;
            sums[nearest].first = sums[nearest].first + value * value * shortest;
        }
    }
    return sums;
}

TEST(VoronoiCells, ContainThePointsNearestToTheirSites) {
    const Density steps = grid_of(8, 5, [](int i, int j) { return 1.0 + i * j; });
    for (const bool around : {false, true}) {
        const Domain domain = (around ? Domain::torus(1, 1) : Domain::rectangle(1, 1)).value();
        for (const Density& density : {Density::uniform(), steps}) {
            for (const std::size_t sites : {1, 2, 5, 40}) {
                const Cells found = cells_of(domain, density, sites);
                const auto expected = sums_of(found.sites, density, around);
                double total = 0;
                for (const Moments& m : expected) total += m.mass;
                const double scale = found.mass() / total;
                for (std::size_t s = 0; s < sites; ++s) {
                    const double mass = scale * expected[s].mass, limit = 2e-3 * found.mass() / std::sqrt(sites);
                    EXPECT_NEAR(found.moments[s].mass, mass, limit) << sites << ", " << s;
                    EXPECT_NEAR(found.moments[s].first.x, scale * expected[s].first.x, limit) << sites << ", " << s;
                    EXPECT_NEAR(found.moments[s].first.y, scale * expected[s].first.y, limit) << sites << ", " << s;
                }
            }
        }
    }
}

TEST(VoronoiCells, AreClippedAtTheBorder) {
    const Domain half = domain_of({{{{0, 0}, {1, 0}, {1, 1}}, {}}});
    const Density uniform = Density::uniform();
    const auto mesh = SiteMesh::create(half, uniform, {.sites = 2}, {}).value();
    const std::vector<Point> sites{{0.3, 0.1}, {0.7, 0.1}};
    const auto cells = VoronoiCells(half, mesh.mesh(), uniform).integrate(sites, {});
    EXPECT_NEAR(cells[0].mass, 0.125, 1e-12);
    EXPECT_NEAR(cells[1].mass, 0.375, 1e-12);
    // The centroid of the first cell is (1/3, 1/6).
    EXPECT_NEAR(cells[0].first.x, 0.125 * (1.0 / 3 - 0.3), 1e-12);
    EXPECT_NEAR(cells[0].first.y, 0.125 * (1.0 / 6 - 0.1), 1e-12);
}

TEST(VoronoiCells, AreAccurateFarFromAllSites) {
    const Density spot = grid_of(500, 500, [](int i, int j) { return i / 5 == 50 && j / 5 == 40 ? 1.0 : 1e-5; });
    const Domain square = Domain::rectangle(1, 1).value();
    const double mass = cells_of(square, spot, 500).mass();
    EXPECT_NEAR(mass, cells_of(square, spot, 1).mass(), 1e-9 * mass);
}

TEST(VoronoiCells, StopOnRequest) {
    const Domain square = Domain::rectangle(1, 1).value();
    const Density uniform = Density::uniform();
    const auto mesh = SiteMesh::create(square, uniform, {.sites = 20'000}, {}).value();
    std::stop_source stop;
    stop.request_stop();
    const auto cells = VoronoiCells(square, mesh.mesh(), uniform).integrate(mesh.sites(), stop.get_token());
    const double mass =
        std::accumulate(cells.begin(), cells.end(), 0.0, [](double sum, const Moments& m) { return sum + m.mass; });
    EXPECT_LT(mass, 0.5);
}

}  // namespace
}  // namespace ccdt
