// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/elementary.h"
#include "core/ccdt/polish/cell_list.h"
#include "core/geometry/axes.h"
#include "core/geometry/domain.h"

namespace ccdt::ordering {

template <class P>
inline constexpr bool kInSpace = kAxes<P> == 3;

/// The box in which points lie: from the origin to `sides`, each of which is > 0. It has three dimensions for points in
/// space and on a surface.
template <class P>
struct PointBox {
    P sides;
    double size;  ///< area of the domain or surface; volume of a domain in space
    bool is_torus = false;
    bool is_solid = false;           ///< whether the domain has three dimensions
    const Domain* domain = nullptr;  ///< nullptr in space

    BasicCellList<P> cells(std::span<const P> positions) const {
        if constexpr (kInSpace<P>)
            return is_torus ? BasicCellList<P>(sides, positions) : BasicCellList<P>(positions);
        else
            return BasicCellList<P>(*domain, positions);
    }

    /// Returns the side of a square of a given area or, in a solid domain, of a cube of a given volume.
    double side_of(double part) const { return is_solid ? elementary::cbrt(part) : std::sqrt(part); }

    /// Returns the area of a square with a given side or, in a solid domain, the volume of a cube.
    double part_of(double side) const { return is_solid ? side * side * side : side * side; }

    /// Returns the spacing of a number of points at uniform density.
    double usual_spacing(std::size_t points) const { return side_of(size / static_cast<double>(points)); }
};

/// Points of a domain, or points on a surface with the surface's normals.
template <class P>
struct Points {
    std::vector<P> positions;
    std::vector<P> normals;  ///< [positions]; empty if the points are not on a surface

    std::size_t size() const { return positions.size(); }

    /// Whether two points are on opposite sides of a thin plate, so that they are not neighbours.
    bool are_opposed(std::uint32_t i, std::uint32_t j) const {
        return !normals.empty() && dot(normals[i], normals[j]) < 0;
    }

    /// Returns the points with the given numbers, in the given order.
    Points selected(std::span<const std::uint32_t> numbers) const {
        Points result;
        result.positions.reserve(numbers.size());
        for (const std::uint32_t i : numbers) result.positions.push_back(positions[i]);
        if (normals.empty()) return result;
        result.normals.reserve(numbers.size());
        for (const std::uint32_t i : numbers) result.normals.push_back(normals[i]);
        return result;
    }
};

}  // namespace ccdt::ordering
