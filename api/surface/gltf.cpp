// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/gltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ccdt::api {
namespace {

using Value = GltfDocument::Value;

constexpr std::size_t kNone = ~std::size_t{0};

/// An affine map in space: three rows, whose last column is the translation.
struct Affine {
    std::array<std::array<double, 4>, 3> rows{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

    Point3 operator*(Point3 p) const {
        const auto row = [&](const std::array<double, 4>& r) { return r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3]; };
        return {row(rows[0]), row(rows[1]), row(rows[2])};
    }

    Affine operator*(const Affine& other) const {
        Affine product;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 4; ++k) {
                product.rows[i][k] = k == 3 ? rows[i][3] : 0;
                for (std::size_t j = 0; j < 3; ++j) product.rows[i][k] += rows[i][j] * other.rows[j][k];
            }
        }
        return product;
    }

    double determinant() const {
        const auto vector = [this](std::size_t i) { return Point3{rows[i][0], rows[i][1], rows[i][2]}; };
        return dot(vector(0), cross(vector(1), vector(2)));
    }

    /// @param element  function of the column and the row
    template <class Function>
    static Affine of_columns(Function&& element) {
        Affine affine;
        for (std::size_t row = 0; row < 3; ++row) {
            for (std::size_t column = 0; column < 4; ++column) affine.rows[row][column] = element(column, row);
        }
        return affine;
    }
};

/// Returns the transformation of a node relative to its parent.
Affine local_matrix(JsonValue node) {
    if (const auto m = GltfDocument::numbers(GltfDocument::member(node, "matrix"), 16); !m.empty())
        return Affine::of_columns([&](std::size_t column, std::size_t row) { return m[4 * column + row]; });
    const auto numbers = [&](std::string_view name, std::vector<double> missing) {
        auto found = GltfDocument::numbers(GltfDocument::member(node, name), missing.size());
        return found.empty() ? missing : found;
    };
    const auto t = numbers("translation", {0, 0, 0}), q = numbers("rotation", {0, 0, 0, 1}),
               s = numbers("scale", {1, 1, 1});
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const std::array<std::array<double, 3>, 3> rotation{
        {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
         {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
         {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}}};
    return Affine::of_columns(
        [&](std::size_t column, std::size_t row) { return column == 3 ? t[row] : rotation[row][column] * s[column]; });
}

/// A node of the scene that has a mesh.
struct Instance {
    std::size_t node;
    std::size_t mesh;
};

/// The nodes of a glTF.
class Nodes {
public:
    /// Errors: Unusable if the nodes do not form trees.
    static Result<Nodes> create(const GltfDocument& gltf) {
        Nodes nodes(gltf);
        if (nodes.find_parents() && nodes.visit_scene()) return nodes;
        return gltf.wrong("its nodes do not form a tree");
    }

    /// Returns the instances of meshes in the scene, parents first.
    const std::vector<Instance>& instances() const { return instances_; }

    /// Computes the matrices of all nodes relative to the scene. Nodes that are their own ancestors have no matrix.
    std::vector<Affine> matrices() const {
        const auto& values = gltf_.array("nodes");
        std::vector<Affine> matrices(values.size());
        std::vector<std::size_t> waiting;
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (parents_[i] == kNone) waiting.push_back(i);
        }
        while (!waiting.empty()) {
            const std::size_t node = waiting.back();
            waiting.pop_back();
            matrices[node] = local_matrix(values[node]);
            if (parents_[node] != kNone) matrices[node] = matrices[parents_[node]] * matrices[node];
            waiting.insert(waiting.end(), children_[node].begin(), children_[node].end());
        }
        return matrices;
    }

private:
    explicit Nodes(const GltfDocument& gltf)
        : gltf_(gltf), parents_(gltf.array("nodes").size(), kNone), children_(parents_.size()) {}

    bool find_parents() {
        const auto& values = gltf_.array("nodes");
        for (std::size_t i = 0; i < values.size(); ++i) {
            for (const JsonValue child : GltfDocument::list(GltfDocument::member(values[i], "children"))) {
                const auto node = GltfDocument::index(child, values.size());
                if (!node || std::exchange(parents_[*node], i) != kNone) return false;
                children_[i].push_back(*node);
            }
        }
        return true;
    }

    bool visit_scene() {
        const auto& values = gltf_.array("nodes");
        const auto& scenes = gltf_.array("scenes");
        std::vector<std::size_t> waiting;
        if (scenes.empty()) {
            for (std::size_t i = 0; i < values.size(); ++i) {
                if (parents_[i] == kNone) waiting.push_back(i);
            }
        } else {
            const auto scene = GltfDocument::index(GltfDocument::member(gltf_.root(), "scene"), scenes.size());
            for (const JsonValue root : GltfDocument::list(GltfDocument::member(scenes[scene.value_or(0)], "nodes"))) {
                const auto node = GltfDocument::index(root, values.size());
                if (!node) return false;
                waiting.push_back(*node);
            }
        }
        std::ranges::reverse(waiting);
        std::vector<bool> is_visited(values.size());
        while (!waiting.empty()) {
            const std::size_t node = waiting.back();
            waiting.pop_back();
            if (is_visited[node]) return false;
            is_visited[node] = true;
            const auto mesh =
                GltfDocument::index(GltfDocument::member(values[node], "mesh"), gltf_.array("meshes").size());
            if (mesh) instances_.push_back({node, *mesh});
            waiting.insert(waiting.end(), children_[node].rbegin(), children_[node].rend());
        }
        return true;
    }

    const GltfDocument& gltf_;
    std::vector<std::size_t> parents_;
    std::vector<std::vector<std::size_t>> children_;
    std::vector<Instance> instances_;
};

