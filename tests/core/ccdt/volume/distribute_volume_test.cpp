// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/distribute_volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numbers>
#include <span>
#include <stop_token>

#include <gtest/gtest.h>

#include "core/base/thread_executor.h"
#include "core/geometry/delaunay3.h"
#include "tests/support/solids.h"

namespace ccdt {
namespace {

constexpr BoxDomain3 kBox{}, kTorus{{1, 1, 1}, true};

VolumeDistribution distributed(const BoxDomain3& domain, const VolumeOptions& options,
                               const VoxelDensity& density = VoxelDensity::uniform()) {
    auto result = distribute_in_volume(domain, density, options);
    EXPECT_TRUE(result);
    return *result;
}

/// Distances of points to the nearest other point, relative to the densest packing.
struct Distances {
    double least = std::numeric_limits<double>::infinity();
    double mean = 0;
};

Distances distances(const BoxDomain3& domain, std::span<const Point3> points) {
    Distances result;
    const auto count = static_cast<double>(points.size());
    const double densest = std::pow(2, 1.0 / 6) * std::cbrt(domain.volume() / count);
    for (std::size_t i = 0; i < points.size(); ++i) {
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t j = 0; j < points.size(); ++j) {
            Point3 away = points[j] - points[i];
            if (domain.periodic) {
                away.x -= domain.sides.x * std::round(away.x / domain.sides.x);
                away.y -= domain.sides.y * std::round(away.y / domain.sides.y);
                away.z -= domain.sides.z * std::round(away.z / domain.sides.z);
            }
            if (j != i) nearest = std::min(nearest, dot(away, away));
        }
        result.least = std::min(result.least, std::sqrt(nearest) / densest);
        result.mean += std::sqrt(nearest) / densest / count;
    }
    return result;
}

/// Returns the mean power of the unit torus' waves below half the principal frequency of the densest packing, in dB.
double low_power(std::span<const Point3> points) {
    const auto count = static_cast<double>(points.size());
    const double end = std::sqrt(1.5) / std::pow(2, 1.0 / 6) * std::cbrt(count) / 2;
    const int highest = static_cast<int>(end);
    double sum = 0, waves = 0;
    for (int i = 0; i <= highest; ++i) {
        for (int j = -highest; j <= highest; ++j) {
            for (int k = -highest; k <= highest; ++k) {
                const double squared = i * i + j * j + k * k;
                if (squared == 0 || squared >= end * end) continue;
                std::complex<double> wave = 0;
                for (const Point3 p : points)
                    wave += std::polar(1.0, 2 * std::numbers::pi * (i * p.x + j * p.y + k * p.z));
                sum += std::norm(wave) / count;
                ++waves;
            }
        }
    }
    return 10 * std::log10(sum / waves);
}

double volume_of(const TetrahedronMesh& mesh, const BoxDomain3& domain) {
    double sum = 0;
    for (const auto& [a, b, c, d] : mesh.tetrahedra) {
        const auto from_a = [&, origin = mesh.vertices[a]](std::uint32_t corner) {
            Point3 away = mesh.vertices[corner] - origin;
            if (domain.periodic) {
                away.x -= domain.sides.x * std::round(away.x / domain.sides.x);
                away.y -= domain.sides.y * std::round(away.y / domain.sides.y);
                away.z -= domain.sides.z * std::round(away.z / domain.sides.z);
            }
            return away;
        };
        const double volume = dot(cross(from_a(b), from_a(c)), from_a(d)) / 6;
        EXPECT_GT(volume, 0);
        sum += volume;
    }
    return sum;
}

TEST(DistributeInVolume, KeepsPointsOfATorusApartAndEven) {
    for (const std::uint64_t seed : {1, 2}) {
        const VolumeDistribution result = distributed(kTorus, {.sites = 4096, .seed = seed});
        ASSERT_EQ(result.points.size(), 4096u);
        const Distances found = distances(kTorus, result.points);
        EXPECT_GT(found.least, 0.85);
        EXPECT_GT(found.mean, 0.865);
        EXPECT_LT(low_power(result.points), -40);
    }
}

TEST(DistributeInVolume, PutsTheirShareOfPointsOnBothSidesOfSteps) {
    constexpr std::size_t kVoxels = 24;
    const auto is_dense = [](std::size_t i) {
        const auto block = [](std::size_t v) { return v % kVoxels / 6 % 2 == 0; };
        return block(i) && block(i / kVoxels) && block(i / kVoxels / kVoxels);
    };
    for (const double low : {0.0, 1e-6, 0.1, 0.5}) {
        std::vector<double> values;
        double sparse = 0, all = 0;
        for (std::size_t i = 0; i < kVoxels * kVoxels * kVoxels; ++i) {
            values.push_back(is_dense(i) ? 1 : low);
            all += values.back();
            if (!is_dense(i)) sparse += low;
        }
        const VoxelDensity density = VoxelDensity::create({kVoxels, kVoxels, kVoxels}, values).value();
        for (const BoxDomain3& domain : {kBox, kTorus}) {
            for (const Quality quality : {Quality::Draft, Quality::Standard}) {
                const VolumeDistribution result = distributed(domain, {.sites = 1500, .quality = quality}, density);
                const auto found =
                    std::ranges::count_if(result.points, [&](Point3 p) { return !is_dense(density.voxel_at(p)); });
                const double exact = 1500 * sparse / all;
                EXPECT_NEAR(static_cast<double>(found), exact, low == 0 ? 0 : std::max(2.0, 0.02 * exact)) << low;
                EXPECT_GT(distances(domain, result.points).least, quality == Quality::Draft ? 0 : 0.4) << low;
            }
        }
    }
}

TEST(DistributeInVolume, PutsTheirShareOfPointsInThinLayersAndSmallBlocks) {
    constexpr std::size_t kVoxels = 16;
    const auto layer = [](std::size_t i) { return i / kVoxels % kVoxels / 2 == 3; };
    const auto block = [](std::size_t i) {
        return (i % kVoxels / 4 + i / kVoxels % kVoxels / 4 + i / kVoxels / kVoxels / 4) % 2 == 0;
    };
    for (const std::function<bool(std::size_t)>& is_dense : {std::function<bool(std::size_t)>(layer), {block}}) {
        for (const double low : {1e-6, 0.01, 0.1}) {
            std::vector<double> values;
            for (std::size_t i = 0; i < kVoxels * kVoxels * kVoxels; ++i) values.push_back(is_dense(i) ? 1 : low);
            const VoxelDensity density = VoxelDensity::create({kVoxels, kVoxels, kVoxels}, values).value();
            double sparse = 0, all = 0;
            for (std::size_t i = 0; i < values.size(); ++i) {
                all += values[i];
                if (!is_dense(i)) sparse += low;
            }
            for (const BoxDomain3& domain : {kBox, kTorus}) {
                for (const Quality quality : {Quality::Draft, Quality::Standard}) {
                    const VolumeDistribution result = distributed(domain, {.sites = 200, .quality = quality}, density);
                    const auto found =
                        std::ranges::count_if(result.points, [&](Point3 p) { return !is_dense(density.voxel_at(p)); });
                    EXPECT_NEAR(static_cast<double>(found), 200 * sparse / all, 2) << low;
                }
            }
        }
    }
}

TEST(DistributeInVolume, RemovesAllPowerOfLowFrequenciesForStealthy) {
    const VolumeDistribution result = distributed(kTorus, {.sites = 1000, .quality = Quality::Stealthy});
    EXPECT_LT(low_power(result.points), -100);
    EXPECT_GT(distances(kTorus, result.points).least, 0.85);
}

TEST(DistributeInVolume, EqualisesTetrahedraInADraft) {
    const VolumeDistribution result = distributed(kTorus, {.sites = 2000, .quality = Quality::Draft});
    ASSERT_EQ(result.trace.size(), 5u);
    EXPECT_GT(result.trace.front(), 0.6);
    EXPECT_LT(result.trace.back(), 0.22);
    EXPECT_LT(low_power(result.points), -15);
}

TEST(DistributeInVolume, KeepsTheFirstLayerHalfASpacingOffTheBorder) {
    const BoxDomain3 box{{2, 1, 1}, false};
    const VolumeDistribution result = distributed(box, {.sites = 4000});
    const double spacing = std::cbrt(box.volume() / 4000);
    std::size_t layer = 0;
    for (const Point3 p : result.points) {
        const double distance =
            std::min({p.x, box.sides.x - p.x, p.y, box.sides.y - p.y, p.z, box.sides.z - p.z}) / spacing;
        EXPECT_GT(distance, 0.3);
        if (distance < 0.75) ++layer;
    }
    // Number of points of a shell that is one layer of the densest packing thick, 0.917 spacings.
    const double thickness = 2 * 0.917 * spacing;
    const double shell = 2 - (2 - thickness) * (1 - thickness) * (1 - thickness);
    EXPECT_NEAR(static_cast<double>(layer), shell / 2 * 4000, 0.1 * shell / 2 * 4000);
    EXPECT_GT(distances(box, result.points).least, 0.77);
}

TEST(DistributeInVolume, GivesTheSameBytesForAnyNumberOfThreads) {
    ThreadExecutor threads(3);
    std::vector<double> values;
    for (int i = 0; i < 64; ++i) values.push_back(1 + i % 5);
    const VoxelDensity varying = *VoxelDensity::create({4, 4, 4}, values);
    for (const BoxDomain3& domain : {kBox, kTorus}) {
        for (const VoxelDensity& density : {VoxelDensity::uniform(), varying}) {
            const VolumeOptions options{.sites = 3000, .keep_mesh = true};
            const auto one = distribute_in_volume(domain, density, options);
            const auto three = distribute_in_volume(domain, density, options, {.executor = &threads});
            ASSERT_TRUE(one && three);
            EXPECT_EQ(one->points, three->points);
            EXPECT_EQ(one->trace, three->trace);
            EXPECT_EQ(one->mesh->tetrahedra, three->mesh->tetrahedra);
        }
    }
}

TEST(DistributeInVolume, ReturnsOtherPointsForOtherSeeds) {
    EXPECT_NE(distributed(kBox, {.sites = 10, .seed = 1}).points, distributed(kBox, {.sites = 10, .seed = 2}).points);
}

TEST(DistributeInVolume, ScalesWithTheDomain) {
    const VolumeOptions options{.sites = 300};
    for (const bool periodic : {false, true}) {
        const auto small = distributed({{1, 0.5, 0.25}, periodic}, options).points;
        const auto large = distributed({{1024, 512, 256}, periodic}, options).points;
        for (std::size_t i = 0; i < small.size(); ++i) EXPECT_EQ(1024 * small[i], large[i]);
    }
}

TEST(DistributeInVolume, HandlesFewPoints) {
    for (const BoxDomain3& domain : {kBox, kTorus, BoxDomain3{{3, 1, 0.5}, false}, BoxDomain3{{3, 1, 0.5}, true}}) {
        for (const std::size_t sites : {1, 2, 3, 5, 17}) {
            for (const Quality quality : {Quality::Draft, Quality::Stealthy}) {
                const auto result = distributed(domain, {.sites = sites, .quality = quality, .keep_mesh = true});
                ASSERT_EQ(result.points.size(), sites);
                for (const Point3 p : result.points) {
                    EXPECT_TRUE(p.x >= 0 && p.x < domain.sides.x && p.y >= 0 && p.y < domain.sides.y && p.z >= 0 &&
                                p.z < domain.sides.z);
                }
            }
        }
    }
}

TEST(DistributeInVolume, SpreadsSitesAlongTheLongSidesOfThinDomains) {
    for (const bool periodic : {false, true}) {
        for (const double thickness : {1e-3, 1e-7, 1e-200}) {
            const BoxDomain3 rod{{thickness, 5, thickness}, periodic};
            std::vector<double> positions;
            for (const Point3 p : distributed(rod, {.sites = 200}).points) positions.push_back(p.y / rod.sides.y);
            std::ranges::sort(positions);
            for (std::size_t i = 1; i < positions.size(); ++i) {
                EXPECT_GT(200 * (positions[i] - positions[i - 1]), 0.85) << periodic << thickness;
                EXPECT_LT(200 * (positions[i] - positions[i - 1]), 1.15) << periodic << thickness;
            }
            const BoxDomain3 plate{{1, 1, thickness}, periodic};
            std::vector<Point3> in_plane = distributed(plate, {.sites = 900}).points;
            for (Point3& p : in_plane) p.z = 0;
            EXPECT_GT(30 * distances({{1, 1, 1}, periodic}, in_plane).least, 0.8) << periodic << thickness;
        }
    }
}

TEST(DistributeInVolume, FillsThinBoxesWithTetrahedra) {
    for (const Point3 sides : {Point3{1, 1e-4, 1e-4}, Point3{2, 1e-6, 1}}) {
        const BoxDomain3 box{sides};
        for (const std::size_t sites : {1, 17, 157}) {
            const auto mesh = distributed(box, {.sites = sites, .keep_mesh = true}).mesh;
            EXPECT_NEAR(volume_of(*mesh, box) / box.volume(), 1, 1e-9) << sites;
        }
    }
}

TEST(DistributeInVolume, HandlesThinDomainsOfVaryingDensity) {
    // Where the density is low, the spacing is about 25 times the shortest side.
    const VoxelDensity density = *VoxelDensity::create({2, 2, 1}, std::array<double, 4>{1, 1e-3, 1e-3, 1e-3});
    for (const bool periodic : {false, true}) {
        const BoxDomain3 domain{{1, 1, 4e-3}, periodic};
        const auto result = distributed(domain, {.sites = 1000, .quality = Quality::Draft}, density);
        EXPECT_EQ(result.points.size(), 1000u);
        EXPECT_GT(distances(domain, result.points).least, 0);
    }
}

TEST(DistributeInVolume, FillsTheDomainWithTetrahedra) {
    for (const BoxDomain3& domain : {BoxDomain3{{1, 0.7, 0.4}, false}, BoxDomain3{{1, 0.7, 0.4}, true}}) {
        const auto result = distributed(domain, {.sites = 2000, .keep_mesh = true});
        ASSERT_TRUE(result.mesh);
        EXPECT_EQ(result.mesh->vertices.size() == 2000, domain.periodic);
        EXPECT_NEAR(volume_of(*result.mesh, domain), domain.volume(), 1e-9);
        const double spacing = std::cbrt(domain.volume() / 2000);
        for (std::size_t i = 0; i < 2000; ++i) {
            Point3 move = result.mesh->vertices[i] - result.points[i];
            if (domain.periodic)
                move =
                    move - Point3{std::round(move.x), 0.7 * std::round(move.y / 0.7), 0.4 * std::round(move.z / 0.4)};
            EXPECT_LT(length(move), 0.5 * spacing);
        }
        const auto angles = test::dihedral_angles(*result.mesh, domain.periodic ? domain.sides : Point3{});
        EXPECT_GT(angles.front(), 15);
        EXPECT_GT(angles[angles.size() / 20], 40);
    }
}

/// Returns the sorted Delaunay tetrahedra of points on a torus. Triangulates all copies in a window.
/// @param around  number of copies on each side, for each axis
std::vector<Tetrahedron> all_tetrahedra(Point3 sides, std::span<const Point3> points, std::array<int, 3> around) {
    std::vector<Point3> positions(points.begin(), points.end());
    for (int i = -around[0]; i <= around[0]; ++i) {
        for (int j = -around[1]; j <= around[1]; ++j) {
            for (int k = -around[2]; k <= around[2]; ++k) {
                if (i == 0 && j == 0 && k == 0) continue;
                for (const Point3 p : points) positions.push_back(p + Point3{i * sides.x, j * sides.y, k * sides.z});
            }
        }
    }
    std::vector<Tetrahedron> found;
    for (Tetrahedron corners : delaunay_tetrahedra(positions)) {
        const auto number = [&](std::uint32_t corner) { return corner % static_cast<std::uint32_t>(points.size()); };
        const auto lowest = std::ranges::min(corners, {}, [&](auto corner) {
            return std::array{number(corner), corner};
        });
        if (lowest >= points.size()) continue;
        std::ranges::transform(corners, corners.begin(), number);
        std::ranges::sort(corners);
        found.push_back(corners);
    }
    std::ranges::sort(found);
    return found;
}

TEST(DistributeInVolume, FillsToriWithWideGapsWithTetrahedra) {
    std::vector<double> corner(512, 0.0);
    corner[0] = 1;
    const auto crowded = VoxelDensity::create({8, 8, 8}, corner);
    ASSERT_TRUE(crowded);
    const auto compare = [](const BoxDomain3& domain, const VoxelDensity& density, std::size_t sites,
                            std::array<int, 3> around) {
        const auto mesh = distributed(domain, {.sites = sites, .keep_mesh = true}, density).mesh;
        ASSERT_TRUE(mesh);
        auto tetrahedra = mesh->tetrahedra;
        for (Tetrahedron& corners : tetrahedra) std::ranges::sort(corners);
        std::ranges::sort(tetrahedra);
        EXPECT_EQ(tetrahedra, all_tetrahedra(domain.sides, mesh->vertices, around)) << sites;
    };
    for (const std::size_t sites : {3, 5, 17}) {
        const double side = 1 / static_cast<double>(sites);
        compare({{1, side, side}, true}, VoxelDensity::uniform(), sites, {2, 6, 6});
    }
    for (const std::size_t sites : {1, 2, 9, 40}) compare(kTorus, *crowded, sites, {2, 2, 2});
}

TEST(DistributeInVolume, FollowsTheDensity) {
    // Three quarters of the points belong in the upper half. No point belongs in the last third along y.
    const VoxelDensity density = *VoxelDensity::create({1, 3, 2}, std::array<double, 6>{1, 1, 0, 3, 3, 0});
    for (const BoxDomain3& domain : {kBox, kTorus}) {
        const auto result = distributed(domain, {.sites = 4000}, density);
        const auto upper = std::ranges::count_if(result.points, [](Point3 p) { return p.z > 0.5; });
        const auto outside = std::ranges::count_if(result.points, [](Point3 p) { return p.y > 2.0 / 3; });
        EXPECT_NEAR(static_cast<double>(upper), 3000, 30);
        EXPECT_EQ(outside, 0);
    }
}

TEST(DistributeInVolume, SpreadsPointsInASingleVoxel) {
    // The spacing of the points is much smaller than the cells in which spacings are computed. These cells are larger
    // than the voxels, then about as large.
    for (const auto& [number, sites] : {std::pair(48, 300), std::pair(24, 1200)}) {
        const auto voxels = static_cast<std::size_t>(number);
        const double side = 1.0 / number;
        std::vector<double> values(voxels * voxels * voxels, 0);
        values[0] = 1;
        const auto density = VoxelDensity::create({voxels, voxels, voxels}, values);
        const auto points = distributed(kBox, {.sites = static_cast<std::size_t>(sites)}, *density).points;
        for (const Point3 p : points) ASSERT_LT(std::max({p.x, p.y, p.z}), side);
        const Distances found = distances({{side, side, side}}, points);
        EXPECT_GT(found.least, 0.6);
        EXPECT_GT(found.mean, 0.84);
    }
}

TEST(DistributeInVolume, KeepsFewSitesOutOfAlmostEmptyVoxels) {
    std::vector<double> values(8, 1e-308);
    values[0] = 1e308;
    const auto density = VoxelDensity::create({8, 1, 1}, values);
    for (std::size_t sites = 1; sites <= 3; ++sites) {
        for (const Point3 p : distributed(kBox, {.sites = sites}, *density).points) EXPECT_LT(p.x, 0.125);
    }
}

TEST(DistributeInVolume, KeepsSitesAwayFromFixedPoints) {
    VolumeOptions options{.sites = 900, .keep_mesh = true};
    for (int i = 0; i < 100; ++i) options.fixed.push_back({0.5, (i / 10 + 0.5) / 10, (i % 10 + 0.5) / 10});
    for (const BoxDomain3& domain : {kBox, kTorus}) {
        const auto result = distributed(domain, options);
        ASSERT_EQ(result.points.size(), 900u);
        std::vector<Point3> all = result.points;
        all.insert(all.end(), options.fixed.begin(), options.fixed.end());
        EXPECT_GT(distances(domain, all).least, domain.periodic ? 0.8 : 0.7);
        for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(result.mesh->vertices[900 + i], options.fixed[i]);
    }
}

TEST(DistributeInVolume, StopsWithTheCurrentPoints) {
    test::expect_stops({0, 1, 9, 12, 19}, [](const VolumeOptions& options, const Control& control) {
        return distribute_in_volume(kTorus, VoxelDensity::uniform(), options, control);
    });
}

TEST(DistributeInVolume, FailsIfItStopsBeforeThereAreInitialSites) {
    std::stop_source source;
    source.request_stop();
    const auto result =
        distribute_in_volume(kTorus, VoxelDensity::uniform(), {.sites = 500}, {.stop = source.get_token()});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Stopped);
}

