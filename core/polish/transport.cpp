// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/polish/transport.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <type_traits>

namespace ccdt {

namespace {

// Number of sites, cells or rows per task.
constexpr std::size_t kSites = 8192, kCells = 16384, kRows = 16;
constexpr double kPi = std::numbers::pi;

constexpr double kCellsPerSpacing = 2;  ///< a grid's highest frequency is one cycle per spacing, just above kShortest
/// Highest frequency considered, in cycles per spacing. share_undone() at this limit is below 1e-16 for uniform
/// densities and 5e-4 for others.
constexpr double kShortest = 0.95;
/// Longest move, in spacings. Even if two neighbours of a hexagonal grid, 1.07 spacings apart, move straight towards
/// each other, they keep more than half of their distance.
constexpr double kMaxMove = 0.25;
/// Limit on the number of octaves. Six octaves cover spacings of 1 to 32, which are densities of 1 to 1,000. In linear
/// light, pictures of 8 bits give densities of 1 to 113. These are 3.4 octaves of spacing, or 4.1 with kCaution.
constexpr std::size_t kMaxOctaves = 6;
/// Limit on the density that octave 0 resolves, relative to the mean density. Octave 0 has 4 cells per square of its
/// spacing, hence at most 16 cells per site.
constexpr double kMaxContrast = 4;

// Larger and smaller values of these constants both increase the error of tone (benchmark PictureTone). The exception
// is kLevelSmoothing: a larger value would reduce the error.
constexpr double kSmoothing = 1;  ///< smoothing of the density from which spacings follow, in spacings of octave 0
/// Smoothing of the density from which octaves follow, in spacings of octave 0. Because of this wider smoothing, sparse
/// places near dense ones get finer octaves.
constexpr double kLevelSmoothing = 2;
constexpr double kCaution = 0.7;  ///< number of octaves added to the octave that follows from the spacing

/// Returns the share of a wave's error that a round removes. The share falls from 1 to 0 around an end frequency. If
/// the density varies, the octaves overlap, so the share must fall more gradually. Lower or higher end frequencies
/// leave more error: benchmarks TorusPattern and PictureTone.
/// @param frequency  frequency of the wave, in cycles per spacing
double share_undone(double frequency, bool uniform) {
    constexpr double kUniformEnd = 0.52, kVaryingEnd = 0.57;
    const double ratio = frequency / (uniform ? kUniformEnd : kVaryingEnd), squared = ratio * ratio;
    return std::exp(uniform ? -squared * squared * squared : -squared * squared);
}

constexpr double kLevels = 8192;  ///< steps per octave

constexpr auto kFirst = std::bit_cast<std::uint32_t>(0x1p-8f);
constexpr unsigned kDropped = 11;  ///< number of bits of the fraction that are dropped

/// Encodes a number in 16 bits with a relative error of at most 1/8192. Numbers outside [1/256, 256) are clamped.
std::uint16_t shortened(double number) {
    const float bounded = std::clamp(static_cast<float>(number), 0x1p-8f, 0x1.ffep7f);
    return static_cast<std::uint16_t>((std::bit_cast<std::uint32_t>(bounded) - kFirst + (1u << (kDropped - 1))) >>
                                      kDropped);
}
double lengthened(std::uint16_t bits) {
    return static_cast<double>(std::bit_cast<float>((static_cast<std::uint32_t>(bits) << kDropped) + kFirst));
}

/// Single-precision storage of a coefficient.
template <class Coefficient>
using Kept = std::conditional_t<std::is_same_v<Coefficient, double>, float, std::complex<float>>;

double length(Point p) {
    return std::sqrt(dot(p, p));
}

double sinc(double cycles) {
    const double x = kPi * cycles;
    return x == 0 ? 1 : std::sin(x) / x;
}

/// Returns the density at the average site, relative to the mean density.
double contrast_of(const Density& density, const CellBlock& block) {
    double squares = 0;
    for (int row = block.low; row < block.high; ++row) {
        for (int column = block.left; column < block.right; ++column) {
            squares += density.value(column, row) * density.value(column, row);
        }
    }
    const double cells = static_cast<double>(block.columns()) * block.rows();
    return squares / density.total() * cells / density.total();
}

}  // namespace

Transport::Transport(const Domain& domain, const Density& density, std::size_t sites, const std::stop_token& stop,
                     Executor& executor)
    : executor_(executor),
      torus_(domain.is_torus()),
      uniform_(density.is_uniform()),
      sides_(domain.unit_bounds().max),
      sites_(static_cast<double>(sites)) {
    CellBlock block;
    if (!uniform_) {
        block = torus_ ? density.cells() : density.support();
        const Point cell{sides_.x / density.width(), sides_.y / density.height()};
        origin_ = {block.left * cell.x, block.low * cell.y};
        sides_ = {block.columns() * cell.x, block.rows() * cell.y};
    }
    over_sides_ = {1 / sides_.x, 1 / sides_.y};
    const double area = sides_.x * sides_.y;
    const double contrast = uniform_ ? 1 : contrast_of(density, block);
    const double denser = std::min(contrast, kMaxContrast);
    finest_ = std::sqrt(area / (sites_ * denser));
    if (contrast > kMaxContrast) denser_.emplace(domain.unit_bounds().max, density, sites_);
    // In a box thinner than the spacing, sites form a single line.
    in_line_ = std::max(sides_.x, sides_.y) / (sites_ * denser);
    octaves_.reserve(kMaxOctaves);
    add_octave();
    if (uniform_ || stop.stop_requested()) return;
    const std::vector<double> mass = masses(density, block);
    if (stop.stop_requested()) return;
    assign_octaves(mass);
    if (denser_) {
        set_fine_targets(density, block, stop);
    } else {
        set_targets(mass, stop);
    }
}

double Transport::octave_spacing(std::size_t octave) const {
    return std::max(in_line_, finest_ * std::exp2(static_cast<double>(octave)));
}

void Transport::add_octave() {
    constexpr int kMinCells = 8;
    const double spacing = octave_spacing(octaves_.size());
    const auto cells = [&](double side) { return std::max(kMinCells, good_size(kCellsPerSpacing * side / spacing)); };
    octaves_.push_back({SplineGrid(torus_, sides_, cells(sides_.x), cells(sides_.y), executor_), {}});
    Octave& octave = octaves_.back();
    const SplineGrid& grid = octave.grid;
    octave.factors.resize(grid.number(0, torus_ ? grid.rows() / 2 + 1 : grid.rows()));
    grid.for_frequencies([&](std::size_t, int i, int j) {
        const double cycles = length(grid.frequency(i, j)) * spacing;
        if (j >= 0 && cycles > 0 && cycles < kShortest) {
            octave.factor(i, j) =
                static_cast<float>(share_undone(cycles, uniform_) * potential_of(i, j) / grid.window(i, j));
        }
    });
}

/// Returns the factor that converts a wave's coefficient in the error to its coefficient in the potential, divided by
/// octave 0's window. Not for the constant wave. The unit of length is octave 0's spacing, so values fit a float.
double Transport::potential_of(int column, int row) const {
    const SplineGrid& finest = octaves_[0].grid;
    const Point f = octave_spacing(0) * finest.frequency(column, row);
    return -1 / (4 * kPi * kPi * dot(f, f) * finest.window(column, row));
}

/// Returns the number of sites that each cell of octave 0 wants.
std::vector<double> Transport::masses(const Density& density, const CellBlock& block) const {
    const SplineGrid& grid = octaves_[0].grid;
    const auto columns = static_cast<std::size_t>(grid.columns()), rows = static_cast<std::size_t>(grid.rows());
    std::vector<double> mass(columns * rows);
    for_ranges(executor_, rows, kRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            const auto values = std::span(mass).subspan(row * columns, columns);
            density.resample_row(block, grid.columns(), grid.rows(), static_cast<int>(row), values);
            for (double& m : values) m *= sites_ / density.total();
        }
    });
    return mass;
}

