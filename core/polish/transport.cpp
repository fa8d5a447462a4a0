#include "core/polish/transport.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <type_traits>

namespace ccdt {

namespace {

constexpr std::size_t kStopStride = 65536;  ///< sites between two looks at the stop token
constexpr double kPi = 3.141592653589793;
constexpr double kCellsPerSpacing = 2;
constexpr double kShortest = 0.95;     ///< highest frequency that is looked at, in cycles a spacing
constexpr double kLongestMove = 0.25;  ///< in spacings
constexpr std::size_t kMostOctaves = 6;
constexpr double kMostContrast = 4;  ///< of the finest spacing's density over the mean one
constexpr double kSmoothing = 1;     ///< of the density that spacings are taken from, in finest spacings
constexpr double kLevelSmoothing =
    2;                            ///< of the one that octaves are taken from: next to dark parts light ones are fine
constexpr double kCaution = 0.7;  ///< octaves by which a site's limit lies above its spacing

/// How much of a wave's error a round undoes; its frequency in cycles a spacing. Octaves of a varying density overlap
/// and want a softer end.
double share_undone(double frequency, bool uniform) {
    const double ratio = frequency / (uniform ? 0.52 : 0.57), squared = ratio * ratio;
    return std::exp(uniform ? -squared * squared * squared : -squared * squared);
}

double length(Point p) {
    return std::sqrt(dot(p, p));
}

double sinc(double cycles) {
    const double x = kPi * cycles;
    return x == 0 ? 1 : std::sin(x) / x;
}

/// Density that the average site stands in, over the mean density.
double contrast(const Density& density) {
    double squares = 0;
    for (int row = 0; row < density.height(); ++row) {
        for (int column = 0; column < density.width(); ++column) {
            squares += density.value(column, row) * density.value(column, row);
        }
    }
    const double cells = static_cast<double>(density.width()) * density.height();
    return squares / density.total() * cells / density.total();
}

}  // namespace

Transport::Transport(const Domain& domain, const Density& density, std::size_t sites, const std::stop_token& stop)
    : torus_(domain.is_torus()),
      uniform_(density.is_uniform()),
      sides_(domain.unit_bounds().max),
      sites_(static_cast<double>(sites)) {
    const double area = sides_.x * sides_.y;
    const double denser = uniform_ ? 1 : std::min(contrast(density), kMostContrast);
    finest_ = std::sqrt(area / (sites_ * denser));
    // In a box thinner than its sites' spacing they stand in a line.
    in_line_ = std::max(sides_.x, sides_.y) / (sites_ * denser);
    octaves_.reserve(kMostOctaves);
    add_octave();
    if (stop.stop_requested()) return;
    const SplineGrid& grid = octaves_[0].grid;
    to_potential_.resize(grid.coefficient_count());
    grid.for_frequencies([&](std::size_t number, int i, int j) {
        const Point f = grid.frequency(i, j);
        if (i == 0 && j == 0) return;
        to_potential_[number] = -1 / (4 * kPi * kPi * dot(f, f) * grid.window(i, j) * grid.copies() * area);
    });
    if (uniform_ || stop.stop_requested()) return;
    const std::vector<double> mass = masses(density);
    if (stop.stop_requested()) return;
    assign_octaves(mass);
    set_targets(mass, stop);
}

double Transport::octave_spacing(std::size_t octave) const {
    return std::max(in_line_, finest_ * std::exp2(static_cast<double>(octave)));
}

void Transport::add_octave() {
    constexpr int kFewestCells = 8;
    const double spacing = octave_spacing(octaves_.size());
    const auto cells = [&](double side) {
        return std::max(kFewestCells, good_size(kCellsPerSpacing * side / spacing));
    };
    octaves_.push_back({SplineGrid(torus_, sides_, cells(sides_.x), cells(sides_.y)), {}});
    Octave& octave = octaves_.back();
    const SplineGrid& grid = octave.grid;
    octave.factors.resize(grid.coefficient_count());
    grid.for_frequencies([&](std::size_t number, int i, int j) {
        const Point f = grid.frequency(i, j);
        const double cycles = length(f) * spacing;
        if (cycles > 0 && cycles < kShortest)
            octave.factors[number] = share_undone(cycles, uniform_) / grid.window(i, j);
    });
}

/// Sites that each cell of octave 0 wants.
std::vector<double> Transport::masses(const Density& density) const {
    const SplineGrid& grid = octaves_[0].grid;
    const auto columns = static_cast<std::size_t>(grid.columns()), rows = static_cast<std::size_t>(grid.rows());
    std::vector<double> mass(columns * rows);
    for (std::size_t row = 0; row < rows; ++row) {
        density.resample_row(grid.columns(), grid.rows(), static_cast<int>(row),
                             std::span(mass).subspan(row * columns, columns));
    }
    for (double& m : mass) m *= sites_ / density.total();
    return mass;
}

/// A function of a grid's frequencies along x, for its columns, and along y, for its rows.
template <class Function>
std::array<std::vector<double>, 2> along_axes(const SplineGrid& grid, Function&& function) {
    std::array<std::vector<double>, 2> values;
    for (int i = 0; i < grid.columns(); ++i) values[0].push_back(function(grid.frequency(i, 0).x, grid.cell().x));
    for (int j = 0; j < grid.rows(); ++j) values[1].push_back(function(grid.frequency(0, j).y, grid.cell().y));
    return values;
}

/// Blurred by a Gaussian, per unit of area.
std::vector<double> Transport::smoothed(const std::vector<double>& masses, double sigma) {
    SplineGrid& grid = octaves_[0].grid;
    const Point cell = grid.cell();
    const double scale = 1 / (grid.cells() * cell.x * cell.y);
    const auto [across, up] =
        along_axes(grid, [&](double f, double) { return std::exp(-2 * kPi * kPi * sigma * sigma * f * f); });
    std::copy(masses.begin(), masses.end(), grid.grid().begin());
    grid.forward();
    grid.with_coefficients([&, &across = across, &up = up](auto coefficients) {
        for (auto& coefficient : coefficients) coefficient *= scale;
        grid.for_frequencies([&](std::size_t number, int i, int j) {
            coefficients[number] *= across[static_cast<std::size_t>(i)] * up[static_cast<std::size_t>(std::abs(j))];
        });
    });
    grid.backward();
    return {grid.grid().begin(), grid.grid().end()};
}

void Transport::assign_octaves(const std::vector<double>& masses) {
    const double sparsest = 1 / std::pow(octave_spacing(kMostOctaves), 2);
    const std::vector<double> fine = smoothed(masses, kSmoothing * finest_);
    const std::vector<double> coarse = smoothed(masses, kLevelSmoothing * finest_);
    levels_.resize(masses.size());
    spacings_.resize(masses.size());
    double highest = 0;
    for (std::size_t cell = 0; cell < masses.size(); ++cell) {
        spacings_[cell] = static_cast<float>(1 / std::sqrt(std::max(fine[cell], sparsest)));
        const double spacing = 1 / std::sqrt(std::max(coarse[cell], sparsest));
        const double level = std::log2(spacing / finest_) + kCaution;
        levels_[cell] = static_cast<float>(std::clamp(level, 0.0, static_cast<double>(kMostOctaves - 1)));
        if (masses[cell] > 0) highest = std::max(highest, static_cast<double>(levels_[cell]));
    }
    const double largest = std::max(sides_.x, sides_.y);
    while (static_cast<double>(octaves_.size()) < highest + 1 && octave_spacing(octaves_.size()) < largest)
        add_octave();
    const auto last = static_cast<float>(octaves_.size() - 1);
    for (float& level : levels_) level = std::min(level, last);
}

/// The density's coefficients, as sites spread by it would have them.
void Transport::set_targets(const std::vector<double>& masses, const std::stop_token& stop) {
    SplineGrid& grid = octaves_[0].grid;
    const Point cell = grid.cell();
    const auto [across, up] = along_axes(grid, [](double f, double side) { return 1 / sinc(f * side); });
    targets_.assign(grid.coefficient_count(), 0);
    for (std::size_t octave = 0; octave < octaves_.size() && !stop.stop_requested(); ++octave) {
        for (std::size_t i = 0; i < masses.size(); ++i) grid.grid()[i] = masses[i] * part(i, octave);
        grid.forward();
        const double highest = std::pow(kShortest / octave_spacing(octave), 2);
        grid.with_coefficients([&, &across = across, &up = up](auto coefficients) {
            grid.for_frequencies([&](std::size_t number, int i, int j) {
                const Point f = grid.frequency(i, j);
                if (dot(f, f) >= highest) return;
                std::complex<double> coefficient = coefficients[number];
                // Cells' middles lie half a cell beyond a torus' grid points.
                if (torus_) coefficient *= std::polar(1.0, -kPi * (f.x * cell.x + f.y * cell.y));
                targets_[number] +=
                    coefficient * (share_undone(length(f) * octave_spacing(octave), uniform_) *
                                   across[static_cast<std::size_t>(i)] * up[static_cast<std::size_t>(std::abs(j))]);
            });
        });
    }
}

std::size_t Transport::cell_of(Point p) const {
    const SplineGrid& grid = octaves_[0].grid;
    const auto index = [&](double share, int cells) {
        share = torus_ ? share - whole(share) : std::clamp(share, 0.0, 1.0);
        return static_cast<std::size_t>(std::min(static_cast<int>(share * cells), cells - 1));
    };
    return index(p.y / sides_.y, grid.rows()) * static_cast<std::size_t>(grid.columns()) +
           index(p.x / sides_.x, grid.columns());
}

/// Share of an octave in what stands in a cell.
double Transport::part(std::size_t cell, std::size_t octave) const {
    const double distance = std::abs(static_cast<double>(levels_[cell]) - static_cast<double>(octave));
    return std::max(0.0, 1 - distance);
}

double Transport::spacing(Point p) const {
    return spacings_.empty() ? finest_ : static_cast<double>(spacings_[cell_of(p)]);
}

/// @returns  false if it was stopped
bool Transport::spread(std::span<const Point> sites, const std::stop_token& stop) {
    for (Octave& octave : octaves_) octave.grid.clear();
    for (std::size_t i = 0; i < sites.size(); ++i) {
        if (i % kStopStride == 0 && stop.stop_requested()) return false;
        const Point p = sites[i];
        if (levels_.empty()) {
            octaves_[0].grid.spread(p, 1);
            continue;
        }
        const std::size_t cell = cell_of(p);
        const auto lower = static_cast<std::size_t>(levels_[cell]);
        for (std::size_t octave = lower; octave < std::min(lower + 2, octaves_.size()); ++octave) {
            SplineGrid& grid = octaves_[octave].grid;
            const double share = part(cell, octave);
            if (share > 0) grid.spread(p, share);
        }
    }
    for (Octave& octave : octaves_) {
        if (stop.stop_requested()) return false;
        octave.grid.transform();
    }
    return true;
}

/// @param total  coefficients of octave 0; from its sites' to the potential's
template <class Coefficient>
void Transport::solve(std::span<Coefficient> total) {
    const SplineGrid& finest = octaves_[0].grid;
    for (std::size_t number = 0; number < total.size(); ++number) total[number] *= octaves_[0].factors[number];
    for (std::size_t octave = 1; octave < octaves_.size(); ++octave) {
        auto& [grid, factors] = octaves_[octave];
        grid.with_coefficients([&, &grid = grid, &factors = factors](auto part) {
            if constexpr (std::is_same_v<decltype(part), std::span<Coefficient>>) {
                grid.for_frequencies([&](std::size_t number, int i, int j) {
                    if (factors[number] != 0) total[finest.number(i, j)] += factors[number] * part[number];
                });
            }
        });
    }
    for (std::size_t number = 0; number < total.size(); ++number) {
        if (!targets_.empty()) {
            if constexpr (std::is_same_v<Coefficient, double>) {
                total[number] -= targets_[number].real();
            } else {
                total[number] -= targets_[number];
            }
        }
        total[number] *= to_potential_[number];
    }
}

bool Transport::displacements(std::span<const Point> sites, std::span<Point> moves, const std::stop_token& stop) {
    if (!spread(sites, stop) || stop.stop_requested()) return false;
    SplineGrid& finest = octaves_[0].grid;
    finest.with_coefficients([&](auto total) { solve(total); });
    if (stop.stop_requested()) return false;
    finest.transform_back();
    for (std::size_t i = 0; i < sites.size(); ++i) {
        if (i % kStopStride == 0 && stop.stop_requested()) return false;
        const double spacing = this->spacing(sites[i]);
        const Point move = (spacing * spacing) * finest.gradient(sites[i]);
        const double longest = kLongestMove * spacing, distance = length(move);
        moves[i] = distance > longest ? (longest / distance) * move : move;
    }
    return true;
}

}  // namespace ccdt