TEST(DistributeInVolume, ReportsProgressUpToTheEnd) {
    double done = 0;
    Progress last;
    Control control;
    control.progress = [&](const Progress& progress) {
        EXPECT_GT(progress.done(), done);
        done = progress.done();
        last = progress;
    };
    ASSERT_TRUE(distribute_in_volume(kTorus, VoxelDensity::uniform(), {.sites = 500}, control));
    EXPECT_EQ(last.iteration, last.iterations);
    EXPECT_EQ(last.round, last.rounds);
}

TEST(DistributeInVolume, RejectsOptionsOutOfRange) {
    const auto field = [](const BoxDomain3& domain, const VolumeOptions& options) {
        const auto result = distribute_in_volume(domain, VoxelDensity::uniform(), options);
        return result ? std::string() : result.error().field;
    };
    EXPECT_EQ(field(kBox, {.sites = 0}), "sites");
    EXPECT_EQ(field(kBox, {.sites = VolumeOptions::kMaxPoints, .fixed = {{0.5, 0.5, 0.5}}}), "sites");
    EXPECT_EQ(field({{1, 0, 1}, false}, {.sites = 1}), "domain");
    EXPECT_EQ(field({{1, std::numeric_limits<double>::quiet_NaN(), 1}, false}, {.sites = 1}), "domain");
    EXPECT_EQ(field({{1, std::numeric_limits<double>::infinity(), 1}, true}, {.sites = 1}), "domain");
    EXPECT_EQ(field({{5e-324, 5e-324, 5e-324}, false}, {.sites = 17}), "domain");
    EXPECT_EQ(field(kBox, {.sites = 1, .fixed = {{0.5, 0.5, 0.5}, {0.5, 1.5, 0.5}}}), "fixed/1");
}

TEST(DistributeInVolume, NamesAFixedPointOutsideTheDomain) {
    const auto result =
        distribute_in_volume(kBox, VoxelDensity::uniform(), {.sites = 1, .fixed = {{0.5, 0.5, 0.5}, {0.5, 1.5, -9}}});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().message, "the fixed point 1, (0.5, 1.5, -9), is not in the domain");
}

}  // namespace
}  // namespace ccdt
