// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/polish/octave_transport.h"

#include <array>
#include <numbers>
#include <type_traits>

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
    octaves_.push_back({Grid(frame_.torus, frame_.sides, cells, executor_), {}});
    Octave& octave = octaves_.back();
    const Grid& grid = octave.grid;
    const auto last = [&](std::size_t axis) { return frame_.torus ? cells[axis] / 2 : cells[axis] - 1; };
    octave.factors.resize(grid.number({last(0), last(1), last(2)}) + 1);
    grid.for_waves([&](std::size_t, const Wave& wave) {
        const P f = grid.frequency(wave);
        const double cycles = std::sqrt(dot(f, f)) * spacing;
        if (cycles > 0 && cycles < filter_.end && wave[1] >= 0 && wave[2] >= 0)
            octave.factor(wave) = static_cast<float>(filter_.share(cycles) * potential_of(wave) / grid.window(wave));
    });
}

/// Returns the factor that converts a wave's coefficient in the error to its coefficient in the potential, divided by
/// octave 0's window. Not for the constant wave. The unit of length is octave 0's spacing, so values fit a float.
template <class P>
double OctaveTransport<P>::potential_of(const Wave& wave) const {
    const P f = octave_spacing(0) * finest().frequency(wave);
    return -1 / (4 * kPi * kPi * dot(f, f) * finest().window(wave));
}

template <class P>
void OctaveTransport<P>::assign_octaves(std::span<const double> spacings, std::span<const double> masses) {
    levels_.resize(masses.size());
    std::vector<double> highest((masses.size() + kCells - 1) / kCells, 0);
    for_ranges(executor_, masses.size(), kCells, [&](std::size_t begin, std::size_t end) {
        double& own = highest[begin / kCells];
        for (std::size_t cell = begin; cell < end; ++cell) {
            const double level = std::log2(spacings[cell] / finest_) + kCaution;
            const double bounded = std::clamp(level, 0.0, static_cast<double>(kMaxOctaves - 1));
            levels_[cell] = static_cast<std::uint16_t>(kLevels * bounded);
            if (masses[cell] > 0) own = std::max(own, levels_[cell] / kLevels);
        }
    });
    double largest = 0;
    for (std::size_t axis = 0; axis < kAxes<P>; ++axis) largest = std::max(largest, along(frame_.sides, axis));
    while (static_cast<double>(octaves_.size()) < std::ranges::max(highest) + 1 &&
           octave_spacing(octaves_.size()) < largest)
        add_octave();
    const auto last = static_cast<std::uint16_t>(kLevels * static_cast<double>(octaves_.size() - 1));
    for (std::uint16_t& level : levels_) level = std::min(level, last);
}

/// Computes the potential of the wanted density, which is spread on the grid like sites.
template <class P>
void OctaveTransport<P>::set_targets(std::span<const double> masses, const std::stop_token& stop) {
    Grid& grid = finest();
    const auto means =
        grid.along_axes([&](double f, std::size_t axis) { return 1 / sinc(f * along(grid.cell(), axis)); });
    grid.with_coefficients([&]<class Coefficient>(std::span<Coefficient>) {
        targets_.emplace<std::vector<Kept<Coefficient>>>(grid.coefficient_count());
    });
    for (std::size_t octave = 0; octave < octaves_.size() && !stop.stop_requested(); ++octave) {
        const std::span<double> values = grid.grid();
        for_ranges(executor_, masses.size(), kCells, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                values[i] = masses[i] * (levels_.empty() ? 1 : part(levels_[i], octave));
        });
        grid.forward();
        grid.with_coefficients([&]<class Coefficient>(std::span<Coefficient> coefficients) {
            auto& targets = std::get<std::vector<Kept<Coefficient>>>(targets_);
            grid.for_waves([&](std::size_t number, const Wave& wave) {
                const P f = grid.frequency(wave);
                const double cycles = std::sqrt(dot(f, f)) * octave_spacing(octave);
                if (number == 0 || cycles >= filter_.end) return;
                Coefficient coefficient = coefficients[number];
                // On a torus, centres of cells are half a cell beyond the grid points.
                if constexpr (!std::is_same_v<Coefficient, double>)
                    coefficient *= std::polar(1.0, -kPi * dot(f, grid.cell()));
                const double share = filter_.share(cycles);
                targets[number] += static_cast<Kept<Coefficient>>(
                    coefficient * Grid::product(share * potential_of(wave), means, wave));
            });
        });
    }
}

template <class P>
void OctaveTransport<P>::set_targets_from_spread(P piece, const std::stop_token& stop) {
    if (!transform(stop)) return;
    const auto means = finest().along_axes([&](double f, std::size_t axis) { return sinc(f * along(piece, axis)); });
    finest().with_coefficients([&]<class Coefficient>(std::span<Coefficient> total) {
        std::vector<Kept<Coefficient>> targets(finest().coefficient_count());
        solve(total);
        finest().for_waves([&](std::size_t number, const Wave& wave) {
            targets[number] = static_cast<Kept<Coefficient>>(total[number] * Grid::product(1, means, wave));
        });
        targets_ = std::move(targets);
    });
}

template <class P>
void OctaveTransport<P>::spread(std::span<const P> places, std::span<const double> weights) {
    const std::size_t unweighted = places.size() - weights.size();
    std::vector<std::uint16_t> levels(levels_.empty() ? 0 : places.size());
    for_ranges(executor_, levels.size(), kSites, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) levels[i] = levels_[cell_of(places[i])];
    });
    std::vector<double> values(levels.empty() && weights.empty() ? 0 : places.size());
    for (std::size_t octave = 0; octave < octaves_.size(); ++octave) {
        for_ranges(executor_, values.size(), kSites, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                values[i] =
                    (i < unweighted ? 1 : weights[i - unweighted]) * (levels.empty() ? 1 : part(levels[i], octave));
        });
        octaves_[octave].grid.spread(places, values);
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
        std::vector<P> places(sites.size());
        for_ranges(executor_, sites.size(), kSites, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) places[i] = frame_.place(sites[i]);
        });
        spread(places, weights);
    }
    return transform(stop);
}

template <class P>
double OctaveTransport<P>::largest_power(double sites) {
    Octave& octave = octaves_[0];
    const Grid& grid = octave.grid;
    std::vector<double> largest(grid.coefficient_count() / grid.line_size(), 0);
    octave.grid.with_coefficients([&](auto coefficients) {
        grid.for_waves([&](std::size_t number, const Wave& wave) {
            if (octave.factor(wave) == 0) return;
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
            const float* const factors = &octaves_[0].factor(finest().first_wave(line));
            const auto part = total.subspan(line * size, size);
            for (std::size_t i = 0; i < size; ++i) part[i] *= static_cast<double>(factors[i]);
            if (targets.empty()) continue;
            const auto known = targets.subspan(line * size, size);
            for (std::size_t i = 0; i < size; ++i) part[i] -= known[i];
        }
    });
    for (std::size_t octave = 1; octave < octaves_.size(); ++octave) {
        Octave& coarser = octaves_[octave];
        coarser.grid.with_coefficients([&](auto part) {
            if constexpr (std::is_same_v<decltype(part), std::span<Coefficient>>) {
                coarser.grid.for_waves([&](std::size_t number, const Wave& wave) {
                    const auto factor = static_cast<double>(coarser.factor(wave));
                    if (factor != 0) total[finest().number(wave)] += factor * part[number];
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
