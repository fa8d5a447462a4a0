// SPDX-License-Identifier: GPL-3.0-or-later
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "core/base/thread_executor.h"
#include "core/baselines/odt.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/ccdt/polish/nonuniform_transform.h"
#include "core/dither/pixel_choice.h"
#include "core/geometry/hexagonal_spacing.h"
#include "core/points/analysis/analysis.h"
#include "core/points/order/progressive_order.h"
#include "tests/support/evenness.h"
#include "tests/support/pictures.h"
#include "tests/support/shapes.h"

namespace ccdt::bench {
namespace {

constexpr int kSeeds = 10;

std::vector<Point> points_of(const Domain& domain, const Density& density, std::size_t sites, int seed,
                             const benchmark::State& state) {
    Options options;
    options.sites = sites;
    options.seed = static_cast<std::uint64_t>(seed);
    options.quality = static_cast<Quality>(state.range(0));
    return distribute(domain, density, options)->points;
}

/// Measures the quality of uniform patterns on a torus, for 10 sets of 4,096 sites: distances relative to a hexagonal
/// grid, and power relative to white noise. More rounds of the polish, or a longer reach, increase distances and the
/// highest power. First argument of all benchmarks in this file except OdtBorderPattern: quality (0 draft, 1 standard,
/// 2 best).
void TorusPattern(benchmark::State& state) {
    const Domain domain = *Domain::torus(1, 1);
    std::vector<std::vector<Point>> sets;
    for (auto _ : state) {
        for (int seed = 1; seed <= kSeeds; ++seed)
            sets.push_back(points_of(domain, Density::uniform(), 4096, seed, state));
    }
    const Analysis analysis = *analyse(sets, domain, {});
    state.counters["min_distance"] = analysis.min_distance;
    state.counters["mean_distance"] = analysis.mean_distance;
    state.counters["low_power"] = *analysis.low_frequency_power;
    state.counters["peak"] = *std::ranges::max_element(analysis.power);
}

/// Counts sites within 1 and 1.5 mean spacings of the border of a square, relative to the number expected from the area
/// of these strips, for 10 sets of 4,096 sites.
/// @param points_of  function from the number of sites and the seed to points
template <class Points>
void count_at_border(benchmark::State& state, Points&& points_of) {
    constexpr std::size_t kSites = 4096;
    const double spacing = 1 / std::sqrt(static_cast<double>(kSites));
    std::vector<double> depths;
    for (auto _ : state) {
        for (int seed = 1; seed <= kSeeds; ++seed) {
            for (const Point p : points_of(kSites, seed)) depths.push_back(std::min({p.x, 1 - p.x, p.y, 1 - p.y}));
        }
    }
    const auto crowding = [&](double spacings) {
        const double depth = spacings * spacing, area = 1 - std::pow(1 - 2 * depth, 2);
        const auto within = std::ranges::count_if(depths, [&](double d) { return d < depth; });
        return static_cast<double>(within) / (kSeeds * static_cast<double>(kSites) * area);
    };
    state.counters["within_1"] = crowding(1);
    state.counters["within_1.5"] = crowding(1.5);
}

void BorderPattern(benchmark::State& state) {
    const Domain domain = *Domain::rectangle(1, 1);
    count_at_border(
        state, [&](std::size_t sites, int seed) { return points_of(domain, Density::uniform(), sites, seed, state); });
}

void OdtBorderPattern(benchmark::State& state) {
    const Domain domain = *Domain::rectangle(1, 1);
    count_at_border(state, [&](std::size_t sites, int seed) {
        Options options;
        options.sites = sites;
        options.seed = static_cast<std::uint64_t>(seed);
        options.iterations = kOdtIterations;
        return odt(domain, Density::uniform(), options)->points;
    });
}

/// Computes the difference in tone between dots and a picture on the unit square.
class ToneError {
public:
    explicit ToneError(const Density& picture) : wanted_(kHighest, kHighest) {
        std::vector<WeightedPoint> cells;
        for (int row = 0; row < picture.height(); ++row) {
            for (int column = 0; column < picture.width(); ++column) {
                const Point middle{(column + 0.5) / picture.width(), (row + 0.5) / picture.height()};
                add_mirrored(middle, picture.value(column, row) / picture.total(), cells);
            }
        }
        wanted_.run(cells, {});
        for (int i = 0; i <= kHighest; ++i) {
            column_factors_.push_back(sinc(0.5 * i / picture.width()));
            row_factors_.push_back(sinc(0.5 * i / picture.height()));
        }
    }

