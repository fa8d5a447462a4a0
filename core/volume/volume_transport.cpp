// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/volume/volume_transport.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <type_traits>

namespace ccdt {

namespace {

constexpr double kPi = std::numbers::pi;
/// Upper limit of the removed frequencies of a uniform density, in cycles per mean spacing. It is just above half the
/// principal frequency of the densest packing, 0.5456.
constexpr double kLimit = 0.55;
/// Cells per spacing: 3.3 cells per cycle of the highest frequency or, if the grid must be precise, nearly six. See
/// WaveGrid for the errors.
constexpr double kCellsPerSpacing = 1.8, kPreciseCells = 3.2;
constexpr double kMaxMove = 0.25;    ///< longest move, in spacings
constexpr std::size_t kSites = 512;  ///< sites per task
constexpr std::size_t kMaxOctaves = 5;
/// Largest density that octave 0 resolves, relative to the mean density.
constexpr double kMaxContrast = 4;
/// The grid of octave 0 has at most kMostVolumes times the cells that a domain needs that fills its bounding box, or
/// kFewestCells if that is more. A solid that fills a small part of its bounding box reaches this limit.
constexpr double kMostVolumes = 3.8, kFewestCells = 1 << 17;
constexpr double kCaution = 0.7;  ///< is added to the fractional octave that follows from the spacing

/// Returns the share of a wave's error that a round removes.
/// @param frequency  in cycles per spacing
double share_removed(double frequency, bool uniform) {
    constexpr double kVaryingEnd = 0.5;
    if (uniform) return frequency < kLimit ? 1 : 0;
    const double squared = std::pow(frequency / kVaryingEnd, 2);
    return std::exp(-squared * squared);
}

double sinc(double cycles) {
    const double x = kPi * cycles;
    return x == 0 ? 1 : std::sin(x) / x;
}

/// Returns the weight of a point in an octave. The weights in all octaves add up to 1.
double part(double level, std::size_t octave) {
    return std::max(0.0, 1 - std::abs(level - static_cast<double>(octave)));
}

/// Returns the spacing that octave 0 resolves, in a grid with `cells` cells per spacing.
template <class Domain>
double finest_spacing(const Domain& domain, const VoxelDensity& density, const VolumeSpacing& spacing, double points,
                      double cells) {
    const double box = domain.box().volume(), most = std::max(kFewestCells, kMostVolumes * std::pow(cells, 3) * points);
    const double contrast = spacing.is_uniform() ? 1 : density.contrast() * domain.volume() / box;
    double finest =
        std::max(spacing.mean() / std::cbrt(std::min(contrast, kMaxContrast)), cells * std::cbrt(box / most));
    // Thin domains have more cells, because each axis has at least WaveGrid::kMinCells.
    const Point3 sides = domain.box().sides;
    const auto along_side = [&](double side) { return std::max<double>(WaveGrid::kMinCells, cells * side / finest); };
    while (along_side(sides.x) * along_side(sides.y) * along_side(sides.z) > 2 * most) finest *= 2;
    return finest;
}

}  // namespace

template <class Domain>
VolumeTransport<Domain>::VolumeTransport(const Domain& domain, const VoxelDensity& density,
                                         const VolumeSpacing& spacing, std::size_t points, bool precise,
                                         Executor& executor, const std::stop_token& stop)
    : domain_(domain),
      spacing_(spacing),
      executor_(executor),
      points_(static_cast<double>(points)),
      finest_(finest_spacing(domain, density, spacing, points_, precise ? kPreciseCells : kCellsPerSpacing)) {
    const BoxDomain3 box = domain.box();
    const double longest = std::max({box.sides.x, box.sides.y, box.sides.z});
    const double cells = precise ? kPreciseCells : kCellsPerSpacing;
    const std::size_t octaves = spacing.is_uniform() ? 1 : kMaxOctaves;
    for (std::size_t octave = 0; octave < octaves; ++octave) {
        const double own = finest_ * std::exp2(static_cast<double>(octave));
        if (octave > 0 && own > longest / 4) break;
        octaves_.push_back({WaveGrid(box, (cells / own) * box.sides, executor), own});
    }
    if (density.is_uniform()) return;
    for (std::size_t octave = 0; octave < octaves_.size(); ++octave)
        set_target(octaves_[octave], octave, density, stop);
}

/// Returns the fractional octave of a point.
template <class Domain>
double VolumeTransport<Domain>::level(Point3 p) const {
    const double level = std::log2(spacing_.side(p) / finest_) + kCaution;
    return std::clamp(level, 0.0, static_cast<double>(octaves_.size() - 1));
}

/// Computes the wanted density of an octave as if very many points with this density were spread on the grid.
template <class Domain>
void VolumeTransport<Domain>::set_target(Octave& octave, std::size_t number, const VoxelDensity& density,
                                         const std::stop_token& stop) {
    WaveGrid& grid = octave.grid;
    const auto [columns, rows, layers] = grid.cells();
    const Point3 cell{1.0 / columns, 1.0 / rows, 1.0 / layers}, sides = domain_.sides;
    const std::span<double> values = grid.values();
    const auto lines = static_cast<std::size_t>(rows) * static_cast<std::size_t>(layers);
    const auto width = static_cast<std::size_t>(columns), height = static_cast<std::size_t>(rows);
    for_ranges(executor_, lines, 1, [&](std::size_t line, std::size_t) {
        for (std::size_t i = 0; i < width && !stop.stop_requested(); ++i) {
            const auto x = static_cast<double>(i), y = static_cast<double>(line % height),
                       z = static_cast<double>(line / height);
            const Box3 box{
                {x * cell.x, y * cell.y, z * cell.z},
                {std::min(1.0, (x + 1) * cell.x), std::min(1.0, (y + 1) * cell.y), std::min(1.0, (z + 1) * cell.z)}};
            const Point3 middle = 0.5 * (box.min + box.max);
            const double own = part(level({middle.x * sides.x, middle.y * sides.y, middle.z * sides.z}), number);
            values[line * width + i] = own > 0 ? own * points_ * density.mass(box) : 0;
        }
    });
    if (stop.stop_requested()) return;
    const double scale = 1 / (grid.copies() * static_cast<double>(values.size()));
    grid.forward();
    grid.for_waves([&](auto coefficients, const WaveGrid::Wave& wave, std::size_t) {
        const Point3 f = wave.frequency;
        const Point3 cycles{f.x * cell.x * sides.x, f.y * cell.y * sides.y, f.z * cell.z * sides.z};
        auto& coefficient = coefficients[wave.number];
        coefficient *= scale * wave.window / (sinc(cycles.x) * sinc(cycles.y) * sinc(cycles.z));
        // On a torus, centres of cells are half a cell beyond the grid points.
        if constexpr (!std::is_same_v<typename decltype(coefficients)::value_type, double>)
            coefficient *= wave.aliased ? 0 : std::polar(1.0, -kPi * (cycles.x + cycles.y + cycles.z));
    });
    grid.backward();
    octave.target.assign(grid.values().begin(), grid.values().end());
    grid.release_memory();
}

/// Replaces the grid's values, the error of density, by the potential of the moves. Returns the largest power of a
/// removed wave.
template <class Domain>
double VolumeTransport<Domain>::solve(Octave& octave) {
    WaveGrid& grid = octave.grid;
    const bool uniform = spacing_.is_uniform();
    std::vector<double> largest(static_cast<std::size_t>(grid.cells()[2]), 0);
    grid.forward();
    grid.for_waves([&](auto coefficients, const WaveGrid::Wave& wave, std::size_t layer) {
        const double squared = dot(wave.frequency, wave.frequency), cycles = std::sqrt(squared) * octave.spacing;
        const double share = wave.aliased || squared == 0 ? 0 : share_removed(cycles, uniform);
        auto& coefficient = coefficients[wave.number];
        if (share < 1e-9) {
            coefficient = 0;
            return;
        }
        coefficient /= wave.window * grid.copies();
        if (uniform) largest[layer] = std::max(largest[layer], std::norm(coefficient) * grid.copies() / points_);
        coefficient *= -share / (4 * kPi * kPi * squared * wave.window * domain_.box().volume());
    });
    grid.backward();
    return std::ranges::max(largest);
}

template <class Domain>
double VolumeTransport<Domain>::even_out(std::span<Point3> sites, std::size_t free, const std::stop_token& stop) {
    const bool uniform = spacing_.is_uniform();
    moves_.assign(free, {});
    double largest = 0;
    for (std::size_t number = 0; number < octaves_.size() && !stop.stop_requested(); ++number) {
        Octave& octave = octaves_[number];
        if (!uniform) {
            weights_.resize(sites.size());
            for_ranges(executor_, sites.size(), kSites, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) weights_[i] = part(level(sites[i]), number);
            });
        }
        octave.grid.spread(sites, weights_);
        const auto values = octave.grid.values();
        for (std::size_t i = 0; i < octave.target.size(); ++i) values[i] -= static_cast<double>(octave.target[i]);
        if (stop.stop_requested()) return 0;
        largest = std::max(largest, solve(octave));
        if (stop.stop_requested()) return 0;
        for_ranges(executor_, free, kSites, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) moves_[i] = moves_[i] + octave.grid.gradient(sites[i]);
        });
        if (octaves_.size() > 1) octave.grid.release_memory();
    }
    if (stop.stop_requested()) return 0;
    for_ranges(executor_, free, kSites, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const double side = spacing_.side(sites[i]);
            const Point3 move = side * side * side * moves_[i];
            const double size = length(move), longest = kMaxMove * side;
            sites[i] = domain_.moved(sites[i], sites[i] + (size > longest ? longest / size : 1) * move);
        }
    });
    moves_ = {};
    return uniform ? largest : 0;
}

template <class Domain>
void VolumeTransport<Domain>::release_memory() {
    for (Octave& octave : octaves_) octave.grid.release_memory();
    weights_ = {};
}

template class VolumeTransport<BoxDomain3>;
template class VolumeTransport<SolidDomain>;

}  // namespace ccdt
