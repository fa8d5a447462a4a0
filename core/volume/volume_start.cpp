// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/volume/volume_start.h"

#include <array>

#include "core/random.h"

namespace ccdt {

std::vector<Point3> draw_start(const BoxDomain3& domain, const VoxelDensity& density, std::size_t sites,
                               std::uint64_t seed) {
    constexpr std::size_t kMostPerCell = 4;
    struct Cell {
        Box3 box;  ///< relative to the domain's sides
        std::size_t sites;
    };
    const Point3 sides = domain.sides;
    std::vector<Cell> cells{{{{0, 0, 0}, {1, 1, 1}}, sites}};
    std::vector<Point3> drawn;
    drawn.reserve(sites);
    while (!cells.empty()) {
        const Cell cell = cells.back();
        cells.pop_back();
        if (cell.sites <= kMostPerCell) {
            for (std::size_t i = 0; i < cell.sites; ++i) {
                Random random(seed, drawn.size());
                const double x = random.uniform(), y = random.uniform(), z = random.uniform();
                const Point3 p = density.draw(cell.box, {x, y, z});
                drawn.push_back(domain.inside({p.x * sides.x, p.y * sides.y, p.z * sides.z}));
            }
            continue;
        }
        const Point3 size = cell.box.max - cell.box.min;
        const std::array lengths{size.x * sides.x, size.y * sides.y, size.z * sides.z};
        const std::size_t axis = lengths[0] >= lengths[1] && lengths[0] >= lengths[2] ? 0
                                 : lengths[1] >= lengths[2]                           ? 1
                                                                                      : 2;
        Cell low = cell, high = cell;
        low.sites = cell.sites / 2;
        high.sites = cell.sites - low.sites;
        const double share = static_cast<double>(low.sites) / static_cast<double>(cell.sites);
        along(low.box.max, axis) = along(high.box.min, axis) = density.cut(cell.box, axis, share);
        cells.push_back(high);
        cells.push_back(low);
    }
    return drawn;
}

}  // namespace ccdt
