// SPDX-License-Identifier: GPL-3.0-or-later
#include <thread>

#include <benchmark/benchmark.h>

#include "core/base/thread_executor.h"
#include "core/ccdt/plane/ccdt.h"
#include "tests/bench/stages.h"
#include "tests/bench/yardstick.h"

namespace ccdt::bench {
namespace {

const Domain& square() {
    static const Domain domain = *Domain::rectangle(1, 1);
    return domain;
}

const Domain& torus() {
    static const Domain domain = *Domain::torus(1, 1);
    return domain;
}

Options options_for(std::int64_t sites) {
    Options options;
    options.sites = static_cast<std::size_t>(sites);
    return options;
}

/// Measures the distribution of uniform sites, with 5 iterations of 5 passes. `over_delaunay` is the ratio to the time
/// of one CGAL Delaunay triangulation of the same points (medians of the same run).
/// Arguments: number of sites, quality (0 draft, 1 standard, 2 best).
void distribute_uniformly(benchmark::State& state, const Domain& domain) {
    Options options = options_for(state.range(0));
    options.quality = static_cast<Quality>(state.range(1));
    std::vector<double> ours, yardstick;
    double variation = 0;
    for (auto _ : state) {
        Clock clock;
        const auto result = distribute(domain, Density::uniform(), options);
        ours.push_back(clock.lap());
        yardstick.push_back(delaunay_ms(result->points));
        state.SetIterationTime(ours.back() / 1000);
        variation = result->variation();
    }
    state.counters["over_delaunay"] = median(ours) / median(yardstick);
    state.counters["delaunay_ms"] = median(yardstick);
    state.counters["us_per_site"] = median(ours) * 1000 / static_cast<double>(options.sites);
    state.counters["variation"] = variation;
}

void Square(benchmark::State& state) {
    distribute_uniformly(state, square());
}

void Torus(benchmark::State& state) {
    distribute_uniformly(state, torus());
}

/// Measures the stages of a draft on the square, in milliseconds.
void UniformStages(benchmark::State& state) {
    const Options options = options_for(state.range(0));
    std::vector<Stages> runs;
    for (auto _ : state) runs.push_back(time_stages(square(), Density::uniform(), options));
    const auto report = [&](const char* name, double Stages::*stage) {
        std::vector<double> values;
        for (const Stages& run : runs) values.push_back(run.*stage);
        state.counters[name] = median(values);
    };
    report("1_start", &Stages::start);
    report("2_triangulate", &Stages::triangulate);
    report("3_capacity", &Stages::capacity);
    report("4_geometry", &Stages::geometry);
    report("5_flips", &Stages::flips);
}

/// Measures a square with one thread and with all threads alternately. `speedup` is the ratio of the medians.
/// Arguments: number of sites, quality.
void Scaling(benchmark::State& state) {
    Options options = options_for(state.range(0));
    options.quality = static_cast<Quality>(state.range(1));
    ThreadExecutor executor(std::thread::hardware_concurrency());
    Control together;
    together.executor = &executor;
    std::vector<double> by_one, by_all, yardstick;
    for (auto _ : state) {
        Clock clock;
        const auto result = distribute(square(), Density::uniform(), options);
        by_one.push_back(clock.lap());
        distribute(square(), Density::uniform(), options, together);
        by_all.push_back(clock.lap());
        yardstick.push_back(delaunay_ms(result->points));
        state.SetIterationTime(by_all.back() / 1000);
    }
    state.counters["threads"] = std::thread::hardware_concurrency();
    state.counters["ms_alone"] = median(by_one);
    state.counters["ms_together"] = median(by_all);
    state.counters["speedup"] = median(by_one) / median(by_all);
    state.counters["over_delaunay"] = median(by_one) / median(yardstick);
}

const std::vector<std::int64_t> kSites = {1024, 4096, 16384, 131072, 1048576};
const std::vector<std::int64_t> kQualities = {0, 1, 2};

BENCHMARK(Square)->ArgsProduct({kSites, kQualities})->Unit(benchmark::kMillisecond)->UseManualTime()->MinTime(2);
BENCHMARK(Torus)->ArgsProduct({kSites, kQualities})->Unit(benchmark::kMillisecond)->UseManualTime()->MinTime(2);
BENCHMARK(Scaling)
    ->ArgsProduct({{1024, 4096, 16384, 65536, 131072, 262144, 1048576, 4194304, 10485760}, {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime()
    ->MinTime(1);
BENCHMARK(UniformStages)->ArgsProduct({kSites})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ccdt::bench
