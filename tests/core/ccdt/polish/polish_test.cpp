// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/polish.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/ccdt/relax/capacity_integral.h"
#include "core/mesh/flips.h"
#include "core/points/analysis/analysis.h"
#include "tests/support/evenness.h"
#include "tests/support/meshes.h"
#include "tests/support/pictures.h"

namespace ccdt {
namespace {

using test::count_inverted;
using test::count_on_white;
using test::domain_of;
using test::grid_of;
using test::Parts;
using test::spot_and_corner;
using test::StartMesh;

const Parts kSquare{{test::box(0, 0, 1, 1), {}}};

/// Returns a domain in its unit frame, with one ring as outer ring and all others as holes, for tests by the even-odd
/// rule.
Parts unit_parts(const Domain& domain) {
    const auto& rings = domain.rings();
    return {{rings[0], {rings.begin() + 1, rings.end()}}};
}

void expect_sound(const Domain& domain, const Density& density, std::size_t sites, const PolishSettings& settings) {
    StartMesh start(domain, density, {.sites = sites, .seed = sites});
    Triangulation& mesh = start.mesh;
    const Support support(domain, density);
    MeshPolish steps(domain, density, density.total(), sites, support);
    for (int round = 0; round < 4; ++round) {
        const auto before = mesh.points();
        Polish(domain, {{&steps, &mesh}}).refine(settings, {});
        ASSERT_EQ(count_inverted(mesh), 0u) << "round " << round;
        for (std::size_t v = sites; v < before.size(); ++v) ASSERT_EQ(mesh.points()[v], before[v]) << "border";
        EXPECT_TRUE(sites < 1000 || before != mesh.points()) << "nothing has moved";
        const std::vector<Point> at(mesh.points().begin(), mesh.points().begin() + static_cast<std::ptrdiff_t>(sites));
        if (domain.is_torus()) {
            for (const Point p : at) ASSERT_EQ(p, snapped(p));
        } else {
            EXPECT_EQ(test::count_outside(unit_parts(domain), at), 0u);
        }
        restore_delaunay(mesh);
        ASSERT_EQ(count_inverted(mesh), 0u) << "round " << round;
        ASSERT_EQ(test::count_not_delaunay(mesh), 0u) << "round " << round;
        ASSERT_EQ(test::count_bad_links(mesh), 0u) << "round " << round;
    }
}

TEST(Polish, KeepsTrianglesAndSitesInside) {
    const std::vector<std::pair<const char*, Domain>> domains{
        {"square", domain_of(kSquare)},
        {"strip", domain_of({{test::box(0, 0, 50, 1), {}}})},
        {"sieve", domain_of({test::sieve(5)})},
        {"needles", domain_of({{test::star({0, 0}, 1, 0.05, 24), {}}})},
        {"South Africa", domain_of(test::read_geojson("South-Africa-50m.geojson"))},
        {"Switzerland", domain_of(test::read_geojson("Switzerland-10m.geojson"))},
        {"torus", Domain::torus(1, 1).value()},
        {"long torus", Domain::torus(1, 40).value()}};
    const PolishSettings usual = polish_settings(Quality::Standard, 1, false);
    PolishSettings strong = usual;
    strong.rounds = 20;
    strong.reach = 1;
    strong.push = 0.5;
    for (const auto& [name, domain] : domains) {
        for (const std::size_t sites : {1, 2, 5, 50, 1000}) {
            SCOPED_TRACE(std::string(name) + ", " + std::to_string(sites));
            expect_sound(domain, Density::uniform(), sites, strong);
            expect_sound(domain, spot_and_corner(), sites, strong);
            expect_sound(domain, test::pear(), sites, usual);
        }
    }
}

/// Returns the standard deviation of site counts in 4 x 4 blocks of a square of side 32, relative to random sites.
double count_error(const std::vector<Point>& sites, Point corner) {
    constexpr int kBlocks = 4;
    std::vector<double> counts(kBlocks * kBlocks);
    double all = 0;
    for (const Point p : sites) {
        const Point g = (kBlocks / 32.0) * (p - corner);
        if (g.x < 0 || g.y < 0 || g.x >= kBlocks || g.y >= kBlocks) continue;
        ++counts[static_cast<std::size_t>(g.y) * kBlocks + static_cast<std::size_t>(g.x)];
        ++all;
    }
    double squares = 0;
    for (const double count : counts) squares += std::pow(count - all / (kBlocks * kBlocks), 2);
    return std::sqrt(squares / all);
}

TEST(Polish, EvensOutSmallSpots) {
    const Domain page = Domain::rectangle(512, 512).value();
    const Density spots = grid_of(512, 512, [](int i, int j) {
        return (i >= 20 && i < 52 && j >= 20 && j < 52) || (i >= 440 && i < 472 && j >= 441 && j < 473) ? 1.0 : 0.0;
    });
    const auto error = [&](Quality quality) {
        double sum = 0;
        for (const std::uint64_t seed : {1, 2, 3}) {
            Options options{.sites = 4000, .seed = seed, .quality = quality};
            options.keep_steps = false;  // as in halftones; otherwise, the start has the right number of sites
            const auto sites = distribute(page, spots, options)->points;
            sum += count_error(sites, {20, 20}) + count_error(sites, {440, 441});
        }
        return sum / 6;
    };
    const double draft = error(Quality::Draft);
    EXPECT_LT(error(Quality::Standard), 0.8 * draft);
    EXPECT_LT(error(Quality::Best), 0.8 * draft);
}

/// Few sites on a steep density drift together, but must stay near the box: shifts are exact only there.
TEST(Polish, KeepsPositionsNearTheBoxOfATorus) {
    const Domain torus = Domain::torus(1, 1).value();
    for (std::uint64_t seed = 3300; seed < 3340; ++seed) {
        Random random(seed, 0);
        const int width = 1 + static_cast<int>(6 * random.uniform()),
                  height = 1 + static_cast<int>(6 * random.uniform());
        const Density steep =
            grid_of(width, height, [&](int, int) { return std::pow(10.0, 12 * random.uniform() - 6); });
        StartMesh start(torus, steep, {.sites = 2 + seed % 4, .seed = seed});
        const Support support(torus, steep);
        MeshPolish steps(torus, steep, steep.total(), start.mesh.site_count(), support);
        PolishSettings settings = polish_settings(Quality::Standard, 1, false);
        settings.rounds = 20;
        Polish(torus, {{&steps, &start.mesh}}).refine(settings, {});
        for (const Point p : start.mesh.points()) {
            EXPECT_TRUE(std::abs(p.x) < 2 && std::abs(p.y) < 2) << "seed " << seed << ": " << p.x << ' ' << p.y;
        }
    }
}

/// All density is in one cell in a corner, far away from the sites.
TEST(Polish, ClearsGapsOfAnyProportions) {
    const Density corner = grid_of(10, 100, [](int i, int j) { return i + j == 0 ? 1.0 : 0.0; });
    for (const auto& [width, height] : {std::pair{20.0, 1.0}, {1.0, 1.0}, {1.0, 20.0}}) {
        for (const Domain& domain : {Domain::rectangle(width, height).value(), Domain::torus(width, height).value()}) {
            const Point sides = domain.unit_bounds().max;
            std::vector<Point> sites{{0.9 * sides.x, 0.5 * sides.y}, {0.05 * sides.x, 0.9 * sides.y}};
            const Support support(domain, corner);
            for (Point& p : sites) p = domain.to_user(support.nearest(p, 1));
            EXPECT_EQ(count_on_white(domain, corner, sites), 0u) << width << " x " << height;
        }
    }
}

TEST(Polish, MovesNothingAfterAStop) {
    std::stop_source source;
    source.request_stop();
    StartMesh start(domain_of(kSquare), spot_and_corner(), {.sites = 200, .seed = 1});
    const auto before = start.mesh.points();
    const Support support(start.domain, start.density);
    MeshPolish steps(start.domain, start.density, start.density.total(), 200, support);
    Polish(start.domain, {{&steps, &start.mesh}})
        .refine(polish_settings(Quality::Standard, 1, false), source.get_token());
    EXPECT_EQ(start.mesh.points(), before);
    std::vector<Point> sites(before.begin(), before.begin() + 200);
    const auto drawn = sites;
    steps.even_out_start(sites, source.get_token());
    EXPECT_EQ(sites, drawn);
}

Distribution run(const Domain& domain, const Density& density, const Options& options) {
    return distribute(domain, density, options).value();
}

TEST(Polish, LeavesNoSiteOnWhite) {
    struct Picture {
        const char* name;
        Density density;
        Domain domain;
    };
    const std::vector<Picture> pictures{{"pear", test::pear(), domain_of(kSquare)},
                                        {"lines", test::thin_lines(), domain_of(kSquare)},
                                        {"strokes", test::strokes(), Domain::rectangle(240, 120).value()},
                                        {"pear around a torus", test::pear(), Domain::torus(3, 3).value()}};
    for (const auto& [name, density, domain] : pictures) {
        for (std::uint64_t seed = 0; seed < 3; ++seed) {
            for (const std::size_t sites : {1, 30, 3000}) {
                for (const Quality quality : {Quality::Draft, Quality::Standard, Quality::Best}) {
                    const auto points = run(domain, density, {.sites = sites, .seed = seed, .quality = quality}).points;
                    EXPECT_EQ(count_on_white(domain, density, points), 0u) << name << ", " << sites;
                    EXPECT_EQ(test::count_distinct(points), sites) << name;
                }
            }
        }
    }
}

struct Pattern {
    double long_waves = 0;    ///< power below half the principal frequency
    double min_distance = 0;  ///< relative to the densest packing
};

Pattern pattern_of(const Domain& domain, Quality quality) {
    std::vector<std::vector<Point>> sets;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
        sets.push_back(run(domain, Density::uniform(), {.sites = 4096, .seed = seed, .quality = quality}).points);
    }
    const auto analysis = analyse(sets, domain, {.max_frequency = 1}).value();
    return {analysis.low_frequency_power.value(), analysis.min_distance};
}

TEST(Polish, LowersLongWavesAndKeepsNeighboursApart) {
    for (const Domain& domain : {Domain::torus(1, 1).value(), Domain::rectangle(1, 1).value()}) {
        const Pattern draft = pattern_of(domain, Quality::Draft), standard = pattern_of(domain, Quality::Standard),
                      best = pattern_of(domain, Quality::Best);
        SCOPED_TRACE(domain.is_torus() ? "torus" : "box");
        EXPECT_LT(standard.long_waves, 0.35 * draft.long_waves);
        EXPECT_LT(best.long_waves, 0.1 * draft.long_waves);
        EXPECT_GT(standard.min_distance, 1.12 * draft.min_distance);
        EXPECT_GT(best.min_distance, 1.12 * draft.min_distance);
    }
}

constexpr std::array kCountries{"Switzerland-10m.geojson", "South-Africa-50m.geojson", "Italy-110m.geojson"};

/// Results over two seeds.
struct Evenness {
    double variation = 0;  ///< mean over the seeds
    double noise = 0;      ///< in dB, largest of the seeds
    double nearest = 10;   ///< least distance of two sites
};

Evenness evenness_of(const Domain& domain, Quality quality, double blur) {
    Evenness found{0, -100, 10};
    for (const std::uint64_t seed : {1, 2}) {
        const auto placed = run(domain, Density::uniform(), {.sites = 4096, .seed = seed, .quality = quality});
        found.variation += placed.variation() / 2;
        found.noise = std::max(found.noise, test::noise(domain, placed.points, blur));
        found.nearest = std::min(found.nearest, test::sorted_distances(domain, placed.points).front());
    }
    return found;
}

TEST(Polish, EvensOutCountries) {
    for (const char* name : kCountries) {
        const Domain domain = domain_of(test::read_geojson(name));
        SCOPED_TRACE(name);
        for (const double blur : {1.0, 2.0}) {
            const double draft = evenness_of(domain, Quality::Draft, blur).noise;
            EXPECT_LT(evenness_of(domain, Quality::Standard, blur).noise, draft - 4 * blur);
            EXPECT_LT(evenness_of(domain, Quality::Best, blur).noise, draft - 6 * blur);
        }
    }
}

/// Capacities stay almost as equal as in drafts.
TEST(Polish, KeepsCountriesCapacities) {
    for (const char* name : kCountries) {
        const Domain domain = domain_of(test::read_geojson(name));
        SCOPED_TRACE(name);
        const double draft = evenness_of(domain, Quality::Draft, 1).variation;
        EXPECT_LT(evenness_of(domain, Quality::Standard, 1).variation, 1.03 * draft);
        EXPECT_LT(evenness_of(domain, Quality::Best, 1).variation, draft);
    }
}

TEST(Polish, LeavesNoNearPairsAtNeedles) {
    for (const char* name : kCountries) {
        const Domain domain = domain_of(test::read_geojson(name));
        EXPECT_GT(evenness_of(domain, Quality::Standard, 1).nearest, 0.7) << name;
        EXPECT_GT(evenness_of(domain, Quality::Best, 1).nearest, 0.7) << name;
    }
}

/// Islands are half as wide as the spacing, with narrower straits between them, so no edge joins sites of two islands.
TEST(Polish, KeepsSitesApartAcrossWater) {
    constexpr double kWidth = 0.01, kPeriod = 0.014;
    Parts islands;
    for (int i = 0; i < 5; ++i) islands.push_back({test::box(0, i * kPeriod, 1, kWidth), {}});
    const Domain domain = domain_of(islands);
    for (const Quality quality : {Quality::Standard, Quality::Best}) {
        std::ptrdiff_t near = 0;
        for (const std::uint64_t seed : {1, 2, 3, 4}) {
            const auto placed = run(domain, Density::uniform(), {.sites = 100, .seed = seed, .quality = quality});
            near += std::ranges::count_if(test::sorted_distances(domain, placed.points),
                                          [](double distance) { return distance < 0.7; });
        }
        EXPECT_LT(near, 30) << "about 200 without pushes across water";
    }
}

/// Most islands have one to four sites, so neighbours are across water, and no place has more space.
TEST(Polish, KeepsSitesOfSmallIslandsApart) {
    const Domain domain = domain_of(test::read_geojson("Norway-islands-10m.geojson"));
    for (const std::size_t sites : {10, 20, 30, 60}) {
        for (std::uint64_t seed = 1; seed <= 16; ++seed) {
            const auto placed = run(domain, Density::uniform(), {.sites = sites, .seed = seed});
            EXPECT_GT(test::sorted_distances(domain, placed.points).front(), 0.6) << sites << " sites, seed " << seed;
        }
    }
}

/// The density varies as slowly as on a chart of the globe. Checks the numbers of sites in strips, some spacings wide.
TEST(Polish, EvensOutSmoothDensities) {
    constexpr int kStrips = 10, kCells = 8 * kStrips;
    const Domain domain = domain_of(test::read_geojson("Switzerland-10m.geojson"));
    const auto value = [](int column) { return 1 + 0.9 * column / kCells; };
    const Density slope = grid_of(kCells, 1, [&](int column, int) { return value(column); }).smooth();
    const double all = CapacityIntegral(domain, slope).total();
    const auto error = [&](Quality quality) {
        double squares = 0;
        for (const std::uint64_t seed : {1, 2, 3, 4}) {
            const auto points = run(domain, slope, {.sites = 4096, .seed = seed, .quality = quality}).points;
            for (int strip = 0; strip < kStrips; ++strip) {
                const Density there =
                    grid_of(kCells, 1, [&](int i, int) { return i * kStrips / kCells == strip ? value(i) : 0.0; });
                const auto count = std::ranges::count_if(points, [&](Point p) {
                    return static_cast<int>((p.x - domain.bounds().min.x) / domain.bounds().width() * kStrips) == strip;
                });
                const double due = 4096 * CapacityIntegral(domain, there).total() / all;
                squares += std::pow(static_cast<double>(count) - due, 2);
            }
        }
        return std::sqrt(squares / (4 * kStrips));
    };
    EXPECT_LT(error(Quality::Standard), 0.85 * error(Quality::Draft));
    EXPECT_LT(error(Quality::Best), 0.85 * error(Quality::Draft));
}

TEST(Polish, IsDeterministic) {
    for (const Domain& domain : {Domain::torus(2, 1).value(), Domain::rectangle(2, 1).value()}) {
        for (const Quality quality : {Quality::Draft, Quality::Standard, Quality::Best}) {
            for (const Density& density : {Density::uniform(), test::pear()}) {
                const Options options{.sites = 1000, .seed = 6, .quality = quality};
                EXPECT_EQ(run(domain, density, options).points, run(domain, density, options).points);
            }
        }
    }
}

}  // namespace
}  // namespace ccdt
