// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/density/tiers.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

namespace ccdt {

namespace {

constexpr int kBits = 50;  ///< bits of a double after the exponent and the two bits that divide an octave into four
constexpr std::uint64_t kFirst = std::uint64_t{1023 - 40} << 2;  ///< values below 2^-40 are in bin 1
/// Factor by which values are multiplied, so that 1, 1/2, 1/10, 1/100 and other common values are well inside bins.
constexpr double kShift = 1.12;

constexpr double kSharp = 0.5;  ///< largest number of cells near the value of a step, relative to the sides it crosses
constexpr double kFewestSites = 8;  ///< least number of sites for which there is area on each side of a step

std::uint8_t bin_of(double value) {
    if (!(value > 0)) return 0;
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(kShift * value) >> kBits;
    return static_cast<std::uint8_t>(std::clamp<std::uint64_t>(bits, kFirst, kFirst + DensityHistogram::kBins - 2) -
                                     kFirst + 1);
}

/// Returns the number of pairs of neighbouring cells that each value between two bins separates [bins]. Element b
/// counts the pairs of which one is in a bin up to b, and the other one is not.
std::array<double, DensityHistogram::kBins> separated_pairs(std::span<const std::uint8_t> bins,
                                                            const std::array<std::size_t, 3>& cells, bool periodic) {
    std::array<std::int64_t, DensityHistogram::kBins> changes{};
    const auto compare = [&](const std::uint8_t* a, const std::uint8_t* b, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            ++changes[std::min(a[i], b[i])];
            --changes[std::max(a[i], b[i])];
        }
    };
    const auto [columns, rows, layers] = cells;
    const std::size_t layer = columns * rows;
    for (std::size_t line = 0; line < rows * layers; ++line) {
        const std::uint8_t* const first = &bins[line * columns];
        compare(first, first + 1, columns - 1);
        if (periodic) compare(first, first + columns - 1, 1);
        const std::size_t row = line % rows;
        if (row > 0) compare(first - columns, first, columns);
        if (periodic && row == 0) compare(first, first + (rows - 1) * columns, columns);
        if (line >= rows) compare(first - layer, first, columns);
        if (periodic && line < rows) compare(first, first + (layers - 1) * layer, columns);
    }
    std::array<double, DensityHistogram::kBins> pairs{};
    std::int64_t sum = 0;
    for (std::size_t bin = 0; bin < pairs.size(); ++bin) pairs[bin] = static_cast<double>(sum += changes[bin]);
    return pairs;
}

}  // namespace

void DensityHistogram::add(double value) {
    const std::uint8_t bin = bin_of(value);
    bins.push_back(bin);
    masses[bin] += std::max(0.0, value);
    ++cells[bin];
}

std::vector<std::uint8_t> find_tiers(DensityHistogram histogram, const std::array<std::size_t, 3>& cells, bool periodic,
                                     double sites) {
    constexpr std::size_t kBins = DensityHistogram::kBins;
    const auto pairs = separated_pairs(histogram.bins, cells, periodic);
    const double axes = cells[2] > 1 ? 3 : 2, all = static_cast<double>(histogram.bins.size());
    double mass = 0;
    for (const double part : histogram.masses) mass += part;

    std::array<std::uint8_t, kBins> tiers{};  // [bins] first the number of steps directly below each bin
    double above = 0, held = 0;               // cells above the value between two bins, and sites that they hold
    struct Step {
        std::size_t first, last;  // bins directly below the sharpest values of the step
        double near;              // cells near these values
    };
    std::optional<Step> step;
    const auto end_step = [&] {
        if (step) tiers[(step->first + step->last) / 2 + 1] = 1;
        step.reset();
    };
    for (std::size_t bin = kBins - 1; bin-- > 0;) {
        above += static_cast<double>(histogram.cells[bin + 1]);
        held += histogram.masses[bin + 1] / mass * sites;
        const double density = held / above, below = all - above;  // NaN if there are no cells above
        const auto near = static_cast<double>(histogram.cells[bin] + histogram.cells[bin + 1]);
        const double width = 2 * std::min(above, below) / pairs[bin], spacing = std::pow(density, -1 / axes);
        if (!(near <= kSharp * pairs[bin] && held >= kFewestSites && below * density >= kFewestSites &&
              width >= spacing)) {
            end_step();
            continue;
        }
        if (!step || near < step->near) step = {bin, bin, near};
        if (near == step->near) step->first = bin;
    }
    end_step();
    for (std::size_t bin = 1; bin < kBins; ++bin) tiers[bin] = static_cast<std::uint8_t>(tiers[bin] + tiers[bin - 1]);
    if (tiers.back() == 0) return {};
    for (std::uint8_t& bin : histogram.bins) bin = tiers[bin];
    return std::move(histogram.bins);
}

}  // namespace ccdt
