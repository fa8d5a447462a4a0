// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/surface_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <assimp/BaseImporter.h>
#include <assimp/GltfMaterial.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>

#include "api/image/srgb.h"
#include "api/surface/obj.h"
#include "api/surface/off.h"
#include "api/surface/surface_format.h"
#include "api/text/text.h"
#include "core/halftone/srgb.h"

namespace ccdt::api {
namespace {

/// Maximum number of corners of a polygon. The library divides a polygon of this size in 1 s.
constexpr unsigned kMaxCorners = 10'000;

using Matrix = aiMatrix4x4t<double>;

/// Returns the nearest number from 0 to 1; 0 for NaN.
float share_of(float value) {
    return value > 0 ? std::min(value, 1.0F) : 0;
}

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
    constexpr auto kExtensions = std::to_array<const char*>({"stl", "stl", "obj", "ply", "ply", "gltf", "glb"});
    return kExtensions[static_cast<std::size_t>(format)];
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
    for (std::string_view rest = text; !rest.empty();) {
        const std::string_view line = trim(take_obj_line(rest));
        const std::string_view statement = line.substr(0, line.find_first_of(" \t"));
        if (std::ranges::find(kGroups, statement) != kGroups.end())
            text[static_cast<std::size_t>(line.data() - text.data())] = '#';
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

/// Reads the base colours of the materials of a scene.
class MaterialReader {
public:
    MaterialReader(const aiScene& scene, const SurfaceHeader& header, const DecodePicture& decode,
                   SurfaceContents& contents)
        : scene_(scene), header_(header), decode_(decode), contents_(contents), numbers_(scene.mNumMaterials, kNone) {
        contents.soup.texels.reserve(static_cast<std::size_t>(header.texels));
    }

    /// Returns the index in TriangleSoup::materials of a material of the scene.
    std::uint32_t number_of(unsigned material) {
        std::uint32_t& number = numbers_[material];
        if (number != kNone) return number;
        number = static_cast<std::uint32_t>(contents_.soup.materials.size());
        contents_.soup.materials.push_back(read(*scene_.mMaterials[material]));
        return number;
    }

    /// Returns the set of texture coordinates that a material of the scene uses.
    unsigned coordinates_of(unsigned material) const {
        int set = 0;
        scene_.mMaterials[material]->Get(AI_MATKEY_UVWSRC(kColour, 0), set);
        return set > 0 && set < AI_MAX_NUMBER_OF_TEXTURECOORDS ? static_cast<unsigned>(set) : 0;
    }

private:
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};
    static constexpr aiTextureType kColour = aiTextureType_BASE_COLOR;

    Material read(const aiMaterial& from) {
        Material material;
        if (aiColor4D factor; from.Get(AI_MATKEY_BASE_COLOR, factor) == aiReturn_SUCCESS)
            material.factor = {share_of(factor.r), share_of(factor.g), share_of(factor.b), share_of(factor.a)};
        aiString mode;
        from.Get(AI_MATKEY_GLTF_ALPHAMODE, mode);
        if (mode == aiString("MASK")) material.alpha = AlphaMode::Mask;
        if (mode == aiString("BLEND")) material.alpha = AlphaMode::Blend;
        from.Get(AI_MATKEY_GLTF_ALPHACUTOFF, material.cutoff);
        aiString path;
        if (from.GetTexture(kColour, 0, &path) != aiReturn_SUCCESS) return material;
        for (std::size_t i = 0; i < 2; ++i) {
            int wrap = aiTextureMapMode_Wrap;
            from.Get(i == 0 ? "$tex.mapmodeu" : "$tex.mapmodev", kColour, 0, wrap);
            if (wrap == aiTextureMapMode_Clamp) material.wrap[i] = Wrap::Clamp;
            if (wrap == aiTextureMapMode_Mirror) material.wrap[i] = Wrap::Mirror;
        }
        if (aiUVTransform transform; from.Get(AI_MATKEY_UVTRANSFORM(kColour, 0), transform) == aiReturn_SUCCESS)
            material.transform = matrix_of(transform);
        if (const auto added = add_picture(path, material); !added && contents_.picture_error.empty())
            contents_.picture_error = added.error().message;
        return material;
    }

    /// Returns the matrix of a transformation, which the library has converted to coordinates with an upward axis.
    static std::array<float, 6> matrix_of(const aiUVTransform& transform) {
        const auto& [width, height] = transform.mScaling;
        const float sine = std::sin(-transform.mRotation), cosine = std::cos(-transform.mRotation);
        const float right = transform.mTranslation.x - width / 2 * (1 + sine - cosine);
        const float down = height / 2 * (sine + cosine - 1) + 1 - height - transform.mTranslation.y;
        return {cosine * width, sine * height, right, -sine * width, cosine * height, down};
    }

    /// Adds the picture of a material to the soup, unless it is there already.
    Result<void> add_picture(const aiString& path, Material& material) {
        const auto fail = [&](const std::string& reason) {
            const std::string name = std::string(path.C_Str()).substr(0, 100);  // '*' and a number if embedded
            const bool is_embedded = name.starts_with('*');
            return failure(
                ErrorCode::Unusable,
                (is_embedded ? "the embedded texture " + name.substr(1) : "the texture " + name) + ' ' + reason);
        };
        const aiTexture* const texture = path.C_Str()[0] == '*' ? scene_.GetEmbeddedTexture(path.C_Str()) : nullptr;
        if (path.length == 0) return failure(ErrorCode::Unusable, "the picture of a texture has no bytes");
        if (texture == nullptr) return fail("is in another file; embed it, for example in a GLB");
        auto& texels = contents_.soup.texels;
        auto [found, is_new] = pictures_.try_emplace(texture);
        if (is_new && texture->mHeight == 0) {
            const std::string_view bytes(reinterpret_cast<const char*>(texture->pcData), texture->mWidth);
            const auto picture = decode_(bytes, static_cast<std::size_t>(header_.max_pixels));
            if (!picture) return fail("cannot be read: " + picture.error().message);
            const std::size_t pixels = picture->red.size();
            if (pixels > header_.texels - texels.size())
                return fail("cannot be read: all textures together exceed this server's limit (max-pixels), " +
                            std::to_string(header_.max_pixels));
            found->second = {texels.size(), static_cast<std::uint32_t>(picture->width),
                             static_cast<std::uint32_t>(picture->height)};
            for (std::size_t i = 0; i < pixels; ++i) {
                const float alpha = picture->alpha.empty() ? 1 : share_of(picture->alpha[i]);
                texels.push_back({srgb_of(picture->red[i]), srgb_of(picture->green[i]), srgb_of(picture->blue[i]),
                                  static_cast<std::uint8_t>(std::lround(255 * alpha))});
            }
        }
        material.first_texel = found->second.first;
        material.width = found->second.width;
        material.height = found->second.height;
        return {};
    }

    static std::uint8_t srgb_of(float light) {
        static const auto kValues = [] {
            std::vector<std::uint8_t> values(1 << 16);  // enough to tell the darkest sRGB values apart
            for (std::size_t i = 0; i < values.size(); ++i)
                values[i] = to_srgb(static_cast<double>(i) / static_cast<double>(values.size() - 1));
            return values;
        }();
        return kValues[static_cast<std::size_t>(std::lround(share_of(light) * static_cast<float>(kValues.size() - 1)))];
    }

    struct Place {
        std::size_t first = 0;
        std::uint32_t width = 0, height = 0;
    };

    const aiScene& scene_;
    const SurfaceHeader& header_;
    const DecodePicture& decode_;
    SurfaceContents& contents_;
    std::vector<std::uint32_t> numbers_;  ///< [materials of the scene]
    std::map<const aiTexture*, Place> pictures_;
};

/// Joins meshes, whose faces are triangles, lines and points.
class SoupBuilder {
public:
    /// @param materials  reads the materials of the meshes; null: they have none
    SoupBuilder(SurfaceFormat format, std::span<const PlacedMesh> meshes, MaterialReader* materials,
                SurfaceContents& contents)
        : format_(format), materials_(materials), contents_(contents) {
        std::size_t vertices = 0;
        std::size_t faces = 0;
        for (const PlacedMesh& placed : meshes) {
            vertices += placed.mesh->mNumVertices;
            faces += placed.mesh->mNumFaces;
            has_colours_ |= placed.mesh->HasVertexColors(0);
            has_texture_ |= placed.mesh->HasTextureCoords(coordinates_of(*placed.mesh));
        }
        TriangleSoup& soup = contents.soup;
        soup.vertices.reserve(vertices);
        soup.triangles.reserve(faces);
        if (has_colours_) soup.colours.reserve(vertices);
        if (has_texture_) soup.texture.reserve(vertices);
        for (const PlacedMesh& placed : meshes) append(placed);
        if (std::ranges::all_of(soup.materials, is_plain)) {
            soup.materials.clear();
            soup.material_of.clear();
        }
    }

private:
    unsigned coordinates_of(const aiMesh& mesh) const {
        return materials_ == nullptr ? 0 : materials_->coordinates_of(mesh.mMaterialIndex);
    }