    /// Returns the squared error of the dots' tone after a blur, relative to that of the same number of random dots, in
    /// dB.
    /// @param blur  in mean spacings of the dots
    double of(const std::vector<Point>& sites, double blur) const {
        const auto count = static_cast<double>(sites.size());
        std::vector<WeightedPoint> dots;
        for (const Point p : sites) add_mirrored(p, 1 / count, dots);
        NonuniformTransform found(kHighest, kHighest);
        found.run(dots, {});
        double error = 0, random = 0;
        for (int j = 0; j <= kHighest; ++j) {
            for (int i = j == 0 ? 1 : 0; i <= kHighest; ++i) {
                const double cycles = 0.5 * blur * std::hypot(i, j) / std::sqrt(count);
                const double passed = std::exp(-4 * kPi * kPi * cycles * cycles);
                const double off = found.value(i, j).real() - wanted_.value(i, j).real() *
                                                                  column_factors_[static_cast<std::size_t>(i)] *
                                                                  row_factors_[static_cast<std::size_t>(j)];
                error += passed * off * off / ((i == 0 ? 2 : 1) * (j == 0 ? 2 : 1));
                random += passed * 4 / count;
            }
        }
        return 10 * std::log10(error / random);
    }

private:
    static constexpr int kHighest = 96;  ///< maximum half periods per side; blurs remove higher frequencies
    static constexpr double kPi = std::numbers::pi;

    static double sinc(double cycles) { return cycles == 0 ? 1 : std::sin(kPi * cycles) / (kPi * cycles); }

    /// Adds a point and its three mirror images, so that the Fourier sums are cosine sums over the square.
    static void add_mirrored(Point p, double weight, std::vector<WeightedPoint>& points) {
        for (const double x : {p.x / 2, 1 - p.x / 2}) {
            for (const double y : {p.y / 2, 1 - p.y / 2}) points.push_back({{x, y}, weight});
        }
    }