/// A primitive of a mesh, and the numbers of its elements.
struct Primitive {
    enum class Mode : std::size_t { Triangles = 4, Strip = 5, Fan = 6 };  // those below are points and lines

    JsonValue value;
    Mode mode;
    std::size_t vertices;
    std::size_t corners;

    std::size_t triangles() const {
        if (mode < Mode::Triangles || mode > Mode::Fan || vertices == 0) return 0;
        return mode == Mode::Triangles ? corners / 3 : corners - std::min<std::size_t>(corners, 2);
    }

    /// Returns the corners of a triangle.
    std::array<std::size_t, 3> triangle(std::size_t i) const {
        if (mode == Mode::Triangles) return {3 * i, 3 * i + 1, 3 * i + 2};
        if (mode == Mode::Fan) return {i + 1, i + 2, 0};
        return {i, i + 1 + i % 2, i + 2 - i % 2};
    }
};

std::vector<Primitive> primitives_of(const GltfDocument& gltf, JsonValue mesh) {
    std::vector<Primitive> primitives;
    for (const JsonValue value : GltfDocument::list(GltfDocument::member(mesh, "primitives"))) {
        const std::size_t vertices = gltf.count(GltfDocument::member(value, "attributes", "POSITION")).value_or(0);
        const auto indices = GltfDocument::member(value, "indices");
        const auto mode = GltfDocument::index(GltfDocument::member(value, "mode"), 7);
        primitives.push_back({value, static_cast<Primitive::Mode>(mode.value_or(4)), vertices,
                              indices ? gltf.count(indices).value_or(0) : vertices});
    }
    return primitives;
}

class SceneReader {
public:
    SceneReader(const GltfDocument& gltf, const Nodes& nodes, SurfaceFormat format, const SurfaceSize& size,
                const DecodePicture* decode, const SurfaceHeader& header)
        : gltf_(gltf),
          nodes_(nodes),
          matrices_(nodes.matrices()),
          builder_(format, size),
          skins_(gltf.array("skins").size()) {
        if (decode != nullptr) materials_.emplace(gltf, header, *decode, builder_.soup());
    }

    Result<SurfaceContents> read() {
        for (const Instance& instance : nodes_.instances()) {
            const JsonValue mesh = gltf_.array("meshes")[instance.mesh];
            for (const Primitive& primitive : primitives_of(gltf_, mesh)) {
                if (auto right = add(instance, mesh, primitive); !right) return tl::unexpected(right.error());
            }
        }
        for (const std::string_view name : gltf_.unknown_extensions())
            builder_.warn("required extensions that are unknown are ignored", std::string(name.substr(0, 100)));
        if (gltf_.trailing_bytes() > 0)
            builder_.warn("bytes after the end of the GLB are ignored", "", gltf_.trailing_bytes());
        auto& soup = builder_.soup();
        if (std::ranges::all_of(soup.materials, is_plain)) {
            soup.materials.clear();
            soup.material_of.clear();
        }
        return builder_.finish().map([this](SurfaceContents contents) {
            if (materials_) contents.picture_error = materials_->error();
            return contents;
        });
    }

private:
    /// Whether a material is opaque and white.
    static bool is_plain(const Material& material) {
        return material.width == 0 && material.alpha == AlphaMode::Opaque && material.factor[0] >= 1 &&
               material.factor[1] >= 1 && material.factor[2] >= 1;
    }

