#pragma once

#include <cmath>

namespace ccdt {

/// Distance of neighbours when `density` sites per unit area stand in a hexagonal grid, the densest packing.
inline double hexagonal_spacing(double density) {
    return std::sqrt(2 / (std::sqrt(3.0) * density));
}

}  // namespace ccdt
