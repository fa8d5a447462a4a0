// SPDX-License-Identifier: GPL-3.0-or-later
#include <benchmark/benchmark.h>

#include <numeric>
#include <vector>

#include "api/image/image_codec.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/halftone/inks/separation.h"
#include "tests/bench/photograph.h"
#include "tests/bench/stages.h"
#include "tests/bench/yardstick.h"
#include "tests/support/inks.h"

namespace ccdt::bench {
namespace {

/// Measures the distribution of dots in cyan, magenta, yellow and black for `astronaut.png`, 512 x 512 pixels, from the
/// coverage of the inks to the sites. `over_delaunay` is the ratio to the time of one CGAL Delaunay triangulation of
/// each ink's sites, `over_alone` the ratio to distributing each ink alone. Both are ratios of medians of the same run.
/// Arguments: number of sites, quality (0 draft, 1 standard, 2 best).
void Inks(benchmark::State& state) {
    const ColourPicture picture = *api::decode_colour_image(photograph("astronaut.png"), 1'000'000);
    const Domain domain = *Domain::rectangle(picture.width, picture.height);
    Options options;
    options.quality = static_cast<Quality>(state.range(1));
    std::vector<double> separation, together, alone, yardstick;
    for (auto _ : state) {
        Clock clock;
        const auto coverage = separate(picture, test::cmyk_inks(), Tone::Linear).coverage;
        separation.push_back(clock.lap());
        std::vector<Density> densities;
        std::vector<double> sums;
        for (const auto& ink : coverage) {
            densities.push_back(*Density::grid(picture.width, picture.height, ink));
            sums.push_back(densities.back().total());
        }
        const auto sites = share_sites(sums, static_cast<std::size_t>(state.range(0)));
        clock.lap();
        const auto inks = *distribute_inks(domain, densities, sites, options);
        together.push_back(clock.lap());
        state.SetIterationTime((separation.back() + together.back()) / 1000);
        for (std::size_t i = 0; i < inks.size(); ++i) {
            options.sites = sites[i];
            benchmark::DoNotOptimize(distribute(domain, densities[i], options));
        }
        alone.push_back(clock.lap());
        yardstick.push_back(std::accumulate(inks.begin(), inks.end(), 0.0, [](double sum, const Distribution& ink) {
            return sum + delaunay_ms(ink.points);
        }));
    }
    state.counters["1_separate"] = median(separation);
    state.counters["2_distribute"] = median(together);
    state.counters["over_delaunay"] = median(together) / median(yardstick);
    state.counters["over_alone"] = median(together) / median(alone);
}

BENCHMARK(Inks)
    ->ArgsProduct({{4096, 20000, 100000}, {0, 1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime()
    ->MinTime(1);

}  // namespace
}  // namespace ccdt::bench