    Result<void> add(const Instance& instance, JsonValue mesh, const Primitive& primitive) {
        if (primitive.triangles() == 0) {
            if (primitive.mode < Primitive::Mode::Triangles)
                builder_.warn("points and lines, which have no area, are ignored",
                              "mesh " + std::to_string(instance.mesh));
            return {};
        }
        if (GltfDocument::member(gltf_.array("nodes")[instance.node], "extensions", "EXT_mesh_gpu_instancing"))
            return gltf_.wrong("the extension EXT_mesh_gpu_instancing is not supported");
        const Value position = GltfDocument::member(primitive.value, "attributes", "POSITION");
        const bool is_elsewhere = !GltfDocument::member(gltf_.element("accessors", position), "bufferView");
        if (is_elsewhere && GltfDocument::member(primitive.value, "extensions", "KHR_draco_mesh_compression"))
            return gltf_.wrong("the extension KHR_draco_mesh_compression is not supported");
        const auto first = static_cast<std::uint32_t>(builder_.soup().vertices.size());
        return add_vertices(instance, mesh, primitive).and_then([&] {
            return add_triangles(instance, primitive, first);
        });
    }

    /// Returns an attribute of a primitive; none if it has no such attribute.
    Result<std::optional<GltfAccessor>> attribute(const Primitive& primitive, const std::string& name,
                                                  std::size_t components) const {
        const Value index = GltfDocument::member(primitive.value, "attributes", name);
        if (!index) return std::optional<GltfAccessor>();
        return gltf_.accessor(index, primitive.vertices, components).map([](GltfAccessor read) {
            return std::optional(std::move(read));
        });
    }

    Result<void> add_vertices(const Instance& instance, JsonValue mesh, const Primitive& primitive) {
        const Value material = GltfDocument::member(primitive.value, "material");
        const std::size_t set = materials_ ? materials_->coordinates_of(material) : 0;
        const auto colours = attribute(primitive, "COLOR_0", 3);
        const auto texture = attribute(primitive, "TEXCOORD_" + std::to_string(set), 2);
        if (!colours) return tl::unexpected(colours.error());
        if (!texture) return tl::unexpected(texture.error());
        auto positions = read_positions(instance, mesh, primitive);
        if (!positions) return tl::unexpected(positions.error());
        for (std::size_t i = 0; i < primitive.vertices; ++i) {
            builder_.vertex((*positions)[i], 0);
            if (*colours) builder_.colour({(*colours)->at(i, 0), (*colours)->at(i, 1), (*colours)->at(i, 2)});
            if (*texture) builder_.texture({(*texture)->at(i, 0), (*texture)->at(i, 1)});
        }
        if (!materials_) return {};
        TriangleSoup& soup = builder_.soup();
        const std::uint32_t number = materials_->number_of(material);
        soup.material_of.resize(soup.triangles.size() + primitive.triangles(), number);
        if (soup.materials[number].width > 0 && !*texture)
            materials_->report("a part of the mesh has a texture, but not its coordinates TEXCOORD_" +
                               std::to_string(set));
        return {};
    }

