// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace ccdt {

/// A repair of the given triangles, or a property of them that users should know.
struct SurfaceNote {
    std::string detail;                          ///< what was changed or found, and how often
    std::size_t count = 0;                       ///< number of triangles, vertices or edges concerned
    std::optional<std::uint32_t> triangle = {};  ///< first triangle concerned, an index into TriangleSoup::triangles
};

}  // namespace ccdt
