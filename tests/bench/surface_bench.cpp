// SPDX-License-Identifier: GPL-3.0-or-later
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <thread>
#include <vector>

#include "core/base/random.h"
#include "core/base/thread_executor.h"
#include "core/ccdt/surface/distribute.h"
#include "core/points/analysis/surface_analysis.h"
#include "tests/bench/stages.h"
#include "tests/bench/yardstick.h"
#include "tests/support/surfaces.h"

namespace ccdt::bench {
namespace {

constexpr int kSeeds = 3;
constexpr std::size_t kModes = 100;

/// Returns a sphere whose radius is a smooth function of the direction.
TriangleSoup blob() {
    TriangleSoup soup = test::sphere_surface(5);
    for (Point3& p : soup.vertices) p = (1 + 0.2 * std::sin(4 * p.x) * std::sin(5 * p.y) * std::cos(3 * p.z)) * p;
    return soup;
}

/// Returns a bent square with a border.
TriangleSoup cap() {
    return test::grid_surface(60, 60, [](double u, double v) {
        const double x = 1.4 * u - 0.7, y = 1.4 * v - 0.7;
        return Point3{x, y, std::sqrt(1 - (x * x + y * y) / 2)};
    });
}

/// Returns one of the shapes: 0 sphere, 1 torus, 2 blob, 3 open cap, 4 cube with creases.
Surface shape(std::int64_t number) {
    const auto soup = number == 0   ? test::sphere_surface(5)
                      : number == 1 ? test::torus_surface(1, 0.4, 96, 48)
                      : number == 2 ? blob()
                      : number == 3 ? cap()
                                    : test::cube_surface();
    const auto crease = number == 4 ? std::optional(std::numbers::pi / 4) : std::nullopt;
    return Surface::create(soup, crease).value().surface;
}

SurfaceOptions options_for(std::int64_t sites, std::int64_t quality) {
    SurfaceOptions options;
    options.sites = static_cast<std::size_t>(sites);
    options.quality = static_cast<Quality>(quality);
    return options;
}

/// Measures the quality of patterns of 4,096 sites, averaged over 3 seeds: distances relative to a hexagonal grid, and
/// the power of the lowest 100 modes, relative to random points.
/// Arguments: shape, quality (0 draft, 1 standard, 2 best).
void SurfacePattern(benchmark::State& state) {
    const Surface surface = shape(state.range(0));
    SurfaceOptions options = options_for(4096, state.range(1));
    double min = 0, mean = 0, power = 0;
    for (auto _ : state) {
        for (int seed = 1; seed <= kSeeds; ++seed) {
            options.seed = static_cast<std::uint64_t>(seed);
            const auto placed = distribute_on_surface(surface, SurfaceDensity::uniform(), options).value();
            const auto found = analyse_surface(surface, placed.points, kModes).value();
            min += found.min_distance / kSeeds;
            mean += found.mean_distance / kSeeds;
            power += *found.low_frequency_power / kSeeds;
        }
    }
    state.counters["min_distance"] = min;
    state.counters["mean_distance"] = mean;
    state.counters["modes_db"] = 10 * std::log10(power);
}

/// Measures the distribution of uniform sites on the blob by all threads. `over_delaunay` is the ratio to the time of
/// one CGAL Delaunay triangulation of as many random points in the plane (medians of the same run).
/// Arguments: number of sites, quality.
void SurfaceTime(benchmark::State& state) {
    const Surface surface = shape(2);
    const SurfaceOptions options = options_for(state.range(0), state.range(1));
    Random random(1, 0);
    std::vector<Point> plane(options.sites);
    for (Point& p : plane) p = {random.uniform(), random.uniform()};
    ThreadExecutor executor(std::thread::hardware_concurrency());
    Control control;
    control.executor = &executor;
    std::vector<double> ours, yardstick;
    for (auto _ : state) {
        Clock clock;
        const auto placed = distribute_on_surface(surface, SurfaceDensity::uniform(), options, control);
        ours.push_back(clock.lap());
        yardstick.push_back(delaunay_ms(plane));
        state.SetIterationTime(ours.back() / 1000);
        benchmark::DoNotOptimize(placed);
    }
    state.counters["over_delaunay"] = median(ours) / median(yardstick);
    state.counters["delaunay_ms"] = median(yardstick);
    state.counters["us_per_site"] = median(ours) * 1000 / static_cast<double>(options.sites);
}

BENCHMARK(SurfacePattern)->ArgsProduct({{0, 1, 2, 3, 4}, {0, 1, 2}})->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK(SurfaceTime)
    ->ArgsProduct({{1024, 16384, 131072, 1048576}, {0, 1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime()
    ->MinTime(2);

}  // namespace
}  // namespace ccdt::bench
