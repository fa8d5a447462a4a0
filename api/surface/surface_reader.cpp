// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/surface_reader.h"

#include <new>

#include "api/surface/gltf.h"
#include "api/surface/plain_formats.h"

namespace ccdt::api {
namespace {

Result<SurfaceContents> read(std::string_view bytes, const SurfaceHeader& header, const DecodePicture& decode) {
    const SurfaceSize size{header.max_vertices, header.max_triangles};
    if (header.format == SurfaceFormat::Gltf || header.format == SurfaceFormat::Glb)
        return GltfDocument::parse(bytes, header.format).and_then([&](const GltfDocument& gltf) {
            return read_gltf(gltf, header, size, decode);
        });
    SurfaceBuilder builder(header.format, size);
    return read_plain_format(bytes, header.format, builder).and_then([&] { return builder.finish(); });
}

}  // namespace

Result<SurfaceContents> read_surface(std::string_view bytes, const SurfaceHeader& header, const DecodePicture& decode) {
    try {
        return read(bytes, header, decode);
    } catch (const std::bad_alloc&) {
        return unusable_surface(header.format, "it needs too much memory");
    }
}

}  // namespace ccdt::api
