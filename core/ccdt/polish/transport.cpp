// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/transport.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/base/elementary.h"

namespace ccdt {

namespace {

constexpr std::size_t kCells = 16384, kRows = 16;  ///< cells or rows per task
constexpr double kPi = std::numbers::pi;

constexpr double kCellsPerSpacing = 2;  ///< a grid's highest frequency is one cycle per spacing, just above kShortest
/// Highest frequency considered, in cycles per spacing. share_undone() at this limit is below 1e-16 for uniform
/// densities and 5e-4 for others.
constexpr double kShortest = 0.95;
/// Limit on the density that octave 0 resolves, relative to the mean density. Octave 0 has 4 cells per square of its
/// spacing, hence at most 16 cells per site.
constexpr double kMaxContrast = 4;

// Larger and smaller values of these constants both increase the error of tone (benchmark PictureTone). The exception
// is kLevelSmoothing: a larger value would reduce the error.
constexpr double kSmoothing = 1;  ///< smoothing of the density from which spacings follow, in spacings of octave 0
/// Smoothing of the density from which octaves follow, in spacings of octave 0. Because of this wider smoothing, sparse
/// places near dense ones get finer octaves.
constexpr double kLevelSmoothing = 2;

/// Returns the share of a wave's error that a round removes. The share falls from 1 to 0 around an end frequency. If
/// the density varies, the octaves overlap, so the share must fall more gradually. Lower or higher end frequencies
/// leave more error: benchmarks TorusPattern and PictureTone.
/// @param frequency  frequency of the wave, in cycles per spacing
template <bool kUniform>
double share_undone(double frequency) {
    const double ratio = frequency / (kUniform ? 0.52 : 0.57), squared = ratio * ratio;
    return elementary::exp(kUniform ? -squared * squared * squared : -squared * squared);
}

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
    : executor_(executor), frame_{domain.is_torus(), {}, domain.unit_bounds().max}, sites_(static_cast<double>(sites)) {
    const bool uniform = density.is_uniform();
    CellBlock block;
    Point& sides = frame_.sides;
    if (!uniform) {
        block = frame_.torus ? density.cells() : density.support();
        const Point cell{sides.x / density.width(), sides.y / density.height()};
        frame_.origin = {block.left * cell.x, block.low * cell.y};
        sides = {block.columns() * cell.x, block.rows() * cell.y};
    }
    const double contrast = uniform ? 1 : contrast_of(density, block);
    const double denser = std::min(contrast, kMaxContrast);
    if (contrast > kMaxContrast) denser_.emplace(domain.unit_bounds().max, density, sites_);
    // In a box thinner than the spacing, sites form a single line along the longer side.
    const double finest = std::sqrt(frame_.volume() / (sites_ * denser)),
                 in_line = std::max(sides.x, sides.y) / (sites_ * denser);
    const OctaveTransport<Point>::Filter filter{kCellsPerSpacing, kShortest,
                                                uniform ? share_undone<true> : share_undone<false>};
    octaves_.emplace(frame_, finest, in_line, filter, executor);
    if (uniform || stop.stop_requested()) return;
    const std::vector<double> mass = masses(density, block);
    if (stop.stop_requested()) return;
    assign_octaves(mass, stop);
    if (denser_) {
        set_fine_targets(density, block, stop);
    } else {
        octaves_->set_targets([&](std::size_t cell) { return mass[cell]; }, stop);
    }
}

/// Returns the number of sites that each cell of octave 0 wants.
std::vector<double> Transport::masses(const Density& density, const CellBlock& block) const {
    const auto [columns, rows, layers] = octaves_->finest().cells();
    const auto width = static_cast<std::size_t>(columns), height = static_cast<std::size_t>(rows);
    std::vector<double> mass(width * height);
    for_ranges(executor_, height, kRows, [&, columns = columns, rows = rows](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            const auto values = std::span(mass).subspan(row * width, width);
            density.resample_row(block, columns, rows, static_cast<int>(row), values);
            for (double& m : values) m *= sites_ / density.total();
        }
    });
    return mass;
}

/// Blurs masses by a Gaussian. Returns densities per unit of area, in the memory of octave 0's grid.
std::span<double> Transport::smooth(const std::vector<double>& masses, double sigma) {
    WaveGrid& grid = octaves_->finest();
    const Point cell = grid.cell();
    const double scale = 1 / (grid.scale() * cell.x * cell.y);
    const std::array<std::vector<double>, 2> blurs =
        grid.along_axes([&](double f, std::size_t) { return elementary::exp(-2 * kPi * kPi * sigma * sigma * f * f); });
    std::copy(masses.begin(), masses.end(), grid.grid().begin());
    grid.forward();
    grid.with_coefficients([&](auto coefficients) {
        for_ranges(executor_, coefficients.size(), kCells, [&](std::size_t begin, std::size_t end) {
            for (std::size_t number = begin; number < end; ++number) coefficients[number] *= scale;
        });
        grid.for_waves([&](std::size_t number, const WaveGrid::Wave& wave) {
            coefficients[number] *= WaveGrid::product(1, blurs, wave);
        });
    });
    grid.backward();
    return grid.grid();
}

void Transport::assign_octaves(const std::vector<double>& masses, const std::stop_token& stop) {
    const double finest = octaves_->finest_spacing();
    const double longest = octaves_->octave_spacing(octaves_->kMaxOctaves), sparsest = 1 / (longest * longest);
    const auto for_spacings = [&](std::span<double> densities, auto&& visit) {
        for_ranges(executor_, densities.size(), kCells, [&](std::size_t begin, std::size_t end) {
            for (std::size_t cell = begin; cell < end; ++cell)
                visit(cell, 1 / std::sqrt(std::max(densities[cell], sparsest)));
        });
    };
    spacings_.resize(masses.size());
    for_spacings(smooth(masses, kSmoothing * finest),
                 [&](std::size_t cell, double spacing) { spacings_[cell] = shortened(spacing / finest); });
    const std::span<double> coarse = smooth(masses, kLevelSmoothing * finest);
    for_spacings(coarse, [&](std::size_t cell, double spacing) { coarse[cell] = spacing; });
    octaves_->assign_octaves(
        coarse, [&](std::size_t cell) { return masses[cell]; }, stop);
}

/// Computes the potential of the wanted density if it has more detail than the finest grid resolves. Spreads the
/// density like sites, in pieces no larger than the grid's cells.
void Transport::set_fine_targets(const Density& density, const CellBlock& block, const std::stop_token& stop) {
    const Point cell = octaves_->finest().cell(), sides = frame_.sides;
    const auto pieces = [](double side, double longest) {
        return std::max(1, static_cast<int>(std::ceil(side / longest)));
    };
    const int across = pieces(sides.x / block.columns(), cell.x), up = pieces(sides.y / block.rows(), cell.y);
    const int columns = across * block.columns(), rows = up * block.rows();
    const Point piece{sides.x / columns, sides.y / rows};
    const double weight = sites_ / density.total() / (across * up);
    std::vector<Point> positions(static_cast<std::size_t>(columns));
    std::vector<double> weights(positions.size());
    octaves_->clear();
    for (int row = 0; row < rows; ++row) {
        if (stop.stop_requested()) return;
        for (int column = 0; column < columns; ++column) {
            const auto i = static_cast<std::size_t>(column);
            positions[i] = {(column + 0.5) * piece.x, (row + 0.5) * piece.y};
            weights[i] = weight * std::max(0.0, density.value(block.left + column / across, block.low + row / up));
        }
        octaves_->spread(positions, weights);
    }
    octaves_->set_targets_from_spread(piece, stop);
}

double Transport::spacing(Point p) const {
    const double finest = octaves_->finest_spacing();
    if (spacings_.empty()) return finest;
    const double smooth = finest * lengthened(spacings_[octaves_->cell_of(frame_.position(p))]);
    if (!denser_) return smooth;
    const double local = denser_->at(frame_.torus ? wrapped(p, frame_.sides) : p);
    return local < finest ? local : smooth;
}

bool Transport::displacements(std::span<const Point> sites, std::span<Point> moves, const std::stop_token& stop,
                              std::span<const double> weights) {
    return octaves_->measure(sites, weights, stop) && octaves_->find_moves(
                                                          sites, moves, [this](Point p) { return spacing(p); }, stop);
}

}  // namespace ccdt