    Result<void> add_triangles(const Instance& instance, const Primitive& primitive, std::uint32_t first) {
        const Value index = GltfDocument::member(primitive.value, "indices");
        std::optional<GltfAccessor> indices;
        if (index) {
            auto read = gltf_.accessor(index, primitive.corners, 1);
            if (!read) return tl::unexpected(read.error());
            if (!read->is_whole())
                return gltf_.wrong("the indices of mesh " + std::to_string(instance.mesh) + " are not whole numbers");
            indices = *std::move(read);
        }
        // A reflection would turn the triangles over.
        const bool is_reflected = !skin_of(instance) && matrices_[instance.node].determinant() < 0;
        const std::size_t triangles = primitive.triangles();
        for (std::size_t i = 0; i < triangles; ++i) {
            std::array<std::uint32_t, 3> corners{};
            const auto elements = primitive.triangle(i);
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t corner = elements[k];
                const double vertex = indices ? indices->at(corner, 0) : static_cast<double>(corner);
                if (!(vertex >= 0 && vertex < static_cast<double>(primitive.vertices)))
                    return gltf_.wrong("triangle " + std::to_string(i) + " of mesh " + std::to_string(instance.mesh) +
                                       " refers to vertex " + std::to_string(static_cast<std::int64_t>(vertex)) +
                                       ", but there are only " + std::to_string(primitive.vertices) + " vertices");
                corners[k] = first + static_cast<std::uint32_t>(vertex);
            }
            if (is_reflected) std::swap(corners[1], corners[2]);
            if (auto right = builder_.face(corners, {i, 0}); !right) return right;
        }
        return {};
    }

    /// Returns the positions of the vertices in the scene.
    Result<std::vector<Point3>> read_positions(const Instance& instance, JsonValue mesh, const Primitive& primitive) {
        const auto accessor =
            gltf_.accessor(GltfDocument::member(primitive.value, "attributes", "POSITION"), primitive.vertices, 3);
        if (!accessor) return tl::unexpected(accessor.error());
        std::vector<Point3> positions;
        positions.reserve(primitive.vertices);
        for (std::size_t i = 0; i < primitive.vertices; ++i)
            positions.push_back({accessor->at(i, 0), accessor->at(i, 1), accessor->at(i, 2)});
        if (auto right = morph(instance, mesh, primitive, positions); !right) return tl::unexpected(right.error());
        if (skin_of(instance)) {
            if (auto right = pose(instance, primitive, positions); !right) return tl::unexpected(right.error());
        } else {
            for (Point3& p : positions) p = matrices_[instance.node] * p;
        }
        return positions;
    }

    /// Adds the weighted displacements of the morph targets.
    Result<void> morph(const Instance& instance, JsonValue mesh, const Primitive& primitive,
                       std::vector<Point3>& positions) const {
        const auto own = GltfDocument::member(gltf_.array("nodes")[instance.node], "weights");
        const auto weights = GltfDocument::list(own ? own : GltfDocument::member(mesh, "weights"));
        const auto targets = GltfDocument::list(GltfDocument::member(primitive.value, "targets"));
        for (std::size_t t = 0; t < std::min(weights.size(), targets.size()); ++t) {
            const double weight = GltfDocument::number(weights[t], 0);
            const auto index = GltfDocument::member(targets[t], "POSITION");
            if (weight == 0 || !index) continue;
            const auto moves = gltf_.accessor(index, primitive.vertices, 3);
            if (!moves) return tl::unexpected(moves.error());
            for (std::size_t i = 0; i < primitive.vertices; ++i)
                positions[i] = positions[i] + weight * Point3{moves->at(i, 0), moves->at(i, 1), moves->at(i, 2)};
        }
        return {};
    }

    std::optional<std::size_t> skin_of(const Instance& instance) const {
        return GltfDocument::index(GltfDocument::member(gltf_.array("nodes")[instance.node], "skin"), skins_.size());
    }

    /// Moves vertices with the joints of a skin. The transformation of the node itself has no effect.
    Result<void> pose(const Instance& instance, const Primitive& primitive, std::vector<Point3>& positions) {
        const auto joints = joints_of(*skin_of(instance));
        if (!joints) return tl::unexpected(joints.error());
        std::vector<Point3> moved(positions.size());
        std::vector<double> totals(positions.size());
        for (std::size_t set = 0;; ++set) {
            const auto indices = attribute(primitive, "JOINTS_" + std::to_string(set), 4);
            const auto weights = attribute(primitive, "WEIGHTS_" + std::to_string(set), 4);
            if (!indices) return tl::unexpected(indices.error());
            if (!weights) return tl::unexpected(weights.error());
            if (!*indices || !*weights) break;
            if (!(*indices)->is_whole())
                return gltf_.wrong("the joints of mesh " + std::to_string(instance.mesh) + " are not whole numbers");
            for (std::size_t i = 0; i < 4 * positions.size(); ++i) {
                const double weight = (*weights)->at(i / 4, i % 4), joint = (*indices)->at(i / 4, i % 4);
                if (weight == 0) continue;
                if (!(joint >= 0 && joint < static_cast<double>((*joints)->size())))
                    return gltf_.wrong("vertex " + std::to_string(i / 4) + " of mesh " + std::to_string(instance.mesh) +
                                       " refers to a joint that is missing");
                moved[i / 4] = moved[i / 4] + weight * ((**joints)[static_cast<std::size_t>(joint)] * positions[i / 4]);
                totals[i / 4] += weight;
            }
        }
        for (std::size_t i = 0; i < positions.size(); ++i) {
            if (totals[i] != 0) positions[i] = 1 / totals[i] * moved[i];
        }
        return {};
    }

    /// Returns the matrices of the joints of a skin, from the coordinates of the mesh to those of the scene.
    Result<const std::vector<Affine>*> joints_of(std::size_t skin) {
        auto& known = skins_[skin];
        if (known) return &*known;
        const JsonValue value = gltf_.array("skins")[skin];
        const auto joints = GltfDocument::list(GltfDocument::member(value, "joints"));
        std::vector<Affine> matrices;
        for (const JsonValue joint : joints) {
            const auto node = GltfDocument::index(joint, matrices_.size());
            if (!node) return gltf_.wrong("skin " + std::to_string(skin) + " refers to a node that is missing");
            matrices.push_back(matrices_[*node]);
        }
        if (const auto inverse = GltfDocument::member(value, "inverseBindMatrices")) {
            const auto bind = gltf_.accessor(inverse, joints.size(), 16);
            if (!bind) return tl::unexpected(bind.error());
            for (std::size_t i = 0; i < matrices.size(); ++i)
                matrices[i] = matrices[i] * Affine::of_columns([&](std::size_t column, std::size_t row) {
                                  return bind->at(i, 4 * column + row);
                              });
        }
        known = std::move(matrices);
        return &*known;
    }

    const GltfDocument& gltf_;
    const Nodes& nodes_;
    std::vector<Affine> matrices_;  ///< [nodes]
    SurfaceBuilder builder_;
    std::optional<GltfMaterials> materials_;
    std::vector<std::optional<std::vector<Affine>>> skins_;  ///< matrices of the joints, once they are used
};

}  // namespace

