// SPDX-License-Identifier: GPL-3.0-or-later
#include <benchmark/benchmark.h>

#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "api/image/image_codec.h"
#include "api/image/overlay.h"
#include "api/image/png_writer.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/halftone/dots/dots.h"
#include "core/picture/tone.h"
#include "tests/bench/photograph.h"
#include "tests/bench/stages.h"
#include "tests/bench/yardstick.h"

namespace ccdt::bench {
namespace {

constexpr std::size_t kMaxPixels = 64'000'000;

/// Returns camera.png, enlarged by a whole factor, as a PNG file with 8 bits per pixel.
std::string enlarged_png(int factor) {
    if (factor == 1) return photograph("camera.png");
    const Picture small = *api::decode_image(photograph("camera.png"), kMaxPixels);
    Raster large{small.width * factor, small.height * factor, 0, {}};
    const auto at = [&](int x, int y) {
        return small.luminance[static_cast<std::size_t>(y) * static_cast<std::size_t>(small.width) +
                               static_cast<std::size_t>(x)];
    };
    for (int y = 0; y < large.height; ++y) {
        for (int x = 0; x < large.width; ++x) {
            const int i = x / factor, j = y / factor;
            const int i1 = std::min(i + 1, small.width - 1), j1 = std::min(j + 1, small.height - 1);
            const auto fx = static_cast<float>(x % factor) / static_cast<float>(factor);
            const auto fy = static_cast<float>(y % factor) / static_cast<float>(factor);
            const float light = std::lerp(std::lerp(at(i, j), at(i1, j), fx), std::lerp(at(i, j1), at(i1, j1), fx), fy);
            large.coverage.push_back(static_cast<std::uint8_t>(std::lround(255 * (1 - light))));
        }
    }
    return *api::write_png(api::overlay({std::move(large)}, {}, true));
}

/// Measures the stages of a photograph's halftone, in milliseconds. `core_over_delaunay` is the time from the picture
/// to the sites, divided by the time of one CGAL Delaunay triangulation of these sites (medians of the same run).
/// Arguments: side of the picture, number of sites, quality (0 draft, 1 standard, 2 best). Stages 3 to 7 are those of a
/// draft.
void Halftone(benchmark::State& state) {
    const std::string file = enlarged_png(static_cast<int>(state.range(0)) / 512);
    Options options;
    options.sites = static_cast<std::size_t>(state.range(1));
    options.quality = static_cast<Quality>(state.range(2));
    std::vector<double> decode, tone, core, raster, encode, yardstick;
    std::vector<Stages> stages;
    double variation = 0;
    std::size_t bytes = 0;
    for (auto _ : state) {
        Clock clock;
        const Picture picture = *api::decode_image(file, kMaxPixels);
        decode.push_back(clock.lap());
        const std::vector<float> coverage = ink_coverage(picture, Tone::Linear, false);
        const Density density = *Density::grid(picture.width, picture.height, coverage);
        const Domain domain = *Domain::rectangle(picture.width, picture.height);
        tone.push_back(clock.lap());
        const Distribution sites = *distribute(domain, density, options);
        core.push_back(clock.lap());
        const double scale = default_scale(density.total(), coverage.size(), options.sites);
        const double mean = density.total() / static_cast<double>(coverage.size());
        const Canvas canvas{static_cast<int>(std::lround(picture.width * scale)),
                            static_cast<int>(std::lround(picture.height * scale)), scale};
        Raster dots = draw_dots(sites.points, canvas, {{}, mean, false});
        raster.push_back(clock.lap());
        bytes = api::write_png(api::overlay({std::move(dots)}, {}, false))->size();
        encode.push_back(clock.lap());
        state.SetIterationTime((decode.back() + tone.back() + core.back() + raster.back() + encode.back()) / 1000);
        yardstick.push_back(delaunay_ms(sites.points));
        stages.push_back(time_stages(domain, density, options));
        variation = sites.variation();
    }
    const auto stage = [&](double Stages::*member) {
        std::vector<double> values;
        for (const Stages& run : stages) values.push_back(run.*member);
        return median(values);
    };
    state.counters["1_decode"] = median(decode);
    state.counters["2_tone"] = median(tone);
    state.counters["3_start"] = stage(&Stages::start);
    state.counters["4_triangulate"] = stage(&Stages::triangulate);
    state.counters["5_capacity"] = stage(&Stages::capacity);
    state.counters["6_geometry"] = stage(&Stages::geometry);
    state.counters["7_flips"] = stage(&Stages::flips);
    state.counters["8_raster"] = median(raster);
    state.counters["9_encode"] = median(encode);
    state.counters["core_ms"] = median(core);
    state.counters["core_over_delaunay"] = median(core) / median(yardstick);
    state.counters["variation"] = variation;
    state.counters["bytes"] = static_cast<double>(bytes);
}

BENCHMARK(Halftone)
    ->ArgsProduct({{512}, {16384}, {0, 1, 2}})
    ->ArgsProduct({{512, 4096}, {262144}, {0, 1}})
    ->ArgsProduct({{4096}, {16384}, {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime()
    ->MinTime(1);

}  // namespace
}  // namespace ccdt::bench
