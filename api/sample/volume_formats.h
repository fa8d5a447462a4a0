// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "api/sample/placed_volume.h"
#include "api/sample/space_format.h"

namespace ccdt::api {

/// Format of an answer with points in space.
///
/// JSON, CSV, NPY and PLY have the points as doubles. VTU is an unstructured grid of VTK (VTK XML, version 1.0) with
/// raw appended data: a vertex cell for each point, or the tetrahedra. MSH is Gmsh's binary format 4.1, for tetrahedra.
/// In VTU and MSH, tetrahedra that cross the border of a torus have copies of vertices beyond the border, which follow
/// the other vertices. Errors: Unusable for a torus with so few points that tetrahedra are wider than half of it.
using VolumePointFormat = SpaceFormat<PlacedVolume>;

/// Returns the formats, in the server's order of preference.
std::span<const VolumePointFormat* const> volume_formats();

}  // namespace ccdt::api
