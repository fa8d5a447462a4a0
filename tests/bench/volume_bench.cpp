// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <thread>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/parallel/thread_executor.h"
#include "core/polish/cell_list.h"
#include "core/random.h"
#include "core/volume/distribute_volume.h"
#include "core/volume/volume_mesh.h"
#include "core/volume/volume_spacing.h"
#include "tests/bench/stages.h"

namespace ccdt::bench {
namespace {

constexpr BoxDomain3 kTorus{{1, 1, 1}, true};

/// Returns the distance of each point of a torus to the nearest other point, relative to the densest packing.
std::vector<double> nearest_distances(std::span<const Point3> points) {
    const double densest = VolumeSpacing::kDensest / std::cbrt(static_cast<double>(points.size()));
    const Point3 margin{densest, densest, densest};
    std::vector<Point3> places(points.begin(), points.end());
    for (const Point3 p : points) {
        kTorus.for_copies(p, {Point3{} - margin, kTorus.sides + margin}, [&](Point3 copy, bool is_original) {
            if (!is_original) places.push_back(copy);
        });
    }
    const CellList3 cells(places);
    std::vector<double> distances;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        double squared = densest * densest;
        cells.for_near(points[i], densest, [&](Point3 q, std::uint32_t number) {
            if (number != i) squared = std::min(squared, dot(q - points[i], q - points[i]));
        });
        distances.push_back(std::sqrt(squared) / densest);
    }
    return distances;
}

/// Returns the mean power of waves below half the principal frequency of the densest packing, in dB. Of many waves,
/// uses an even selection.
double low_power(std::span<const Point3> points) {
    constexpr double kMostTerms = 4e7;
    const auto count = static_cast<double>(points.size());
    const double end = std::sqrt(1.5) / VolumeSpacing::kDensest * std::cbrt(count) / 2;
    const int highest = static_cast<int>(end);
    const double waves = 2 * std::numbers::pi / 3 * end * end * end;
    const auto step = static_cast<std::size_t>(std::max(1.0, waves * count / kMostTerms));
    std::size_t number = 0;
    std::vector<double> powers;
    for (int i = 0; i <= highest; ++i) {
        for (int j = -highest; j <= highest; ++j) {
            for (int k = -highest; k <= highest; ++k) {
                const double squared = i * i + j * j + k * k;
                if (squared == 0 || squared >= end * end || number++ % step != 0) continue;
                std::complex<double> wave = 0;
                for (const Point3 p : points)
                    wave += std::polar(1.0, 2 * std::numbers::pi * (i * p.x + j * p.y + k * p.z));
                powers.push_back(std::norm(wave) / count);
            }
        }
    }
    double sum = 0;
    for (const double power : powers) sum += power;
    return 10 * std::log10(sum / static_cast<double>(powers.size()));
}

/// Returns the smallest dihedral angle of a tetrahedron, in degrees.
double least_dihedral_angle(const std::array<Point3, 4>& corners) {
    double largest_cosine = -1;
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = i + 1; j < 4; ++j) {
            const std::size_t k = i == 0 ? (j == 1 ? 2 : 1) : 0, l = 6 - i - j - k;
            const Point3 edge = corners[j] - corners[i];
            const Point3 a = cross(edge, corners[k] - corners[i]), b = cross(edge, corners[l] - corners[i]);
            largest_cosine = std::max(largest_cosine, dot(a, b) / (length(a) * length(b)));
        }
    }
    return std::acos(std::min(largest_cosine, 1.0)) * 180 / std::numbers::pi;
}

/// Returns the smallest dihedral angles of all tetrahedra of a mesh on the torus, sorted.
std::vector<double> dihedral_angles(std::span<const Point3> points) {
    const VolumeSpacing spacing(kTorus, VoxelDensity::uniform(), points.size(), inline_executor());
    const TetrahedronMesh mesh = volume_mesh(kTorus, spacing, points, points.size(), {});
    std::vector<double> angles;
    for (const Tetrahedron& tetrahedron : mesh.tetrahedra) {
        std::array<Point3, 4> corners;
        for (std::size_t i = 0; i < 4; ++i) {
            Point3 away = mesh.vertices[tetrahedron[i]] - mesh.vertices[tetrahedron[0]];
            away = away - Point3{std::round(away.x), std::round(away.y), std::round(away.z)};
            corners[i] = away;
        }
        angles.push_back(least_dihedral_angle(corners));
    }
    std::ranges::sort(angles);
    return angles;
}

/// Measures points on a torus in space of uniform density. `over_delaunay` is the ratio of the time, with all threads,
/// to that of one CGAL Delaunay triangulation of as many random points. Arguments: number of sites, quality (0 draft, 1
/// standard, 2 best, 3 stealthy).
void VolumePattern(benchmark::State& state) {
    ThreadExecutor executor(std::thread::hardware_concurrency());
    Control control;
    control.executor = &executor;
    VolumeOptions options;
    options.sites = static_cast<std::size_t>(state.range(0));
    options.quality = static_cast<Quality>(state.range(1));
    std::vector<Point3> random(options.sites);
    Random numbers(1, 0);
    for (Point3& p : random) p = {numbers.uniform(), numbers.uniform(), numbers.uniform()};
    std::vector<double> ours, yardstick;
    std::vector<Point3> points;
    for (auto _ : state) {
        Clock clock;
        points = distribute_in_volume(kTorus, VoxelDensity::uniform(), options, control)->points;
        ours.push_back(clock.lap());
        benchmark::DoNotOptimize(delaunay_tetrahedra(random));
        yardstick.push_back(clock.lap());
        state.SetIterationTime(ours.back() / 1000);
    }
    state.counters["over_delaunay"] = median(ours) / median(yardstick);
    state.counters["delaunay_ms"] = median(yardstick);
    const std::vector<double> distances = nearest_distances(points);
    double sum = 0;
    for (const double distance : distances) sum += distance;
    state.counters["least"] = std::ranges::min(distances);
    state.counters["mean"] = sum / static_cast<double>(distances.size());
    state.counters["power_db"] = low_power(points);
    const std::vector<double> angles = dihedral_angles(points);
    const auto flat = static_cast<double>(std::ranges::lower_bound(angles, 15.0) - angles.begin());
    state.counters["flat_percent"] = 100 * flat / static_cast<double>(angles.size());
    state.counters["angle_p5"] = angles[angles.size() / 20];
}

BENCHMARK(VolumePattern)
    ->ArgsProduct({{4096, 16384, 131072}, {0, 1, 2, 3}})
    ->Args({1000000, 1})
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();

}  // namespace
}  // namespace ccdt::bench
