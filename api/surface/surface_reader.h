// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "api/surface/surface_header.h"
#include "core/halftone/picture.h"
#include "core/result.h"
#include "core/surface/triangle_soup.h"

namespace ccdt::api {

/// Contents of a mesh file.
struct SurfaceContents {
    TriangleSoup soup;
    std::size_t ignored = 0;         ///< number of points and lines, which have no area
    std::string picture_error = {};  ///< why a picture of a material could not be used; empty if all were used
};

/// Decodes the file of a picture. Errors: those of decode_colour_image().
using DecodePicture = std::function<Result<ColourPicture>(std::string_view bytes, std::size_t max_pixels)>;

/// Reads a mesh file: STL, OBJ, PLY, OFF or glTF 2.0.
///
/// Triangles are in the order of the file. The meshes of a glTF are in the order in which its nodes refer to them, with
/// the transformations of the nodes applied. Polygons are divided into triangles, also if they are concave. Coordinates
/// have the precision of float. Colours of a glTF are linear; others are taken as sRGB. If a file has colours, vertices
/// without a colour are white. Of the materials of a glTF, the base colours and their embedded pictures are read,
/// unless the header forbids pictures. Other materials, normals, and other files to which the file refers are not read.
/// In STL and OBJ, each corner of each face is a vertex of its own.
///
/// @param header  result of read_surface_header() for these bytes
/// @param decode  decoder of pictures; empty: they are not read
/// Errors: Unusable for a damaged file, for a polygon with more than 10,000 corners, and for a file without triangles;
/// LimitExceeded for more triangles or vertices than `header` allows. Coordinates are not checked: they may be infinite
/// or NaN.
Result<SurfaceContents> read_surface(std::string_view bytes, const SurfaceHeader& header,
                                     const DecodePicture& decode = {});

}  // namespace ccdt::api
