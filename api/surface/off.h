// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "core/result.h"

namespace ccdt::api {

/// Whether a text begins with a keyword of the mesh format OFF, such as OFF or COFF.
bool is_off(std::string_view text);

/// Rewrites an OFF as a text PLY, whose lines for vertices and faces are the same. The mesh library's reader of PLY has
/// fewer faults than its reader of OFF, which omits polygons with more than 9 corners. Errors: Unusable if the keyword
/// or the numbers of vertices and faces are missing. Vertices with four coordinates and binary files are not supported.
/// Source: Geomview, OFF(5).
Result<std::string> ply_of_off(std::string_view text);

}  // namespace ccdt::api