/// Evaluates a function of frequency along each axis of a grid: once for every column (frequency along x) and once for
/// every row (frequency along y).
template <class Function>
std::array<std::vector<double>, 2> along_axes(const SplineGrid& grid, Function&& function) {
    std::array<std::vector<double>, 2> values;
    for (int i = 0; i < grid.columns(); ++i) values[0].push_back(function(grid.frequency(i, 0).x, grid.cell().x));
    for (int j = 0; j < grid.rows(); ++j) values[1].push_back(function(grid.frequency(0, j).y, grid.cell().y));
    return values;
}

/// Blurs masses by a Gaussian. Returns densities per unit of area, in the memory of octave 0's grid.
std::span<const double> Transport::smooth(const std::vector<double>& masses, double sigma) {
    SplineGrid& grid = octaves_[0].grid;
    const Point cell = grid.cell();
    const double scale = 1 / (grid.cells() * cell.x * cell.y);
    const auto [across, up] =
        along_axes(grid, [&](double f, double) { return std::exp(-2 * kPi * kPi * sigma * sigma * f * f); });
    std::copy(masses.begin(), masses.end(), grid.grid().begin());
    grid.forward();
    grid.with_coefficients([&, &across = across, &up = up](auto coefficients) {
        for_ranges(executor_, coefficients.size(), kCells, [&](std::size_t begin, std::size_t end) {
            for (std::size_t number = begin; number < end; ++number) coefficients[number] *= scale;
        });
        grid.for_frequencies([&](std::size_t number, int i, int j) {
            coefficients[number] *= across[static_cast<std::size_t>(i)] * up[static_cast<std::size_t>(std::abs(j))];
        });
    });
    grid.backward();
    return grid.grid();
}

