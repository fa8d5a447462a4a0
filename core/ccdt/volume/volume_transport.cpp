// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/volume_transport.h"

#include <algorithm>
#include <array>
#include <span>

#include "core/base/elementary.h"

namespace ccdt {

namespace {

/// Upper limit of the removed frequencies of a uniform density, in cycles per mean spacing. It is just above half the
/// principal frequency of the densest packing, 0.5456.
constexpr double kLimit = 0.55;
/// Cells per spacing. With uniform density, these are 3.3 cells per cycle of the highest frequency or, if the grid must
/// be precise, nearly six. SemicircleKernel documents the errors.
constexpr double kCellsPerSpacing = 1.8, kPreciseCells = 3.2;
constexpr std::size_t kCells = 512;  ///< cells per task
/// Largest density that octave 0 resolves, relative to the mean density. In the ball of tests/bench/volume.py, with the
/// density 1 / r^2, the density is 18 at the average site.
constexpr double kMaxContrast = 16;
/// Limits on the cells of octave 0. kMaxVolumes is relative to the cells of a domain without contrast that fills its
/// bounding box. It bounds the memory per site, and is reached by solids that fill a small part of their bounding box.
/// Few sites may have as many cells as kMaxContrast needs, up to kManyCells, and any number of sites kUsualCells. With
/// its margin, the grid of a thin box may have twice as many.
constexpr double kMaxVolumes = 3.8, kUsualCells = 1 << 17, kManyCells = 1 << 19;

/// Returns the spacing that octave 0 resolves, in a grid with `cells` cells per spacing.
/// @param contrast  mean density at the points, relative to the mean density of the box
double finest_spacing(const BoxDomain3& box, double contrast, const VolumeSpacing& spacing, double points,
                      double cells) {
    const double volume = cells * cells * cells * points;
    const double most = std::max({kUsualCells, kMaxVolumes * volume, std::min(kManyCells, kMaxContrast * volume)});
    double finest = std::max(spacing.mean() / elementary::cbrt(std::min(contrast, kMaxContrast)),
                             cells * elementary::cbrt(box.volume() / most));
    // Thin domains have more cells, because each axis has at least kMinCells, and a margin.
    const auto along_side = [&](double side) {
        return std::max<double>(OctaveTransport<Point3>::kMinCells, cells * side / finest) +
               2 * GridFrame<Point3>::kMargin;
    };
    while (along_side(box.sides.x) * along_side(box.sides.y) * along_side(box.sides.z) > 2 * most) finest *= 2;
    return finest;
}

}  // namespace

OctaveTransport<Point3> volume_transport(const BoxDomain3& box, double volume, const VoxelDensity& density,
                                         const VolumeSpacing& spacing, std::size_t points, bool precise,
                                         Executor& executor, const std::stop_token& stop) {
    const auto count = static_cast<double>(points);
    const double cells = precise ? kPreciseCells : kCellsPerSpacing;
    const double contrast = spacing.is_uniform() ? 1 : density.contrast() * volume / box.volume();
    const auto share_removed = [](double frequency) {
        const double square = 4 * frequency * frequency;
        return elementary::exp(-square * square);
    };
    const auto all = [](double) { return 1.0; };
    OctaveTransport<Point3> transport(
        {box.periodic, {}, box.sides}, finest_spacing(box, contrast, spacing, count, cells), 0,
        spacing.is_uniform() ? OctaveTransport<Point3>::Filter{cells, kLimit, all}
                             : OctaveTransport<Point3>::Filter{cells, 0.49 * cells, share_removed},
        executor);
    if (density.is_uniform()) return transport;
    WaveGrid3& grid = transport.finest();
    const auto [columns, rows, layers] = grid.cells();
    const std::array cells_of_grid{static_cast<std::size_t>(columns), static_cast<std::size_t>(rows),
                                   static_cast<std::size_t>(layers)};
    const Point3 sides = box.sides;
    const auto mass_of = [&](std::size_t number) { return count * density.mass(cell_box(cells_of_grid, number)); };
    if (!spacing.is_uniform()) {
        const std::span<double> spacings = grid.grid();
        for_ranges(executor, spacings.size(), kCells, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end && !stop.stop_requested(); ++i) {
                const Box3 part = cell_box(cells_of_grid, i);
                const Point3 middle = 0.5 * (part.min + part.max);
                spacings[i] = spacing.side({middle.x * sides.x, middle.y * sides.y, middle.z * sides.z});
            }
        });
        if (stop.stop_requested()) return transport;
        transport.assign_octaves(spacings, mass_of, stop);
    }
    transport.set_targets(mass_of, stop);
    transport.release_memory();
    return transport;
}

}  // namespace ccdt
