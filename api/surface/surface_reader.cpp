// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/surface_reader.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <assimp/BaseImporter.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>

#include "api/surface/off_header.h"
#include "api/surface/surface_errors.h"
#include "api/text/text.h"
#include "core/halftone/srgb.h"

namespace ccdt::api {
namespace {

/// Maximum number of corners of a polygon. The library divides a polygon of this size in 1 s.
constexpr unsigned kMaxCorners = 10'000;

using Matrix = aiMatrix4x4t<double>;

bool is_gltf(SurfaceFormat format) {
    return format == SurfaceFormat::Gltf || format == SurfaceFormat::Glb;
}

/// Refuses to open the files that a mesh file refers to, such as materials.
class NoFiles : public Assimp::IOSystem {
public:
    bool Exists(const char* /*file*/) const override { return false; }
    char getOsSeparator() const override { return '/'; }
    Assimp::IOStream* Open(const char* /*file*/, const char* /*mode*/) override { return nullptr; }
    void Close(Assimp::IOStream* /*file*/) override {}
};

/// Returns the extension by which the library selects its reader.
const char* extension_of(SurfaceFormat format) {
    switch (format) {
        case SurfaceFormat::StlText:
        case SurfaceFormat::StlBinary:
            return "stl";
        case SurfaceFormat::Obj:
            return "obj";
        case SurfaceFormat::Ply:
        case SurfaceFormat::Off:
            return "ply";
        case SurfaceFormat::Gltf:
            return "gltf";
        case SurfaceFormat::Glb:
            return "glb";
    }
    return "";
}

/// Removes all readers except that of one format, so that the library cannot choose another one by the content.
void keep_reader(Assimp::Importer& importer, SurfaceFormat format) {
    const std::string extension = extension_of(format);
    const auto reads = [&](const aiImporterDesc& reader) {
        // glTF 1 and 2 have the same extensions.
        const std::string_view name = reader.mName;
        return (' ' + std::string(reader.mFileExtensions) + ' ').find(' ' + extension + ' ') != std::string::npos &&
               !name.starts_with("glTF Importer");
    };
    for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
        if (reads(*importer.GetImporterInfo(i))) continue;
        const std::unique_ptr<Assimp::BaseImporter> removed(importer.GetImporter(i));
        importer.UnregisterLoader(removed.get());
    }
}

/// Turns the statements of an OBJ that begin objects, groups and materials into comments. Otherwise, the library would
/// sort the faces by them.
std::string without_groups(std::string_view bytes) {
    constexpr auto kGroups = std::to_array<std::string_view>({"o", "g", "s", "mg", "usemtl", "mtllib"});
    std::string text(bytes);
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        std::string_view line = trim(std::string_view(text).substr(begin, end - begin), " \t\r");
        const auto at = static_cast<std::size_t>(line.data() - text.data());
        const std::string_view statement = line.substr(0, line.find_first_of(" \t"));
        if (std::ranges::find(kGroups, statement) != kGroups.end()) text[at] = '#';
        begin = end + 1;
    }
    return text;
}

/// A mesh of a scene, with the matrix that transforms it into the coordinates of the scene.
struct PlacedMesh {
    const aiMesh* mesh;
    Matrix matrix;
};

std::span<const aiFace> faces_of(const aiMesh& mesh) {
    return {mesh.mFaces, mesh.mNumFaces};
}

/// Lists the meshes of a scene in the order in which its nodes refer to them, parents first.
std::vector<PlacedMesh> place_meshes(const aiScene& scene) {
    std::vector<PlacedMesh> placed;
    std::vector<std::pair<const aiNode*, Matrix>> waiting;
    if (scene.mRootNode != nullptr) waiting.emplace_back(scene.mRootNode, Matrix());
    while (!waiting.empty()) {
        const auto [node, parent] = waiting.back();
        waiting.pop_back();
        const Matrix matrix = parent * Matrix(node->mTransformation);
        for (const unsigned index : std::span(node->mMeshes, node->mNumMeshes))
            placed.push_back({scene.mMeshes[index], matrix});
        for (unsigned i = node->mNumChildren; i-- > 0;) waiting.emplace_back(node->mChildren[i], matrix);
    }
    return placed;
}

/// Joins meshes, whose faces are triangles, lines and points.
class SoupBuilder {
public:
    SoupBuilder(SurfaceFormat format, std::span<const PlacedMesh> meshes) : format_(format) {
        std::size_t vertices = 0;
        std::size_t faces = 0;
        for (const PlacedMesh& placed : meshes) {
            vertices += placed.mesh->mNumVertices;
            faces += placed.mesh->mNumFaces;
            has_colours_ |= placed.mesh->HasVertexColors(0);
            has_texture_ |= placed.mesh->HasTextureCoords(0);
        }
        contents_.soup.vertices.reserve(vertices);
        contents_.soup.triangles.reserve(faces);
        if (has_colours_) contents_.soup.colours.reserve(vertices);
        if (has_texture_) contents_.soup.texture.reserve(vertices);
        for (const PlacedMesh& placed : meshes) append(placed);
    }