Result<SurfaceSize> measure_gltf(const GltfDocument& gltf) {
    const auto nodes = Nodes::create(gltf);
    if (!nodes) return tl::unexpected(nodes.error());
    const auto& meshes = gltf.array("meshes");
    std::vector<std::optional<SurfaceSize>> sizes(meshes.size());
    SurfaceSize total;
    for (const Instance& instance : nodes->instances()) {
        auto& size = sizes[instance.mesh];
        if (!size) {
            size.emplace();
            for (const Primitive& primitive : primitives_of(gltf, meshes[instance.mesh])) {
                if (primitive.triangles() == 0) continue;
                constexpr std::uint64_t kVertex = 4 * sizeof(Point3);  // positions, and copies of sparse accessors
                size->vertices += primitive.vertices;
                size->triangles += primitive.triangles();
                size->bytes = std::max(size->bytes, kVertex * primitive.vertices + 4 * primitive.corners);
            }
        }
        total.vertices += size->vertices;
        total.triangles += size->triangles;
        total.bytes = std::max(total.bytes, size->bytes);
    }
    constexpr std::uint64_t kNode = 2 * (sizeof(Affine) + sizeof(Instance) + sizeof(std::vector<std::size_t>)) + 64;
    total.materials = gltf.array("materials").size() + 1;
    total.bytes += gltf.memory() + kNode * gltf.array("nodes").size();
    if (nodes->instances().empty()) return gltf.wrong("its scene has no meshes");
    return total;
}

Result<SurfaceContents> read_gltf(const GltfDocument& gltf, const SurfaceHeader& header, const SurfaceSize& size,
                                  const DecodePicture& decode) {
    const bool has_materials = decode && header.max_pixels > 0;
    return Nodes::create(gltf).and_then([&](const Nodes& nodes) {
        return SceneReader(gltf, nodes, header.format, size, has_materials ? &decode : nullptr, header).read();
    });
}

}  // namespace ccdt::api
