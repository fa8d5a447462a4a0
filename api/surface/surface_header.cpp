// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/surface_header.h"

#include <algorithm>
#include <array>
#include <string>

#include "api/surface/gltf.h"
#include "api/surface/plain_formats.h"
#include "api/surface/surface_builder.h"
#include "api/surface/words.h"
#include "api/text/byte_order_mark.h"
#include "core/ccdt/surface/triangle_soup.h"

namespace ccdt::api {
namespace {

/// Whether JSON contains the name `asset`, which every glTF has, and the name of a member that other documents lack.
bool is_gltf(std::string_view json) {
    const auto has = [json](std::string_view name) { return json.find(name) != std::string_view::npos; };
    return json.starts_with('{') && has("\"asset\"") && (has("\"bufferViews\"") || has("\"meshes\""));
}

/// Returns the format of a text that is not JSON.
std::optional<SurfaceFormat> recognise_text(std::string_view text) {
    if (Words(text).next() == "ply") return SurfaceFormat::Ply;
    if (is_off(text)) return SurfaceFormat::Off;
    if (is_text_stl(text)) return SurfaceFormat::StlText;
    return is_obj(text) ? std::optional(SurfaceFormat::Obj) : std::nullopt;
}

/// Returns the memory for reading a mesh.
std::uint64_t decoder_bytes_of(const SurfaceSize& size) {
    constexpr std::uint64_t kBase = std::uint64_t{32} << 20;
    constexpr std::uint64_t kVertex =
        sizeof(TriangleSoup::vertices[0]) + sizeof(TriangleSoup::colours[0]) + sizeof(TriangleSoup::texture[0]);
    constexpr std::uint64_t kTriangle = sizeof(TriangleSoup::triangles[0]) + sizeof(TriangleSoup::material_of[0]);
    const std::uint64_t bytes =
        kVertex * size.vertices + kTriangle * size.triangles + 2 * sizeof(Material) * size.materials + size.bytes;
    return kBase + bytes + bytes / 4;
}

Result<SurfaceHeader> header_of(SurfaceFormat format, const SurfaceSize& size, std::size_t max_faces) {
    if (size.triangles == 0) return unusable_surface(format, "it has no triangles or polygons");
    // Vertices are limited, too, because a file with few faces may have any number of them.
    if (size.triangles > max_faces || size.vertices / 3 > max_faces) return too_many_faces(max_faces);
    return SurfaceHeader{format, size.triangles, size.vertices, size.materials, decoder_bytes_of(size)};
}

}  // namespace

tl::unexpected<Error> too_many_faces(std::uint64_t max_faces) {
    return failure(ErrorCode::LimitExceeded,
                   "the mesh has too many faces; this server's limit (max-faces) is " + std::to_string(max_faces));
}

std::optional<SurfaceFormat> recognise_surface(std::string_view bytes, std::string_view media_type) {
    bytes = without_byte_order_mark(bytes);
    if (bytes.starts_with("glTF")) return SurfaceFormat::Glb;
    if (is_binary_stl(bytes)) return SurfaceFormat::StlBinary;
    const std::string_view text = bytes.substr(std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size()));
    if (text.starts_with('{') || text.starts_with('[')) {  // the first word of JSON may be the whole text
        if (is_gltf(text)) return SurfaceFormat::Gltf;
    } else if (const auto format = recognise_text(text)) {
        return format;
    }
    constexpr auto kBinaryStl = std::to_array<std::string_view>(
        {"model/stl", "model/x.stl-binary", "application/sla", "application/vnd.ms-pki.stl"});
    if (std::ranges::find(kBinaryStl, media_type) != kBinaryStl.end()) return SurfaceFormat::StlBinary;
    if (media_type == "model/x.stl-ascii") return SurfaceFormat::StlText;
    if (media_type == "model/obj") return SurfaceFormat::Obj;
    if (media_type == "model/ply") return SurfaceFormat::Ply;
    if (media_type == "model/off") return SurfaceFormat::Off;
    if (media_type == "model/gltf+json") return SurfaceFormat::Gltf;
    if (media_type == "model/gltf-binary") return SurfaceFormat::Glb;
    return std::nullopt;
}

Result<SurfaceHeader> read_surface_header(std::string_view bytes, SurfaceFormat format, std::size_t max_faces,
                                          std::size_t max_pixels) {
    if (format == SurfaceFormat::Gltf || format == SurfaceFormat::Glb) {
        const auto gltf = GltfDocument::parse(bytes, format);
        if (!gltf) return tl::unexpected(gltf.error());
        auto header = measure_gltf(*gltf).and_then([&](SurfaceSize size) {
            if (format == SurfaceFormat::Gltf) size.bytes += bytes.size();  // buffers that are decoded from base64
            return header_of(format, size, max_faces);
        });
        if (header && max_pixels > 0) add_pictures(*gltf, max_pixels, *header);
        return header;
    }
    SurfaceCounter counter(format);
    return read_plain_format(bytes, format, counter).and_then([&] {
        return header_of(format, counter.size(), max_faces);
    });
}

std::optional<Result<SurfaceFile>> open_surface(std::string_view bytes, std::string_view media_type,
                                                std::size_t max_faces, std::size_t max_pixels) {
    const auto format = recognise_surface(bytes, media_type);
    if (!format) return std::nullopt;
    const std::string_view file = without_byte_order_mark(bytes);
    return read_surface_header(file, *format, max_faces, max_pixels).map([&](const SurfaceHeader& header) {
        return SurfaceFile{file, header};
    });
}

}  // namespace ccdt::api
