// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/surface/gltf_materials.h"
#include "api/surface/surface_builder.h"
#include "api/surface/surface_header.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Reads a mesh file: STL, OBJ, PLY, OFF or glTF 2.0.
///
/// Triangles are in the order of the file. The meshes of a glTF are in the order in which its nodes refer to them, with
/// the transformations of the nodes applied. Polygons are divided into triangles, also if they are concave. Coordinates
/// are read as doubles. Colours of a glTF are linear; others are taken as sRGB. If a file has colours, vertices without
/// a colour are white. Of the materials of a glTF, the base colours and their embedded pictures are read, unless the
/// header forbids pictures. Other materials, normals, and other files to which the file refers are not read. In STL and
/// OBJ, each corner of each face is a vertex of its own.
///
/// @param header  result of read_surface_header() for these bytes
/// @param decode  decoder of pictures; empty: they are not read
/// Errors: Unusable for a damaged file, with the position in the file; for a polygon with more than 10,000 corners; for
/// a corner whose coordinates are not finite; and for a file without triangles.
Result<SurfaceContents> read_surface(std::string_view bytes, const SurfaceHeader& header,
                                     const DecodePicture& decode = {});

}  // namespace ccdt::api
