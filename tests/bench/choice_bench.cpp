// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <queue>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/base/thread_executor.h"
#include "core/points/analysis/analysis.h"
#include "core/points/choice/choice.h"
#include "tests/bench/stages.h"

namespace ccdt::bench {
namespace {

/// Independent candidates on the unit torus.
std::vector<Point3> candidates_for(std::size_t count, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::vector<Point3> positions(count);
    for (Point3& p : positions)
        p = {static_cast<double>(random() >> 11) * 0x1p-53, static_cast<double>(random() >> 11) * 0x1p-53, 0};
    return positions;
}

/// Eliminates candidates with the largest weight until `count` are left, with the weights and the limit of the source,
/// and a grid in place of a k-d tree. Source: Yuksel 2015, "Sample elimination for generating Poisson disk sample
/// sets".
std::vector<std::uint32_t> eliminate(const std::vector<Point3>& positions, std::size_t count) {
    const auto n = static_cast<double>(positions.size()), k = static_cast<double>(count);
    const double longest = std::sqrt(1 / (2 * std::numbers::sqrt3 * k)), reach = 2 * longest;
    const double least = reach * 0.65 * (1 - std::pow(k / n, 1.5));
    const auto cells = static_cast<std::size_t>(std::max(3.0, std::floor(1 / reach)));
    const auto cell_of = [&](double x) {
        return std::min(cells - 1, static_cast<std::size_t>(x * static_cast<double>(cells)));
    };
    std::vector<std::vector<std::uint32_t>> grid(cells * cells);
    for (std::uint32_t i = 0; i < positions.size(); ++i)
        grid[cell_of(positions[i].y) * cells + cell_of(positions[i].x)].push_back(i);
    const auto around = [](double x) { return x - std::round(x); };
    const auto for_near = [&](std::uint32_t i, auto&& function) {
        const Point3 p = positions[i];
        const std::size_t column = cell_of(p.x) + cells, row = cell_of(p.y) + cells;
        for (std::size_t y = row - 1; y <= row + 1; ++y) {
            for (std::size_t x = column - 1; x <= column + 1; ++x) {
                for (const std::uint32_t j : grid[y % cells * cells + x % cells]) {
                    const double distance = std::hypot(around(p.x - positions[j].x), around(p.y - positions[j].y));
                    if (j == i || distance >= reach) continue;
                    const double rest = 1 - std::max(distance, least) / reach, square = rest * rest,
                                 fourth = square * square;
                    function(j, fourth * fourth);
                }
            }
        }
    };
    std::vector<double> weights(positions.size(), 0);
    for (std::uint32_t i = 0; i < positions.size(); ++i)
        for_near(i, [&](std::uint32_t, double weight) { weights[i] += weight; });
    using Entry = std::pair<double, std::uint32_t>;
    std::vector<Entry> entries;
    for (std::uint32_t i = 0; i < positions.size(); ++i) entries.emplace_back(weights[i], i);
    std::priority_queue<Entry> queue({}, std::move(entries));
    std::vector<bool> is_gone(positions.size());
    for (std::size_t left = positions.size(); left > count;) {
        const auto [weight, i] = queue.top();
        queue.pop();
        if (is_gone[i]) continue;
        if (weight > weights[i]) {  // neighbours were removed
            queue.emplace(weights[i], i);
            continue;
        }
        is_gone[i] = true;
        --left;
        for_near(i, [&](std::uint32_t j, double removed) { weights[j] -= removed; });
    }
    std::vector<std::uint32_t> rows;
    for (std::uint32_t i = 0; i < positions.size(); ++i)
        if (!is_gone[i]) rows.push_back(i);
    return rows;
}

struct Evenness {
    double least, mean, power_db;
};

Evenness measure(const std::vector<Point3>& positions, const std::vector<std::uint32_t>& rows) {
    std::vector<std::vector<Point>> sets(1);
    for (const std::uint32_t i : rows) sets[0].push_back({positions[i].x, positions[i].y});
    const auto analysis = analyse(sets, *Domain::torus(1, 1), {}).value();
    return {analysis.min_distance, analysis.mean_distance, 10 * std::log10(analysis.low_frequency_power.value_or(1))};
}

/// Chooses among random candidates on the torus. `over_elimination` is the ratio to the time of sample elimination with
/// one thread, in the same run. Arguments: candidates, points, threads.
void Choice(benchmark::State& state) {
    const auto positions = candidates_for(static_cast<std::size_t>(state.range(0)), 1);
    const auto count = static_cast<std::size_t>(state.range(1));
    ThreadExecutor executor(static_cast<std::size_t>(state.range(2)));
    Candidates candidates;
    candidates.positions = positions;
    candidates.torus = Point3{1, 1, 0};
    std::vector<double> ours, theirs;
    std::vector<std::uint32_t> chosen, left;
    for (auto _ : state) {
        Clock clock;
        chosen = choose_points(candidates, count, 1, {}, executor)->rows;
        ours.push_back(clock.lap());
        left = eliminate(positions, count);
        theirs.push_back(clock.lap());
        state.SetIterationTime(ours.back() / 1000);
    }
    state.counters["over_elimination"] = median(ours) / median(theirs);
    state.counters["us_per_candidate"] = median(ours) * 1000 / static_cast<double>(positions.size());
    if (count > 20'000) return;
    for (const auto& [name, rows] : {std::pair{"", &chosen}, std::pair{"elimination_", &left}}) {
        const Evenness evenness = measure(positions, *rows);
        state.counters[std::string(name) + "least"] = evenness.least;
        state.counters[std::string(name) + "mean"] = evenness.mean;
        state.counters[std::string(name) + "power_db"] = evenness.power_db;
    }
}

BENCHMARK(Choice)
    ->Args({5'000, 4'096, 1})
    ->Args({20'480, 4'096, 1})
    ->Args({100'000, 10'000, 1})
    ->Args({1'000'000, 100'000, 1})
    ->Args({1'000'000, 100'000, 2})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.1);

}  // namespace
}  // namespace ccdt::bench
