// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/surface/surface_builder.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Whether a text begins with a keyword of the mesh format OFF, such as OFF or COFF. A number may follow without a
/// blank.
bool is_off(std::string_view text);

/// Reads an OFF. If each vertex and each face begins a line, a face may have a colour, which is ignored, and the
/// colours of vertices may lack their alpha. Otherwise, lines may end anywhere.
/// @param sink  SurfaceCounter or SurfaceBuilder
/// Errors: Unusable, with the line; also for vertices with four coordinates, and for binary files.
/// Source: Geomview, OFF(5).
template <class Sink>
Result<void> read_off(std::string_view text, Sink& sink);

}  // namespace ccdt::api
