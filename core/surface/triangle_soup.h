// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/point3.h"

namespace ccdt {

/// Triangles as a file lists them. They need not form a surface: corners may coincide, triangles may be turned over,
/// overlap, or have no area.
struct TriangleSoup {
    std::vector<Point3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of vertices; every index is valid
    /// [vertices] red, green, blue in linear light, each in [0, 1]; empty if the file has no colours.
    std::vector<std::array<float, 3>> colours = {};
    std::vector<std::array<float, 2>> texture = {};  ///< [vertices] texture coordinates; empty if the file has none
};

}  // namespace ccdt
