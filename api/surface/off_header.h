// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/result.h"

namespace ccdt::api {

/// Beginning of a mesh file in the format OFF.
struct OffHeader {
    bool has_normals = false;
    bool has_colours = false;
    bool has_texture = false;
    std::uint64_t vertices = 0;
    std::uint64_t faces = 0;
    std::string_view data;  ///< the lines of the vertices and faces

    /// Returns the least number of values on the line of a vertex.
    std::uint64_t values_per_vertex() const {
        return 3U + (has_normals ? 3U : 0U) + (has_colours ? 3U : 0U) + (has_texture ? 2U : 0U);
    }
};

/// Whether a text begins with a keyword of the format, such as OFF or COFF.
bool is_off(std::string_view text);

/// Reads the keyword and the numbers of vertices and faces. Errors: Unusable if one of these is missing. Vertices with
/// four coordinates and binary files are not supported.
/// Source: Geomview, OFF(5).
Result<OffHeader> read_off_header(std::string_view text);

/// Rewrites an OFF as a text PLY, whose lines for vertices and faces are the same. The mesh library's reader of PLY has
/// fewer faults than its reader of OFF, which omits polygons with more than 9 corners. Errors: those of
/// read_off_header().
Result<std::string> ply_of_off(std::string_view text);

}  // namespace ccdt::api
