// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "api/surface/surface_builder.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Whether the first statement of a text is one of OBJ.
bool is_obj(std::string_view text);

/// Returns the name of the file with the materials of an OBJ; empty if there is none.
std::string_view materials_of_obj(std::string_view text);

/// Reads an OBJ. Each corner of each face is a vertex of its own. A fourth coordinate of a vertex divides the others.
/// If a vertex has six or seven numbers, the last ones are its colour, whose alpha is ignored. Points, lines, curves
/// and unknown statements are ignored, with warnings.
/// @param sink  SurfaceCounter or SurfaceBuilder
/// Errors: Unusable, with the line.
/// Source: Wavefront, Advanced Visualizer, appendix B1.
template <class Sink>
Result<void> read_obj(std::string_view text, Sink& sink);

}  // namespace ccdt::api