void Transport::assign_octaves(const std::vector<double>& masses) {
    const double sparsest = 1 / std::pow(octave_spacing(kMaxOctaves), 2);
    const auto spacing_at = [&](double density) { return 1 / std::sqrt(std::max(density, sparsest)); };
    levels_.resize(masses.size());
    spacings_.resize(masses.size());
    const auto fine = smooth(masses, kSmoothing * finest_);
    for_ranges(executor_, masses.size(), kCells, [&](std::size_t begin, std::size_t end) {
        for (std::size_t cell = begin; cell < end; ++cell)
            spacings_[cell] = shortened(spacing_at(fine[cell]) / finest_);
    });
    const auto coarse = smooth(masses, kLevelSmoothing * finest_);
    std::vector<double> highest((masses.size() + kCells - 1) / kCells, 0);
    for_ranges(executor_, masses.size(), kCells, [&](std::size_t begin, std::size_t end) {
        double& own = highest[begin / kCells];
        for (std::size_t cell = begin; cell < end; ++cell) {
            const double level = std::log2(spacing_at(coarse[cell]) / finest_) + kCaution;
            const double bounded = std::clamp(level, 0.0, static_cast<double>(kMaxOctaves - 1));
            levels_[cell] = static_cast<std::uint16_t>(kLevels * bounded);
            if (masses[cell] > 0) own = std::max(own, levels_[cell] / kLevels);
        }
    });
    const double largest = std::max(sides_.x, sides_.y);
    while (static_cast<double>(octaves_.size()) < std::ranges::max(highest) + 1 &&
           octave_spacing(octaves_.size()) < largest)
        add_octave();
    const auto last = static_cast<std::uint16_t>(kLevels * static_cast<double>(octaves_.size() - 1));
    for (std::uint16_t& level : levels_) level = std::min(level, last);
}

/// Computes the potential of the wanted density, which is spread on the grid like sites.
void Transport::set_targets(const std::vector<double>& masses, const std::stop_token& stop) {
    SplineGrid& grid = octaves_[0].grid;
    const Point cell = grid.cell();
    const auto [across, up] = along_axes(grid, [](double f, double side) { return 1 / sinc(f * side); });
    grid.with_coefficients([&]<class Coefficient>(std::span<Coefficient>) {
        targets_.emplace<std::vector<Kept<Coefficient>>>(grid.coefficient_count());
    });
    for (std::size_t octave = 0; octave < octaves_.size() && !stop.stop_requested(); ++octave) {
        for_ranges(executor_, masses.size(), kCells, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) grid.grid()[i] = masses[i] * part(levels_[i], octave);
        });
        grid.forward();
        const double highest = std::pow(kShortest / octave_spacing(octave), 2);
        grid.with_coefficients([&, &across = across, &up = up]<class Coefficient>(std::span<Coefficient> coefficients) {
            auto& targets = std::get<std::vector<Kept<Coefficient>>>(targets_);
            grid.for_frequencies([&](std::size_t number, int i, int j) {
                const Point f = grid.frequency(i, j);
                if (number == 0 || dot(f, f) >= highest) return;
                Coefficient coefficient = coefficients[number];
                // On a torus, centres of cells are half a cell beyond the grid points.
                if constexpr (!std::is_same_v<Coefficient, double>)
                    coefficient *= std::polar(1.0, -kPi * (f.x * cell.x + f.y * cell.y));
                targets[number] += static_cast<Kept<Coefficient>>(
                    coefficient * (share_undone(length(f) * octave_spacing(octave), uniform_) * potential_of(i, j) *
                                   across[static_cast<std::size_t>(i)] * up[static_cast<std::size_t>(std::abs(j))]));
            });
        });
    }
}

