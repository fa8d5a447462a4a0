// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>
#include <span>
#include <thread>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/base/random.h"
#include "core/base/thread_executor.h"
#include "core/ccdt/volume/distribute_volume.h"
#include "core/ccdt/volume/volume_mesh.h"
#include "core/ccdt/volume/volume_spacing.h"
#include "core/points/analysis/analysis.h"
#include "core/points/order/progressive_order.h"
#include "tests/bench/stages.h"

namespace ccdt::bench {
namespace {

constexpr BoxDomain3 kTorus{{1, 1, 1}, true};

/// Measures distances and powers of points on the torus.
Analysis measure(std::span<const Point3> points) {
    const std::vector<Point3> set(points.begin(), points.end());
    return *analyse(std::span(&set, 1), kTorus.sides, true, {.max_frequency = 1});
}

/// Returns the mean power below half the principal frequency, in dB.
double power_db(const Analysis& analysis) {
    return 10 * std::log10(*analysis.low_frequency_power);
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

/// Returns the processor time of all threads in milliseconds.
double processor_ms() {
    return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Measures points of uniform density on a torus in space. `over_delaunay` is the ratio of the time, with all threads,
/// to that of one CGAL Delaunay triangulation of as many random points. `work_over_delaunay` is the ratio of the
/// processor times, which other programs disturb less. Distances are relative to the densest packing. Arguments: number
/// of sites, quality (0 draft, 1 standard, 2 best, 3 stealthy).
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
    std::vector<double> ours, yardstick, work;
    std::vector<Point3> points;
    for (auto _ : state) {
        const double begin = processor_ms();
        Clock clock;
        points = distribute_in_volume(kTorus, VoxelDensity::uniform(), options, control)->points;
        ours.push_back(clock.lap());
        const double end = processor_ms();
        benchmark::DoNotOptimize(delaunay_tetrahedra(random));
        yardstick.push_back(clock.lap());
        work.push_back((end - begin) / (processor_ms() - end));
        state.SetIterationTime(ours.back() / 1000);
    }
    state.counters["over_delaunay"] = median(ours) / median(yardstick);
    state.counters["work_over_delaunay"] = median(work);
    state.counters["delaunay_ms"] = median(yardstick);
    const Analysis analysis = measure(points);
    state.counters["least"] = analysis.min_distance;
    state.counters["mean"] = analysis.mean_distance;
    state.counters["power_db"] = power_db(analysis);
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

/// Measures the first k points in a progressive order on a torus in space: the least and the mean distance, relative to
/// the densest packing of k points, and the power, as VolumePattern does. Reports the worst and the mean over 25 values
/// of k from n / 64 to n.
void VolumeOrder(benchmark::State& state) {
    constexpr int kCounts = 25;
    VolumeOptions options;
    options.sites = static_cast<std::size_t>(state.range(0));
    const std::vector<Point3> points = distribute_in_volume(kTorus, VoxelDensity::uniform(), options)->points;
    std::vector<Point3> ordered;
    for (auto _ : state) {
        ordered.clear();
        for (const std::uint32_t i : progressive_order_in_space({{}, kTorus.sides}, true, points, 1, true))
            ordered.push_back(points[i]);
    }
    double least = 1, mean = 1, mean_sum = 0, power = -200, power_sum = 0;
    for (int i = 0; i < kCounts; ++i) {
        const double share = std::pow(64, static_cast<double>(i) / (kCounts - 1) - 1);
        const auto first =
            std::span(ordered).first(static_cast<std::size_t>(share * static_cast<double>(ordered.size())));
        const Analysis analysis = measure(first);
        least = std::min(least, analysis.min_distance);
        mean = std::min(mean, analysis.mean_distance);
        mean_sum += analysis.mean_distance;
        power = std::max(power, power_db(analysis));
        power_sum += *analysis.low_frequency_power;
    }
    state.counters["least"] = least;
    state.counters["mean"] = mean;
    state.counters["mean_over_k"] = mean_sum / kCounts;
    state.counters["power_db"] = power;
    state.counters["power_over_k_db"] = 10 * std::log10(power_sum / kCounts);
}

BENCHMARK(VolumeOrder)->Arg(16384)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ccdt::bench
