// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/surface/surface_builder.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Whether a file is a binary STL: its size agrees with its number of facets, up to less than a facet. A binary file
/// that begins with the word "solid" is recognised, too, also if it is damaged.
bool is_binary_stl(std::string_view bytes);

/// Whether a file begins with the word "solid".
bool is_text_stl(std::string_view bytes);

/// Reads an STL. Each corner of each facet is a vertex of its own. Normals are not read.
/// @param sink  SurfaceCounter or SurfaceBuilder
/// Errors: Unusable, with the position in the file.
/// Sources: 3D Systems, Stereolithography Interface Specification, 1988; for the colours of a binary STL, VisCAM and
/// Materialise Magics.
template <class Sink>
Result<void> read_text_stl(std::string_view text, Sink& sink);
template <class Sink>
Result<void> read_binary_stl(std::string_view bytes, Sink& sink);

}  // namespace ccdt::api
