// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/octave_transport.h"

#include <array>
#include <numbers>
#include <type_traits>

#include "core/base/elementary.h"
#include "core/geometry/spreading.h"

namespace ccdt {

namespace {

constexpr std::size_t kLines = 16;  ///< lines of coefficients per task
constexpr double kPi = std::numbers::pi;
constexpr double kCaution = 0.7;  ///< number of octaves added to the octave that follows from the spacing

}  // namespace

template <class P>
OctaveTransport<P>::OctaveTransport(const Frame& frame, double finest, double least, const Filter& filter,
                                    Executor& executor)
    : executor_(executor),
      frame_(frame),
      over_sides_(by_axis<P>([&](std::size_t axis) { return 1 / along(frame.sides, axis); })),
      finest_(finest),
      least_(least),
      filter_(filter) {
    octaves_.reserve(kMaxOctaves);
    add_octave();
}

template <class P>
void OctaveTransport<P>::add_octave() {
    const double spacing = octave_spacing(octaves_.size());
    std::array<int, 3> cells{1, 1, 1};
    for (std::size_t axis = 0; axis < kAxes<P>; ++axis)
        cells[axis] = std::max(kMinCells, good_size(filter_.cells * along(frame_.sides, axis) / spacing));
    Grid grid(frame_.torus, frame_.sides, cells, executor_);
    std::vector<Line> lines(grid.coefficient_count() / grid.line_size());
    const auto cycles = [spacing](const Grid& of, const Wave& wave) {
        const P f = of.frequency(wave);
        return std::sqrt(dot(f, f)) * spacing;
    };
    std::size_t factors = 0, targets = 0;
    for (std::size_t line = 0; line < lines.size(); ++line) {
        Wave wave = grid.first_wave(line);
        std::size_t count = 0;
        for (; count < grid.line_size() && cycles(grid, wave) < filter_.end; ++count) ++wave[0];
        lines[line] = {count, factors, targets};
        targets += count;
        if (wave[1] < 0 || wave[2] < 0) {
            const Wave mirrored{0, std::abs(wave[1]), std::abs(wave[2])};
            lines[line].factors = lines[grid.number(mirrored) / grid.line_size()].factors;
        } else {
            factors += count;
        }
    }
    Octave& octave = octaves_.emplace_back(Octave{std::move(grid), std::move(lines), std::vector<float>(factors)});
    for_long_waves(octave, [&](std::size_t number, const Wave& wave, std::size_t factor, std::size_t) {
        if (number == 0 || wave[1] < 0 || wave[2] < 0) return;
        const double share = filter_.share(cycles(octave.grid, wave));
        octave.factors[factor] = static_cast<float>(share * potential_of(wave) / octave.grid.window(wave));
    });
}

/// Calls visit(number of the coefficient, wave, index of the factor, index of the target) for the long waves of an
/// octave, including the constant wave. Some calls are in parallel.
template <class P>
template <class Visit>
void OctaveTransport<P>::for_long_waves(const Octave& octave, Visit&& visit) const {
    for_ranges(executor_, octave.lines.size(), kLines, [&](std::size_t begin, std::size_t end) {
        for (std::size_t line = begin; line < end; ++line) {
            const auto [count, factors, targets] = octave.lines[line];
            const std::size_t first = line * octave.grid.line_size();
            Wave wave = octave.grid.first_wave(line);
            for (std::size_t i = 0; i < count; ++i, ++wave[0])
                visit(first + i, std::as_const(wave), factors + i, targets + i);
        }
    });
}

/// Returns the factor that converts a wave's coefficient in the error to its coefficient in the potential, divided by
/// octave 0's window. Not for the constant wave. The unit of length is octave 0's spacing, so values fit a float.
template <class P>
double OctaveTransport<P>::potential_of(const Wave& wave) const {
    const P f = octave_spacing(0) * finest().frequency(wave);
    return -1 / (4 * kPi * kPi * dot(f, f) * finest().window(wave));
}

/// Returns the element of levels_ for a spacing, without the limit of the existing octaves.
template <class P>
std::uint16_t OctaveTransport<P>::level_of(double spacing) const {
    const double level = elementary::log2(spacing / finest_) + kCaution;
    return static_cast<std::uint16_t>(kLevels * std::clamp(level, 0.0, static_cast<double>(kMaxOctaves - 1)));
}

/// Adds octaves up to the highest level of sites, and limits all levels to the existing octaves.
template <class P>
void OctaveTransport<P>::add_octaves(std::uint16_t highest) {
    double largest = 0;
    for (std::size_t axis = 0; axis < kAxes<P>; ++axis) largest = std::max(largest, along(frame_.sides, axis));
    while (static_cast<double>(octaves_.size()) < highest / kLevels + 1 && octave_spacing(octaves_.size()) < largest)
        add_octave();
    const auto last = static_cast<std::uint16_t>(kLevels * static_cast<double>(octaves_.size() - 1));
    for (std::uint16_t& level : levels_) level = std::min(level, last);
}

/// Adds an octave's share of the potential of the wanted density.
/// @param octave  number of the octave whose share of the masses is in the cells of the finest grid
template <class P>
void OctaveTransport<P>::add_targets(std::size_t octave) {
    Grid& grid = finest();
    const auto means =
        grid.along_axes([&](double f, std::size_t axis) { return 1 / sinc(f * along(grid.cell(), axis)); });
    grid.forward();
    grid.with_coefficients([&]<class Coefficient>(std::span<Coefficient> coefficients) {
        using Targets = std::vector<Kept<Coefficient>>;
        if (octave == 0) targets_.emplace<Targets>(octaves_[0].waves());
        auto& targets = std::get<Targets>(targets_);
        for_long_waves(octaves_[0], [&](std::size_t number, const Wave& wave, std::size_t, std::size_t target) {
            const P f = grid.frequency(wave);
            const double cycles = std::sqrt(dot(f, f)) * octave_spacing(octave);
            if (number == 0 || cycles >= filter_.end) return;
            Coefficient coefficient = coefficients[number];
            // On a torus, centres of cells are half a cell beyond the grid points.
            if constexpr (!std::is_same_v<Coefficient, double>) {
                const double phase = -kPi * dot(f, grid.cell());
                coefficient *= Coefficient(elementary::cos(phase), elementary::sin(phase));
            }
            const double share = filter_.share(cycles);
            targets[target] +=
                static_cast<Kept<Coefficient>>(coefficient * Grid::product(share * potential_of(wave), means, wave));
        });
    });
}

template <class P>
void OctaveTransport<P>::set_targets_from_spread(P piece, const std::stop_token& stop) {
    if (!transform(stop)) return;
    const auto means = finest().along_axes([&](double f, std::size_t axis) { return sinc(f * along(piece, axis)); });
    finest().with_coefficients([&]<class Coefficient>(std::span<Coefficient> total) {
        std::vector<Kept<Coefficient>> targets(octaves_[0].waves());
        solve(total);
        for_long_waves(octaves_[0], [&](std::size_t number, const Wave& wave, std::size_t, std::size_t target) {
            targets[target] = static_cast<Kept<Coefficient>>(total[number] * Grid::product(1, means, wave));
        });
        targets_ = std::move(targets);
    });
}

template <class P>
void OctaveTransport<P>::spread(std::span<const P> positions, std::span<const double> weights) {
    const std::size_t unweighted = positions.size() - weights.size();
    std::vector<std::uint16_t> levels(levels_.empty() ? 0 : positions.size());
    for_ranges(executor_, levels.size(), kSites, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) levels[i] = levels_[cell_of(positions[i])];
    });
    std::vector<double> values(levels.empty() && weights.empty() ? 0 : positions.size());
    for (std::size_t octave = 0; octave < octaves_.size(); ++octave) {
        for_ranges(executor_, values.size(), kSites, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                values[i] =
                    (i < unweighted ? 1 : weights[i - unweighted]) * (levels.empty() ? 1 : part(levels[i], octave));
        });
        octaves_[octave].grid.spread(positions, values);
    }
}

