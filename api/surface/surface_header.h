// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "api/surface/surface_format.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Mesh file in a request.
struct SurfaceFile {
    std::string_view bytes;  ///< must outlive this object
    SurfaceHeader header;
};

/// Recognises the format of a mesh file by its content. If the content is not sufficient, uses the media type, such as
/// `model/stl`, in lower case and without parameters.
/// @returns  none for other files
std::optional<SurfaceFormat> recognise_surface(std::string_view bytes, std::string_view media_type = {});

/// Counts the triangles and vertices of a mesh file, and determines upper bounds of its materials, its pictures and the
/// memory for reading it.
///
/// A polygon with n corners counts as n - 2 triangles. Numbers are not read: the file may still turn out to be damaged.
/// @param max_pixels  limit on the pixels of all pictures of a glTF; 0: pictures are ignored
/// Errors: Unusable for a damaged file, for a file without triangles, for a glTF whose geometry is in other files, and
/// for versions, encodings and extensions that are not supported; LimitExceeded for more than `max_faces` triangles, or
/// more than three times as many vertices, unless the file is damaged. O(size of the file).
Result<SurfaceHeader> read_surface_header(std::string_view bytes, SurfaceFormat format, std::size_t max_faces,
                                          std::size_t max_pixels = 0);

/// Reads the header of a mesh file, after a byte order mark if there is one; returns none for other files. The
/// parameters and errors are those of recognise_surface() and read_surface_header().
std::optional<Result<SurfaceFile>> open_surface(std::string_view bytes, std::string_view media_type,
                                                std::size_t max_faces, std::size_t max_pixels);

/// Returns the error of a mesh that exceeds the limit on faces.
tl::unexpected<Error> too_many_faces(std::uint64_t max_faces);

}  // namespace ccdt::api
