// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace ccdt::api {

/// Formats of mesh files.
enum class SurfaceFormat : std::uint32_t { StlText, StlBinary, Obj, Ply, Off, Gltf, Glb };

/// Returns the name of a format, such as "STL".
constexpr std::string_view name_of(SurfaceFormat format) {
    constexpr auto kNames = std::to_array<std::string_view>({"STL", "STL", "OBJ", "PLY", "OFF", "glTF", "GLB"});
    return kNames[static_cast<std::size_t>(format)];
}

/// Properties of a mesh file that are known before its numbers are read, which a sandboxed process does.
struct SurfaceHeader {
    SurfaceFormat format = SurfaceFormat::StlText;
    std::uint64_t max_triangles = 0;  ///< number of triangles, at most the limit on faces
    std::uint64_t max_vertices = 0;   ///< number of vertices
    std::uint64_t max_materials = 0;  ///< upper bound
    std::uint64_t decoder_bytes = 0;  ///< upper bound of the memory for reading the file, in addition to the file
    std::uint64_t max_pixels = 0;     ///< limit on the pixels of all pictures of materials; 0: they are not read
    std::uint64_t texels = 0;         ///< upper bound of the number of these pixels
};

/// Returns the error of a mesh file that cannot be read.
inline tl::unexpected<Error> unusable_surface(SurfaceFormat format, std::string_view reason) {
    constexpr std::size_t kLongest = 300;
    return failure(ErrorCode::Unusable,
                   std::string(name_of(format)) + " file cannot be read: " + std::string(reason.substr(0, kLongest)));
}

}  // namespace ccdt::api
