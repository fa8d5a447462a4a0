// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/result.h"

namespace ccdt::api {

/// Formats of mesh files.
enum class SurfaceFormat : std::uint32_t { StlText, StlBinary, Obj, Ply, Off, Gltf, Glb };

/// Returns the name of a format, such as "STL".
constexpr std::string_view name_of(SurfaceFormat format) {
    constexpr auto kNames = std::to_array<std::string_view>({"STL", "STL", "OBJ", "PLY", "OFF", "glTF", "GLB"});
    return kNames[static_cast<std::size_t>(format)];
}

/// Returns the error of a mesh file that cannot be read.
inline tl::unexpected<Error> unusable_surface(SurfaceFormat format, std::string_view reason) {
    constexpr std::size_t kLongest = 300;
    return failure(ErrorCode::Unusable,
                   std::string(name_of(format)) + " file cannot be read: " + std::string(reason.substr(0, kLongest)));
}

}  // namespace ccdt::api
