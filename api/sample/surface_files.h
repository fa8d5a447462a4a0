// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stop_token>

#include "api/output/body.h"
#include "api/sample/surface_formats.h"
#include "core/result.h"

namespace ccdt::api {

// Writers of mesh files. The functions write_*_mesh() write the triangulation of the points,
// SurfaceDistribution::mesh, which must not be empty. All writers have the parameters and errors of SpaceFormat::Write.

Result<void> write_ply_mesh(const PlacedSurface& placed, Body& body, const std::stop_token& stop);

/// Writes points as a glTF 2.0 primitive of the mode POINTS, with the attributes POSITION, NORMAL, COLOR_0 (linear) and
/// TEXCOORD_0 if the file has colours and texture coordinates, _FACE and _BARYCENTRIC. All are 32-bit floats, so _FACE
/// is exact up to 2^24. If the mesh is far from the origin, positions are relative to the translation of the node.
/// Errors: LimitExceeded if the file would exceed 4 GiB; Unusable for coordinates beyond the range of floats. Source:
/// glTF 2.0 (ISO/IEC 12113).
Result<void> write_glb_points(const PlacedSurface& placed, Body& body, const std::stop_token& stop);
Result<void> write_glb_mesh(const PlacedSurface& placed, Body& body, const std::stop_token& stop);

/// Writes the triangulation as Wavefront OBJ. Numbers have the fewest digits that read back to the same double.
Result<void> write_obj_mesh(const PlacedSurface& placed, Body& body, const std::stop_token& stop);

/// Writes the triangulation as binary STL, whose coordinates are 32-bit floats. Errors: Unusable for coordinates beyond
/// their range.
Result<void> write_stl_mesh(const PlacedSurface& placed, Body& body, const std::stop_token& stop);

}  // namespace ccdt::api
