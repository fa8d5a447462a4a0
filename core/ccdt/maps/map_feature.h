// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/ccdt/plane/distribution.h"
#include "core/geometry/domain.h"

namespace ccdt {

/// A part of a map for which the number of dots of each class is given.
struct MapFeature {
    Domain area;                    ///< not a torus
    std::vector<std::size_t> dots;  ///< [classes] number of dots
};

/// The dots of one class.
struct ClassDots {
    Distribution dots;                      ///< without mesh; points are sorted by feature
    std::vector<std::uint32_t> feature_of;  ///< [points] feature of each point
};

}  // namespace ccdt