/// Computes the potential of the wanted density if it has more detail than the finest grid resolves. Spreads the
/// density like sites, in pieces no larger than the grid's cells.
void Transport::set_fine_targets(const Density& density, const CellBlock& block, const std::stop_token& stop) {
    const Point cell = octaves_[0].grid.cell();
    const auto pieces = [](double side, double longest) {
        return std::max(1, static_cast<int>(std::ceil(side / longest)));
    };
    const int across = pieces(sides_.x / block.columns(), cell.x), up = pieces(sides_.y / block.rows(), cell.y);
    const int columns = across * block.columns(), rows = up * block.rows();
    const Point piece{sides_.x / columns, sides_.y / rows};
    const double weight = sites_ / density.total() / (across * up);
    clear();
    for (int row = 0; row < rows; ++row) {
        if (stop.stop_requested()) return;
        for (int column = 0; column < columns; ++column) {
            const double value = density.value(block.left + column / across, block.low + row / up);
            if (value > 0) spread({(column + 0.5) * piece.x, (row + 0.5) * piece.y}, weight * value);
        }
    }
    if (!transform(stop)) return;
    octaves_[0].grid.with_coefficients([&]<class Coefficient>(std::span<Coefficient> total) {
        std::vector<Kept<Coefficient>> targets(octaves_[0].grid.coefficient_count());
        solve(total);
        octaves_[0].grid.for_frequencies([&](std::size_t number, int i, int j) {
            const Point f = octaves_[0].grid.frequency(i, j);
            targets[number] =
                static_cast<Kept<Coefficient>>(total[number] * (sinc(f.x * piece.x) * sinc(f.y * piece.y)));
        });
        targets_ = std::move(targets);
    });
}

/// Returns the nearest position in the grids' box, relative to the box's lower left corner.
inline Point Transport::in_box(Point p) const {
    if (torus_) return p;
    return {std::clamp(p.x - origin_.x, 0.0, sides_.x), std::clamp(p.y - origin_.y, 0.0, sides_.y)};
}

/// Returns the cell of octave 0 that contains a position.
/// @param p  in the grids' box
inline std::size_t Transport::cell_of(Point p) const {
    const SplineGrid& grid = octaves_[0].grid;
    const auto index = [&](double share, int cells) {
        share = torus_ ? share - whole(share) : std::clamp(share, 0.0, 1.0);
        return static_cast<std::size_t>(std::min(static_cast<int>(share * cells), cells - 1));
    };
    return index(p.y * over_sides_.y, grid.rows()) * static_cast<std::size_t>(grid.columns()) +
           index(p.x * over_sides_.x, grid.columns());
}

/// Returns the weight with which sites count in an octave. The spacing of the sites usually lies between two octaves,
/// which then share the weight. The weights of all octaves add up to 1.
/// @param level  an element of levels_: the fractional octave of the sites, multiplied by kLevels
double Transport::part(std::uint16_t level, std::size_t octave) {
    const double distance = std::abs(level / kLevels - static_cast<double>(octave));
    return std::max(0.0, 1 - distance);
}

double Transport::spacing(Point p) const {
    if (spacings_.empty()) return finest_;
    const double smooth = finest_ * lengthened(spacings_[cell_of(in_box(p))]);
    if (!denser_) return smooth;
    const double local = denser_->at(torus_ ? wrapped(p, sides_) : p);
    return local < finest_ ? local : smooth;
}

void Transport::clear() {
    for (Octave& octave : octaves_) octave.grid.clear();
}

/// Spreads a site on the grids of its octaves.
/// @param p  in the grids' box
void Transport::spread(Point p, double weight) {
    if (levels_.empty()) return octaves_[0].grid.spread(p, weight);
    const std::size_t cell = cell_of(p);
    const auto lower = static_cast<std::size_t>(levels_[cell] / kLevels);
    for (std::size_t octave = lower; octave < std::min(lower + 2, octaves_.size()); ++octave) {
        const double share = part(levels_[cell], octave);
        if (share > 0) octaves_[octave].grid.spread(p, weight * share);
    }
}

/// Computes the coefficients of the values that were spread on the grids of all octaves.
/// @returns  false after a stop
bool Transport::transform(const std::stop_token& stop) {
    for (Octave& octave : octaves_) {
        if (stop.stop_requested()) return false;
        octave.grid.transform();
    }
    return true;
}