    /// Whether a material is opaque and white.
    static bool is_plain(const Material& material) {
        return material.width == 0 && material.alpha == AlphaMode::Opaque && material.factor[0] >= 1 &&
               material.factor[1] >= 1 && material.factor[2] >= 1;
    }

    void append(const PlacedMesh& placed) {
        const aiMesh& mesh = *placed.mesh;
        TriangleSoup& soup = contents_.soup;
        const auto first = static_cast<std::uint32_t>(soup.vertices.size());
        const unsigned set = coordinates_of(mesh);
        for (const aiVector3D& v : std::span(mesh.mVertices, mesh.mNumVertices)) {
            const auto moved = placed.matrix * aiVector3t<double>(v.x, v.y, v.z);
            soup.vertices.push_back({moved.x, moved.y, moved.z});
        }
        for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
            if (has_colours_) soup.colours.push_back(mesh.HasVertexColors(0) ? light_of(mesh.mColors[0][i]) : kWhite);
            if (has_texture_)
                soup.texture.push_back(mesh.HasTextureCoords(set) ? texture_of(mesh.mTextureCoords[set][i])
                                                                  : Texture{});
        }
        // A reflection would turn the triangles over.
        const bool is_reflected = placed.matrix.Determinant() < 0;
        for (const aiFace& face : faces_of(mesh)) {
            if (face.mNumIndices < 3) {
                ++contents_.ignored;
                continue;
            }
            soup.triangles.push_back({first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
            if (is_reflected) std::swap(soup.triangles.back()[1], soup.triangles.back()[2]);
        }
        if (materials_ == nullptr) return;
        const std::uint32_t material = materials_->number_of(mesh.mMaterialIndex);
        soup.material_of.resize(soup.triangles.size(), material);
        if (soup.materials[material].width > 0 && !mesh.HasTextureCoords(set) && contents_.picture_error.empty())
            contents_.picture_error =
                "a part of the mesh has a texture, but not its coordinates TEXCOORD_" + std::to_string(set);
    }

    using Colour = std::array<float, 3>;
    using Texture = std::array<float, 2>;
    static constexpr Colour kWhite{1, 1, 1};

    Colour light_of(const aiColor4D& colour) const {
        const auto light = [this](float value) {
            return is_gltf(format_) ? share_of(value) : light_of_srgb(share_of(value));
        };
        return {light(colour.r), light(colour.g), light(colour.b)};
    }

    Texture texture_of(const aiVector3D& at) const {
        return {at.x, is_gltf(format_) ? 1 - at.y : at.y};  // the library turns those of a glTF upside down
    }

    SurfaceFormat format_;
    MaterialReader* materials_;
    SurfaceContents& contents_;
    bool has_colours_ = false;
    bool has_texture_ = false;
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
                    header.format, "a polygon has more than " + std::to_string(kMaxCorners) + " corners, the limit");
            if (face.mNumIndices > 2) triangles += face.mNumIndices - 2;
            for (const unsigned index : std::span(face.mIndices, face.mNumIndices)) {
                if (index < mesh->mNumVertices) continue;
                return unusable_surface(header.format, "face " + std::to_string(&face - mesh->mFaces) +
                                                           " refers to vertex " + std::to_string(index) +
                                                           ", but there are only " +
                                                           std::to_string(mesh->mNumVertices) + " vertices");
            }
        }
        if (triangles > header.max_triangles || vertices > header.max_vertices)
            return too_many_faces(header.max_triangles);
    }
    if (triangles == 0) return unusable_surface(header.format, "it has no triangles or polygons");
    // The library omits some faces that are invalid, which would change the numbers of others.
    if (faces < header.min_faces)
        return unusable_surface(header.format, std::to_string(header.min_faces - faces) + " of its " +
                                                   std::to_string(header.min_faces) + " faces are damaged");
    return {};
}