    NonuniformTransform wanted_;
    std::vector<double> column_factors_, row_factors_;  ///< ratios of the spectrum of cells to that of their centres
};

/// Measures the error of tone for a shaded body on white, for 10 sets of 4,096 dots, after blurs by 1, 2 and 4
/// spacings.
void PictureTone(benchmark::State& state) {
    const Domain domain = *Domain::rectangle(1, 1);
    const Density picture = test::pear();
    const ToneError error(picture);
    double sums[3] = {};
    std::size_t on_white = 0;
    for (auto _ : state) {
        for (int seed = 1; seed <= kSeeds; ++seed) {
            const auto sites = points_of(domain, picture, 4096, seed, state);
            for (int k = 0; k < 3; ++k) sums[k] += error.of(sites, 1 << k) / kSeeds;
            on_white += test::count_on_white(domain, picture, sites);
        }
    }
    state.counters["1_spacing_db"] = sums[0];
    state.counters["2_spacings_db"] = sums[1];
    state.counters["4_spacings_db"] = sums[2];
    state.counters["on_white"] = static_cast<double>(on_white);
}

/// Lowers `distances[i]` to the distance of point i from the nearest point in another set.
void add_distances(const std::vector<Point>& from, const std::vector<Point>& to, std::vector<double>& distances) {
    for (std::size_t i = 0; i < from.size(); ++i) {
        for (const Point q : to) {
            const Point apart = q - from[i];
            if (apart == Point{}) continue;
            distances[i] = std::min(distances[i], std::sqrt(dot(apart, apart)));
        }
    }
}

/// Measures distances in three inks, for 10 sets of 1,500 dots: the first percentile between inks, relative to the
/// hexagonal grid of all dots, and the mean within the largest ink, relative to its own hexagonal grid.
/// Second argument: 0 a flat tint, 1 a shaded body on white ground.
void InksPattern(benchmark::State& state) {
    const Domain domain = *Domain::rectangle(1, 1);
    const std::vector<Density> densities(3, state.range(1) == 0 ? Density::uniform() : test::pear());
    const std::vector<std::size_t> counts{700, 500, 300};
    Options options;
    options.quality = static_cast<Quality>(state.range(0));
    double between = 0, within = 0;
    for (auto _ : state) {
        for (int seed = 1; seed <= kSeeds; ++seed) {
            options.seed = static_cast<std::uint64_t>(seed);
            const auto inks = *distribute_inks(domain, densities, counts, options);
            std::vector<double> others;
            for (const Distribution& ink : inks) {
                std::vector<double> distances(ink.points.size(), std::numeric_limits<double>::infinity());
                for (const Distribution& other : inks) {
                    if (&other != &ink) add_distances(ink.points, other.points, distances);
                }
                others.insert(others.end(), distances.begin(), distances.end());
            }
            std::ranges::sort(others);
            between += others[others.size() / 100] / hexagonal_spacing(1500) / kSeeds;
            std::vector<double> own(counts[0], std::numeric_limits<double>::infinity());
            add_distances(inks[0].points, inks[0].points, own);
            for (const double distance : own) within += distance / hexagonal_spacing(700) / (700.0 * kSeeds);
        }
    }
    state.counters["between_inks"] = between;
    state.counters["within_ink"] = within;
}

/// Measures the evenness of points in countries, for 3 sets of 4,096 sites of each: the variation of the capacities;
/// the error of the density after blurs by 1, 2 and 4 spacings, in dB relative to random sites; and the minimum, the
/// first percentile and the mean of the nearest distances, relative to a hexagonal grid. Second argument: 0 the unit
/// square, for comparison; 1 Switzerland, 2 South Africa, 3 Italy.
void CountryPattern(benchmark::State& state) {
    constexpr const char* kNames[] = {"", "Switzerland-10m.geojson", "South-Africa-50m.geojson", "Italy-110m.geojson"};
    constexpr int kSets = 3;
    const auto number = static_cast<std::size_t>(state.range(1));
    const Domain domain = number == 0 ? *Domain::rectangle(1, 1) : *Domain::create(test::read_geojson(kNames[number]));
    double variation = 0, powers[3] = {}, nearest = 1, percentile = 0, mean = 0;
    for (auto _ : state) {
        for (int seed = 1; seed <= kSets; ++seed) {
            Options options;
            options.sites = 4096;
            options.seed = static_cast<std::uint64_t>(seed);
            options.quality = static_cast<Quality>(state.range(0));
            const auto placed = *distribute(domain, Density::uniform(), options);
            variation += placed.variation() / kSets;
            for (int k = 0; k < 3; ++k)
                powers[k] += std::pow(10, test::noise(domain, placed.points, 1 << k) / 10) / kSets;
            const auto distances = test::sorted_distances(domain, placed.points);
            nearest = std::min(nearest, distances.front());
            percentile += distances[distances.size() / 100] / kSets;
            for (const double distance : distances) mean += distance / static_cast<double>(distances.size()) / kSets;
        }
    }
    state.counters["variation"] = variation;
    state.counters["1_spacing_db"] = 10 * std::log10(powers[0]);
    state.counters["2_spacings_db"] = 10 * std::log10(powers[1]);
    state.counters["4_spacings_db"] = 10 * std::log10(powers[2]);
    state.counters["nearest"] = nearest;
    state.counters["percentile"] = percentile;
    state.counters["mean"] = mean;
}

/// Returns the numbers k of first points that are measured in a progressive order, from n / 64 to n.
std::vector<std::size_t> first_counts(std::size_t points) {
    constexpr int kCounts = 61;
    std::vector<std::size_t> counts;
    for (int i = 0; i < kCounts; ++i) {
        const double share = std::pow(64, static_cast<double>(i) / (kCounts - 1) - 1);
        counts.push_back(static_cast<std::size_t>(std::llround(static_cast<double>(points) * share)));
    }
    return counts;
}

std::vector<Point> ordered(const Domain& domain, const std::vector<Point>& points, bool even) {
    std::vector<Point> result;
    for (const std::uint32_t i : progressive_order(domain, points, even)) result.push_back(points[i]);
    return result;
}

/// Measures the first k of 16,384 points in a progressive order on a torus: the minimum and mean distance relative to a
/// hexagonal grid, and the power below half the principal frequency. Reports the worst and the mean over 3 seeds and
/// all k from n / 64.
void ProgressivePattern(benchmark::State& state) {
    constexpr int kSets = 3;
    const Domain domain = *Domain::torus(1, 1);
    double least = 1, mean = 1, mean_sum = 0, power = 0, power_sum = 0, count = 0;
    for (auto _ : state) {
        for (int seed = 1; seed <= kSets; ++seed) {
            const auto points = ordered(domain, points_of(domain, Density::uniform(), 16'384, seed, state), true);
            for (const std::size_t k : first_counts(points.size())) {
                const std::vector<std::vector<Point>> first{
                    {points.begin(), points.begin() + static_cast<std::ptrdiff_t>(k)}};
                const Analysis analysis = *analyse(first, domain, {.max_frequency = 1});
                least = std::min(least, analysis.min_distance);
                mean = std::min(mean, analysis.mean_distance);
                mean_sum += analysis.mean_distance;
                power = std::max(power, *analysis.low_frequency_power);
                power_sum += *analysis.low_frequency_power;
                ++count;
            }
        }
    }
    state.counters["min_distance"] = least;
    state.counters["mean_distance"] = mean;
    state.counters["mean_distance_over_k"] = mean_sum / count;
    state.counters["low_power"] = power;
    state.counters["low_power_over_k"] = power_sum / count;
}

/// Measures the error of tone for a shaded body on white ground, drawn by the first k of 16,384 dots in a progressive
/// order, after a blur by 2 spacings, in dB relative to k random dots. Reports the largest and the mean over 3 seeds
/// and all k from n / 64.
void ProgressiveTone(benchmark::State& state) {
    constexpr int kSets = 3;
    const Domain domain = *Domain::rectangle(1, 1);
    const Density picture = test::pear();
    const ToneError error(picture);
    double most = -std::numeric_limits<double>::infinity(), sum = 0, count = 0;
    for (auto _ : state) {
        for (int seed = 1; seed <= kSets; ++seed) {
            const auto points = ordered(domain, points_of(domain, picture, 16'384, seed, state), false);
            for (const std::size_t k : first_counts(points.size())) {
                const double each = error.of({points.begin(), points.begin() + static_cast<std::ptrdiff_t>(k)}, 2);
                most = std::max(most, each);
                sum += each;
                ++count;
            }
        }
    }
    state.counters["2_spacings_db"] = most;
    state.counters["2_spacings_db_over_k"] = sum / count;
}

/// Measures the choice of one of `range(0)` pixels of 512 x 512, by two threads: the distance of nearest neighbours
/// relative to a hexagonal grid, and the power below half the principal frequency relative to random points.
void PixelChoice(benchmark::State& state) {
    constexpr int kSide = 512;
    constexpr std::size_t kPixels = std::size_t{kSide} * kSide;
    const std::vector<std::uint8_t> included(kPixels, 0);
    ThreadExecutor executor(std::size_t{2});
    std::vector<std::uint8_t> chosen;
    for (auto _ : state) {
        const auto count = static_cast<std::size_t>(std::llround(kPixels / static_cast<double>(state.range(0))));
        const auto shares = pixel_shares(Density::uniform(), included, kSide, kSide, count, executor);
        chosen = choose_pixels(*shares, kSide, kSide, 1, {}, executor);
    }
    std::vector<std::vector<Point>> points(1);
    for (std::size_t i = 0; i < kPixels; ++i) {
        if (chosen[i] == 1)
            points[0].push_back(
                {(static_cast<double>(i % kSide) + 0.5) / kSide, (static_cast<double>(i / kSide) + 0.5) / kSide});
    }
    const Analysis analysis = *analyse(points, *Domain::torus(1, 1), {.max_frequency = 1});
    state.counters["mean_distance"] = analysis.mean_distance;
    state.counters["low_power"] = *analysis.low_frequency_power;
}

BENCHMARK(TorusPattern)->DenseRange(0, 2)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(BorderPattern)->DenseRange(0, 2)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(OdtBorderPattern)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(PictureTone)->DenseRange(0, 2)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(CountryPattern)->ArgsProduct({{0, 1, 2}, {0, 1, 2, 3}})->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(InksPattern)->ArgsProduct({{0, 1, 2}, {0, 1}})->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(ProgressivePattern)->Arg(1)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(ProgressiveTone)->Arg(1)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(PixelChoice)->ArgsProduct({{2, 3, 4, 6, 8, 10, 16, 64, 256}})->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ccdt::bench
