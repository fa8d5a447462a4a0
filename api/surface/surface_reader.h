// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string_view>

#include "api/surface/surface_header.h"
#include "core/result.h"
#include "core/surface/triangle_soup.h"

namespace ccdt::api {

/// Contents of a mesh file.
struct SurfaceContents {
    TriangleSoup soup;
    std::size_t ignored = 0;  ///< number of points and lines, which have no area
};

/// Reads a mesh file: STL, OBJ, PLY, OFF or glTF 2.0.
///
/// Triangles are in the order of the file. The meshes of a glTF are in the order in which its nodes refer to them, with
/// the transformations of the nodes applied. Polygons are divided into triangles, also if they are concave. Coordinates
/// have the precision of float. Colours of a glTF are linear; others are taken as sRGB. If a file has colours, vertices
/// without a colour are white. Materials, normals, and other files to which the file refers are not read. In STL and
/// OBJ, each corner of each face is a vertex of its own.
///
/// @param header  result of read_surface_header() for these bytes
/// Errors: Unusable for a damaged file, for a polygon with more than 10,000 corners, and for a file without triangles;
/// LimitExceeded for more triangles or vertices than `header` allows. Coordinates are not checked: they may be infinite
/// or NaN.
Result<SurfaceContents> read_surface(std::string_view bytes, const SurfaceHeader& header);

}  // namespace ccdt::api
