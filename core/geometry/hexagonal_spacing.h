// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

#include "core/base/elementary.h"

namespace ccdt {

/// Returns the distance of neighbours in a hexagonal grid, the densest packing, of `density` sites per unit area.
inline double hexagonal_spacing(double density) {
    return std::sqrt(2 / (std::sqrt(3.0) * density));
}

/// Distance of neighbours in the densest packing in space, the face-centred cubic lattice, with one site per unit of
/// volume: the sixth root of 2.
inline constexpr double kCubicSpacing = 1.122462048309373;

/// Returns the distance of neighbours in the densest packing of `density` sites per unit of area or, in space, volume.
inline double densest_spacing(double density, bool in_space) {
    return in_space ? kCubicSpacing / elementary::cbrt(density) : hexagonal_spacing(density);
}

}  // namespace ccdt