    SurfaceContents take() { return std::move(contents_); }

private:
    void append(const PlacedMesh& placed) {
        const aiMesh& mesh = *placed.mesh;
        auto& vertices = contents_.soup.vertices;
        auto& triangles = contents_.soup.triangles;
        auto& colours = contents_.soup.colours;
        auto& texture = contents_.soup.texture;
        const auto first = static_cast<std::uint32_t>(vertices.size());
        for (const aiVector3D& v : std::span(mesh.mVertices, mesh.mNumVertices)) {
            const auto moved = placed.matrix * aiVector3t<double>(v.x, v.y, v.z);
            vertices.push_back({moved.x, moved.y, moved.z});
        }
        if (has_colours_) {
            for (unsigned i = 0; i < mesh.mNumVertices; ++i)
                colours.push_back(mesh.HasVertexColors(0) ? light_of(mesh.mColors[0][i]) : kWhite);
        }
        if (has_texture_) {
            for (unsigned i = 0; i < mesh.mNumVertices; ++i)
                texture.push_back(mesh.HasTextureCoords(0) ? texture_of(mesh.mTextureCoords[0][i]) : Texture{});
        }
        // A reflection would turn the triangles over.
        const bool is_reflected = placed.matrix.Determinant() < 0;
        for (const aiFace& face : faces_of(mesh)) {
            if (face.mNumIndices < 3) {
                ++contents_.ignored;
                continue;
            }
            triangles.push_back({first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
            if (is_reflected) std::swap(triangles.back()[1], triangles.back()[2]);
        }
    }

    using Colour = std::array<float, 3>;
    using Texture = std::array<float, 2>;
    static constexpr Colour kWhite{1, 1, 1};

    Colour light_of(const aiColor4D& colour) const {
        const auto light = [this](float value) {
            const float share = value > 0 ? std::min(value, 1.0F) : 0;  // also if it is NaN
            return is_gltf(format_) ? share : light_of_srgb(share);
        };
        return {light(colour.r), light(colour.g), light(colour.b)};
    }

    Texture texture_of(const aiVector3D& at) const {
        return {at.x, is_gltf(format_) ? 1 - at.y : at.y};  // the library turns those of a glTF upside down
    }

    SurfaceFormat format_;
    bool has_colours_ = false;
    bool has_texture_ = false;
    SurfaceContents contents_;
};

/// Checks all indices and polygons, because further steps of the library do not. Also checks that the numbers of
/// triangles and vertices do not exceed the upper bounds of the header, and that no face is missing.
Result<void> check(std::span<const PlacedMesh> meshes, const SurfaceHeader& header) {
    std::uint64_t triangles = 0;
    std::uint64_t vertices = 0;
    std::uint64_t faces = 0;
    for (const auto& [mesh, matrix] : meshes) {
        vertices += mesh->mNumVertices;
        faces += mesh->mNumFaces;
        for (const aiFace& face : faces_of(*mesh)) {
            if (face.mNumIndices > kMaxCorners)
                return unusable_surface(
                    name_of(header.format),
                    "a polygon has more than " + std::to_string(kMaxCorners) + " corners, the limit");
            if (face.mNumIndices > 2) triangles += face.mNumIndices - 2;
            for (const unsigned index : std::span(face.mIndices, face.mNumIndices)) {
                if (index < mesh->mNumVertices) continue;
                return unusable_surface(name_of(header.format), "face " + std::to_string(&face - mesh->mFaces) +
                                                                    " refers to vertex " + std::to_string(index) +
                                                                    ", but there are only " +
                                                                    std::to_string(mesh->mNumVertices) + " vertices");
            }
        }
        if (triangles > header.max_triangles || vertices > header.max_vertices)
            return too_many_faces(header.max_triangles);
    }
    if (triangles == 0) return unusable_surface(name_of(header.format), "it has no triangles or polygons");
    // The library omits some faces that are invalid, which would change the numbers of others.
    if (faces < header.min_faces)
        return unusable_surface(name_of(header.format), std::to_string(header.min_faces - faces) + " of its " +
                                                            std::to_string(header.min_faces) + " faces are damaged");
    return {};
}

bool has_polygons(std::span<const PlacedMesh> meshes) {
    return std::ranges::any_of(meshes, [](const PlacedMesh& placed) {
        return std::ranges::any_of(faces_of(*placed.mesh), [](const aiFace& face) { return face.mNumIndices > 3; });
    });
}

Result<SurfaceContents> read_by_library(std::string_view bytes, const SurfaceHeader& header) {
    Assimp::Importer importer;
    importer.SetIOHandler(new NoFiles);  // the importer owns it
    keep_reader(importer, header.format);
    const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, extension_of(header.format));
    if (scene == nullptr) {
        const std::string_view reason = importer.GetErrorString();
        const bool lacks_memory = reason.find("bad_alloc") != std::string_view::npos;
        return unusable_surface(name_of(header.format), lacks_memory ? "it needs too much memory" : reason);
    }
    auto meshes = place_meshes(*scene);
    if (const auto checked = check(meshes, header); !checked) return tl::unexpected(checked.error());
    if (has_polygons(meshes)) {
        scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
        if (scene == nullptr)
            return unusable_surface(name_of(header.format), "its polygons cannot be divided into triangles");
        meshes = place_meshes(*scene);
    }
    return SoupBuilder(header.format, meshes).take();
}

}  // namespace

Result<SurfaceContents> read_surface(std::string_view bytes, const SurfaceHeader& header) {
    try {
        if (header.format == SurfaceFormat::Obj) return read_by_library(without_groups(bytes), header);
        if (header.format == SurfaceFormat::Off)
            return ply_of_off(bytes).and_then([&](const std::string& ply) { return read_by_library(ply, header); });
        return read_by_library(bytes, header);
    } catch (const std::exception& error) {
        return unusable_surface(name_of(header.format), error.what());
    }
}

}  // namespace ccdt::api