template <class P>
bool OctaveTransport<P>::measure(std::span<const P> sites, std::span<const double> weights,
                                 const std::stop_token& stop) {
    if (stop.stop_requested()) return false;
    clear();
    if (frame_.origin == P{}) {
        spread(sites, weights);
    } else {
        std::vector<P> positions(sites.size());
        for_ranges(executor_, sites.size(), kSites, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) positions[i] = frame_.position(sites[i]);
        });
        spread(positions, weights);
    }
    return transform(stop);
}

template <class P>
double OctaveTransport<P>::largest_power(double sites) {
    Grid& grid = finest();
    std::vector<double> largest(octaves_[0].lines.size(), 0);
    grid.with_coefficients([&](auto coefficients) {
        for_long_waves(octaves_[0], [&](std::size_t number, const Wave& wave, std::size_t factor, std::size_t) {
            if (octaves_[0].factors[factor] == 0) return;
            double& own = largest[number / grid.line_size()];
            own = std::max(own, std::norm(coefficients[number] / grid.window(wave)));
        });
    });
    return std::ranges::max(largest) / (grid.copies() * sites);
}

/// Solves Laplace phi = error. Sums the potentials of the long waves of all octaves, each octave up to its own limit.
/// Once the potential of the wanted density is known, subtracts it.
/// @param total  coefficients of octave 0: of the sites on entry, of the potential on return
template <class P>
template <class Coefficient>
void OctaveTransport<P>::solve(std::span<Coefficient> total) {
    const auto* const own = std::get_if<std::vector<Kept<Coefficient>>>(&targets_);
    const std::span<const Kept<Coefficient>> targets = own ? *own : std::span<const Kept<Coefficient>>();
    const std::size_t size = finest().line_size();
    for_ranges(executor_, total.size() / size, kLines, [&](std::size_t begin, std::size_t end) {
        for (std::size_t line = begin; line < end; ++line) {
            const auto [count, first, target] = octaves_[0].lines[line];
            const float* const factors = octaves_[0].factors.data() + first;
            const auto part = total.subspan(line * size, size);
            for (std::size_t i = 0; i < count; ++i) part[i] *= static_cast<double>(factors[i]);
            std::ranges::fill(part.subspan(count), Coefficient{});
            if (targets.empty()) continue;
            const auto known = targets.subspan(target, count);
            for (std::size_t i = 0; i < count; ++i) part[i] -= known[i];
        }
    });
    for (std::size_t octave = 1; octave < octaves_.size(); ++octave) {
        Octave& coarser = octaves_[octave];
        coarser.grid.with_coefficients([&](auto part) {
            if constexpr (std::is_same_v<decltype(part), std::span<Coefficient>>) {
                for_long_waves(coarser, [&](std::size_t number, const Wave& wave, std::size_t factor, std::size_t) {
                    total[finest().number(wave)] += static_cast<double>(coarser.factors[factor]) * part[number];
                });
            }
        });
    }
}

template class OctaveTransport<Point>;
template class OctaveTransport<Point3>;
template void OctaveTransport<Point>::solve(std::span<double>);
template void OctaveTransport<Point>::solve(std::span<std::complex<double>>);
template void OctaveTransport<Point3>::solve(std::span<double>);
template void OctaveTransport<Point3>::solve(std::span<std::complex<double>>);

}  // namespace ccdt
