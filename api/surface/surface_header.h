// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "api/surface/surface_format.h"
#include "core/result.h"

namespace ccdt::api {

/// Properties of a mesh file that can be determined without the mesh library. The library has faults, so only a
/// sandboxed process uses it.
struct SurfaceHeader {
    SurfaceFormat format = SurfaceFormat::StlText;
    std::uint64_t min_faces = 0;      ///< number of faces that the file must have, at least
    std::uint64_t max_triangles = 0;  ///< upper bound, at most the limit on faces
    std::uint64_t max_vertices = 0;   ///< upper bound
    std::uint64_t decoder_bytes = 0;  ///< upper bound of the memory for reading the file, in addition to the file
    std::uint64_t max_pixels = 0;     ///< limit on the pixels of all pictures of materials; 0: they are not read
    std::uint64_t texels = 0;         ///< upper bound of the number of these pixels
};

/// Mesh file in a request.
struct SurfaceFile {
    std::string_view bytes;  ///< must outlive this object
    SurfaceHeader header;
};

/// Recognises the format of a mesh file by its content. If the content is not sufficient, uses the media type, such as
/// `model/stl`, in lower case and without parameters.
/// @returns  none for other files
std::optional<SurfaceFormat> recognise_surface(std::string_view bytes, std::string_view media_type = {});

/// Checks the counts in a mesh file against its size, and determines upper bounds of its triangles, vertices and
/// memory.
///
/// A polygon with n corners counts as n - 2 triangles. The file is not validated: it may still turn out to be damaged.
/// @param max_pixels  limit on the pixels of all pictures of a glTF; 0: pictures are ignored
/// Errors: Unusable for a damaged header, for a file that is shorter than its header requires, for a file without
/// faces, for a glTF whose geometry is in other files, and for versions and encodings that are not supported;
/// LimitExceeded for more than `max_faces` triangles, or more than three times as many vertices. O(size of the file).
/// Sources: glTF 2.0 (ISO/IEC 12113), 3.6 and 5; Turk, The PLY Polygon File Format; Geomview, OFF(5); Wavefront,
/// Advanced Visualizer, appendix B1.
Result<SurfaceHeader> read_surface_header(std::string_view bytes, SurfaceFormat format, std::size_t max_faces,
                                          std::size_t max_pixels = 0);

/// Reads the header of a mesh file, after a byte order mark if there is one; returns none for other files. The
/// parameters and errors are those of recognise_surface() and read_surface_header().
std::optional<Result<SurfaceFile>> open_surface(std::string_view bytes, std::string_view media_type,
                                                std::size_t max_faces, std::size_t max_pixels);

/// Returns the size of a type of PLY in bytes; 0 for unknown types.
std::uint64_t size_of_ply_type(std::string_view type);

/// Returns the error of a mesh that exceeds the limit on faces.
tl::unexpected<Error> too_many_faces(std::uint64_t max_faces);

}  // namespace ccdt::api