/// Spreads all sites on the grids, and transforms the grids.
/// @returns  false after a stop
bool Transport::spread(std::span<const Point> sites, std::span<const double> weights, const std::stop_token& stop) {
    const auto weight = [&](std::size_t i) {
        const std::size_t whole = sites.size() - weights.size();
        return i < whole ? 1 : weights[i - whole];
    };
    clear();
    std::vector<double> values;
    if (levels_.empty()) {
        for (std::size_t i = 0; !weights.empty() && i < sites.size(); ++i) values.push_back(weight(i));
        octaves_[0].grid.spread(sites, values);  // here octave 0 covers the whole box
        return transform(stop);
    }
    std::vector<Point> moved;  // positions relative to the box's corner; empty if this corner is the origin
    if (!(origin_ == Point{})) moved.resize(sites.size());
    const std::span<const Point> places = moved.empty() ? sites : moved;
    std::vector<std::uint16_t> levels(sites.size());
    for_ranges(executor_, sites.size(), kSites, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!moved.empty()) moved[i] = in_box(sites[i]);
            levels[i] = levels_[cell_of(places[i])];
        }
    });
    values.resize(sites.size());
    for (std::size_t octave = 0; octave < octaves_.size(); ++octave) {
        if (stop.stop_requested()) return false;
        for_ranges(executor_, sites.size(), kSites, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) values[i] = weight(i) * part(levels[i], octave);
        });
        octaves_[octave].grid.spread(places, values);
    }
    return transform(stop);
}

/// Solves Laplace phi = error. Sums the long waves of all octaves, each octave up to its own limit. Once the potential
/// of the wanted density is known, subtracts it.
/// @param total  coefficients of octave 0: of the sites on entry, of the potential on return
template <class Coefficient>
void Transport::solve(std::span<Coefficient> total) {
    const SplineGrid& finest = octaves_[0].grid;
    const auto* const own = std::get_if<std::vector<Kept<Coefficient>>>(&targets_);
    const std::span<const Kept<Coefficient>> targets = own ? *own : std::span<const Kept<Coefficient>>();
    const std::size_t columns = finest.number(0, 1);
    for_ranges(executor_, static_cast<std::size_t>(finest.rows()), kRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            const float* const factors = &octaves_[0].factor(0, finest.signed_row(static_cast<int>(row)));
            const auto part = total.subspan(row * columns, columns);
            for (std::size_t i = 0; i < columns; ++i) part[i] *= static_cast<double>(factors[i]);
            if (targets.empty()) continue;
            const auto known = targets.subspan(row * columns, columns);
            for (std::size_t i = 0; i < columns; ++i) part[i] -= known[i];
        }
    });
    for (std::size_t octave = 1; octave < octaves_.size(); ++octave) {
        Octave& coarser = octaves_[octave];
        coarser.grid.with_coefficients([&](auto part) {
            if constexpr (std::is_same_v<decltype(part), std::span<Coefficient>>) {
                coarser.grid.for_frequencies([&](std::size_t number, int i, int j) {
                    const auto factor = static_cast<double>(coarser.factor(i, j));
                    if (factor != 0) total[finest.number(i, j)] += factor * part[number];
                });
            }
        });
    }
}

void Transport::release_memory() {
    for (Octave& octave : octaves_) octave.grid.release_memory();
}

bool Transport::displacements(std::span<const Point> sites, std::span<Point> moves, const std::stop_token& stop,
                              std::span<const double> weights) {
    if (!spread(sites, weights, stop) || stop.stop_requested()) return false;
    SplineGrid& finest = octaves_[0].grid;
    finest.with_coefficients([&](auto total) { solve(total); });
    if (stop.stop_requested()) return false;
    finest.transform_back();
    const double unit = octave_spacing(0), area = sides_.x * sides_.y;
    const double scale = unit * unit / (finest.copies() * area);
    for_ranges(executor_, sites.size(), kSites, [&](std::size_t begin, std::size_t end) {
        if (stop.stop_requested()) return;
        for (std::size_t i = begin; i < end; ++i) moves[i] = in_box(sites[i]);
        finest.gradients(moves.subspan(begin, end - begin), moves.subspan(begin, end - begin));
        for (std::size_t i = begin; i < end; ++i) {
            const double spacing = this->spacing(sites[i]);
            const Point move = (scale * spacing * spacing) * moves[i];
            const double longest = kMaxMove * spacing, distance = length(move);
            moves[i] = distance > longest ? (longest / distance) * move : move;
        }
    });
    return !stop.stop_requested();
}

}  // namespace ccdt