bool has_polygons(std::span<const PlacedMesh> meshes) {
    return std::ranges::any_of(meshes, [](const PlacedMesh& placed) {
        return std::ranges::any_of(faces_of(*placed.mesh), [](const aiFace& face) { return face.mNumIndices > 3; });
    });
}

Result<SurfaceContents> read_by_library(std::string_view bytes, const SurfaceHeader& header,
                                        const DecodePicture& decode) {
    Assimp::Importer importer;
    importer.SetIOHandler(new NoFiles);  // the importer owns it
    keep_reader(importer, header.format);
    const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, extension_of(header.format));
    if (scene == nullptr) {
        const std::string_view reason = importer.GetErrorString();
        const bool lacks_memory = reason.find("bad_alloc") != std::string_view::npos;
        return unusable_surface(header.format, lacks_memory ? "it needs too much memory" : reason);
    }
    auto meshes = place_meshes(*scene);
    if (const auto checked = check(meshes, header); !checked) return tl::unexpected(checked.error());
    if (has_polygons(meshes)) {
        scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
        if (scene == nullptr) return unusable_surface(header.format, "its polygons cannot be divided into triangles");
        meshes = place_meshes(*scene);
    }
    SurfaceContents contents;
    const bool has_materials = is_gltf(header.format) && decode && header.max_pixels > 0;
    MaterialReader materials(*scene, header, decode, contents);
    SoupBuilder(header.format, meshes, has_materials ? &materials : nullptr, contents);
    return contents;
}

}  // namespace

Result<SurfaceContents> read_surface(std::string_view bytes, const SurfaceHeader& header, const DecodePicture& decode) {
    try {
        if (header.format == SurfaceFormat::Obj) return read_by_library(without_groups(bytes), header, decode);
        if (header.format == SurfaceFormat::Off)
            return ply_of_off(bytes).and_then(
                [&](const std::string& ply) { return read_by_library(ply, header, decode); });
        return read_by_library(bytes, header, decode);
    } catch (const std::exception& error) {
        return unusable_surface(header.format, error.what());
    }
}

}  // namespace ccdt::api
