// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/spatial/surface_formats.h"

#include <string_view>

#include "api/image/srgb.h"
#include "api/output/json_pieces.h"

namespace ccdt::api {
namespace {

Result<void> write_json(const PlacedSurface& placed, Body& body, const std::stop_token& stop) {
    const std::size_t size = placed.size();
    const auto write = [&](std::string_view name, auto append_element) {
        body.text().append(name);
        write_list(body, size, append_element, stop);
    };
    write("{\"points\":", [&](std::string& out, std::size_t i) { append_position(out, placed.position(i)); });
    write(",\"faces\":", [&](std::string& out, std::size_t i) { append_index(out, placed.face(i)); });
    write(",\"barycentric\":", [&](std::string& out, std::size_t i) { append_numbers(out, placed.weights(i)); });
    write(",\"normals\":", [&](std::string& out, std::size_t i) { append_position(out, placed.normal(i)); });
    const auto append_light = [](std::string& out, float light) { append_index(out, to_srgb(double{light})); };
    const auto append_ordinate = [](std::string& out, float ordinate) { append_number(out, ordinate); };
    if (placed.has_colours())
        write(",\"colors\":", [&](auto& out, std::size_t i) { append_array(out, placed.colour(i), append_light); });
    if (placed.has_texture())
        write(",\"texture\":",
              [&](auto& out, std::size_t i) { append_array(out, placed.texture(i), append_ordinate); });
    append_member(body.text(), "sites", std::uint64_t{placed.size()});
    append_member(body.text(), "seed", placed.seed);
    append_member(body.text(), "iterations", static_cast<std::uint64_t>(placed.dots.iterations));
    append_member(body.text(), "variation", placed.dots.variation());
    append_outcome(body.text(), placed);
    write_ranks(body, placed.dots.ranks, stop);
    if (const auto& mesh = placed.dots.mesh)
        write_mesh(std::span(mesh->vertices), "triangles", std::span(mesh->triangles), body, stop);
    body.text() += "}\n";
    return {};
}

// Costs of writing a point, or a vertex and two triangles of a triangulation.
constexpr Estimate kTextCost{330, 1.5 * kMicrosecond};
constexpr Estimate kBinaryCost{100, 0.2 * kMicrosecond};

constexpr SurfacePointFormat kJsonPoints{kJson, 24, kTextCost, false, write_json};
constexpr SurfacePointFormat kCsvPoints{kCsv, 20, kTextCost, true, write_csv<PlacedSurface>};
constexpr SurfacePointFormat kNpyPoints{kNpy, 10 * sizeof(double), kBinaryCost, true, write_npy<PlacedSurface>};
constexpr SurfacePointFormat kPlyFile{kPly, 24, kBinaryCost, true, write_ply<PlacedSurface>, write_ply_mesh};
constexpr SurfacePointFormat kGlbFile{
    {"glb", "glTF, binary", "glb", "model/gltf-binary", ""}, 12, kBinaryCost, true, write_glb_points, write_glb_mesh};
constexpr SurfacePointFormat kObjFile{
    {"obj", "Wavefront OBJ", "obj", "model/obj", ""}, 8, kTextCost, true, nullptr, write_obj_mesh};
constexpr SurfacePointFormat kStlFile{
    {"stl", "STL", "stl", "model/stl", ""}, 20, kBinaryCost, true, nullptr, write_stl_mesh};

constexpr const SurfacePointFormat* kFormats[] = {&kJsonPoints, &kCsvPoints, &kNpyPoints, &kPlyFile,
                                                  &kGlbFile,    &kObjFile,   &kStlFile};

}  // namespace

std::span<const SurfacePointFormat* const> surface_formats() {
    return kFormats;
}

}  // namespace ccdt::api
