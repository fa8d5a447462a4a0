// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/surface_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "api/image/embedded_image.h"
#include "api/image/image_header.h"
#include "api/json/json_document.h"
#include "api/surface/obj.h"
#include "api/surface/off.h"
#include "api/surface/surface_format.h"
#include "api/text/byte_order_mark.h"
#include "api/text/text.h"
#include "core/surface/triangle_soup.h"

namespace ccdt::api {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";
constexpr std::size_t kStlHead = 84;   ///< text and number of facets, bytes
constexpr std::size_t kStlFacet = 50;  ///< bytes

/// Reads a 32-bit little-endian number. The bytes must exist.
std::uint64_t number_at(std::string_view bytes, std::size_t at) {
    std::array<std::uint8_t, 4> raw{};
    std::memcpy(raw.data(), bytes.data() + at, raw.size());
    return raw[0] | std::uint64_t{raw[1]} << 8 | std::uint64_t{raw[2]} << 16 | std::uint64_t{raw[3]} << 24;
}

/// Counts the words of a text, which blanks separate.
std::uint64_t count_words(std::string_view text) {
    std::uint64_t words = 0;
    bool in_blank = true;
    for (const char c : text) {
        const bool is_blank = static_cast<unsigned char>(c) <= ' ';
        words += in_blank && !is_blank ? 1 : 0;
        in_blank = is_blank;
    }
    return words;
}

/// Removes the next word and the blanks around it from a text.
std::string_view take_word(std::string_view& text, std::string_view blanks = kBlanks) {
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    const std::string_view word = text.substr(0, text.find_first_of(blanks));
    text.remove_prefix(word.size());
    return word;
}

/// Upper bounds of the numbers of triangles and vertices in a file.
struct Bounds {
    std::uint64_t triangles = 0;
    std::uint64_t vertices = 0;
    std::uint64_t faces = 0;  ///< number of faces that the file must have
    bool is_exact = false;    ///< whether `triangles` is the number of triangles, not only a bound
};

/// Returns the largest number of triangles into which polygons with a total number of corners can be divided.
std::uint64_t triangles_of(std::uint64_t corners, std::uint64_t polygons) {
    return corners > 2 * polygons ? corners - 2 * polygons : 0;
}

/// Returns the error of a file that is shorter than its header requires.
tl::unexpected<Error> too_short(SurfaceFormat format, std::uint64_t needed, std::uint64_t present) {
    return unusable_surface(format, "its header announces at least " + std::to_string(needed) +
                                        " numbers or bytes, but the file has " + std::to_string(present));
}

bool is_binary_stl(std::string_view bytes) {
    return bytes.size() >= kStlHead && (bytes.size() - kStlHead) % kStlFacet == 0 &&
           number_at(bytes, kStlHead - 4) == (bytes.size() - kStlHead) / kStlFacet;
}

Result<Bounds> bounds_of_binary_stl(std::string_view bytes) {
    const std::uint64_t facets = bytes.size() < kStlHead ? 0 : number_at(bytes, kStlHead - 4);
    const std::uint64_t needed = kStlHead + kStlFacet * facets;
    if (needed > bytes.size()) return too_short(SurfaceFormat::StlBinary, needed, bytes.size());
    return Bounds{facets, 3 * facets, facets, true};
}

Bounds bounds_of_text_stl(std::string_view text) {
    constexpr std::string_view kVertex = "vertex";
    std::uint64_t vertices = 0;
    for (auto at = text.find(kVertex); at != std::string_view::npos; at = text.find(kVertex, at + kVertex.size()))
        ++vertices;
    return {(vertices + 2) / 3, vertices, 0, true};
}

constexpr auto kObjStatements =
    std::to_array<std::string_view>({"v", "vn", "vt", "vp", "f", "o", "g", "s", "l", "p", "mtllib", "usemtl"});

bool is_obj(std::string_view text) {
    while (!text.empty()) {
        const std::string_view line = trim(take_obj_line(text), kBlanks);
        if (line.empty() || line.starts_with('#')) continue;
        return std::ranges::find(kObjStatements, line.substr(0, line.find_first_of(kBlanks))) != kObjStatements.end();
    }
    return false;
}

Bounds bounds_of_obj(std::string_view text) {
    Bounds bounds;
    while (!text.empty()) {
        std::string_view line = trim(take_obj_line(text), kBlanks);
        const std::string_view statement = take_word(line);
        if (statement != "f" && statement != "l" && statement != "p") continue;
        std::uint64_t corners = count_words(line);
        while (line.ends_with('\\') && !text.empty()) {  // the statement continues on the next line
            line = trim(take_obj_line(text), kBlanks);
            corners += count_words(line);
        }
        bounds.vertices += 2 * corners;  // the library makes segments of a line, so most corners become two vertices
        if (statement != "f") continue;
        bounds.vertices -= corners;
        bounds.triangles += triangles_of(corners, 1);
        ++bounds.faces;
    }
    bounds.is_exact = true;
    return bounds;
}

/// Returns the size of a value in a PLY, in bytes, or in words if the file is a text; 1 for unknown types.
std::uint64_t size_of_type(std::string_view type, bool is_text) {
    return is_text ? 1 : std::max<std::uint64_t>(size_of_ply_type(type), 1);
}

/// @param format  the format in errors
Result<Bounds> bounds_of_ply(std::string_view bytes, SurfaceFormat format) {
    Bounds bounds;
    bool is_text = true;
    std::uint64_t count = 0;   // of the elements that are being declared
    std::uint64_t needed = 0;  // size of all elements if their lists are empty
    bool has_indices = false;  // whether some lists are the corners of faces; without them, the library crashes
    std::uint64_t item = 8;    // smallest size of an entry of a list
    for (std::string_view word; word != "end_header";) {
        if (bytes.empty()) return unusable_surface(format, "its header has no end");
        std::string_view line = trim(take_until(bytes, "\n"), kBlanks);
        word = take_word(line);
        if (word == "format") is_text = take_word(line) == "ascii";
        if (word == "element") {
            const std::string_view name = take_word(line);
            const auto number = parse_number<std::uint32_t>(take_word(line));
            if (!number) return unusable_surface(format, "its header lacks a number of elements below 4294967296");
            count = *number;
            if (name == "vertex") bounds.vertices = count;
            if (name == "face") bounds.faces = count;
            // The library returns only one triangle of each strip.
            if (name == "tristrips") return unusable_surface(format, "triangle strips are not supported");
        }
        if (word == "property") {
            std::string_view type = take_word(line);
            const bool is_list = type == "list";
            if (is_list) type = take_word(line);
            needed += count * size_of_type(type, is_text);
            if (is_list) item = std::min(item, size_of_type(take_word(line), is_text));
            const std::string_view name = trim(line, kBlanks);
            has_indices |= is_list && (name == "vertex_indices" || name == "vertex_index");
        }
    }
    const std::uint64_t present = is_text ? count_words(bytes) : bytes.size();
    if (needed > present) return too_short(format, needed, present);
    if (bounds.faces > 0 && !has_indices) return unusable_surface(format, "its faces have no list vertex_indices");
    bounds.triangles = triangles_of((present - needed) / item, bounds.faces);
    return bounds;
}

/// Parts of a glTF file.
struct GltfParts {
    std::string_view json;
    std::string_view binary;  ///< content of the first buffer; empty if it is not in the file itself
};

/// Divides a glTF file into its parts. Errors: Unusable for a damaged container.
Result<GltfParts> parts_of_gltf(std::string_view bytes, SurfaceFormat format) {
    if (format == SurfaceFormat::Gltf) return GltfParts{bytes, {}};
    constexpr std::size_t kHead = 20, kChunkHead = 8;  // the first one includes the head of the first chunk
    if (bytes.size() >= kHead && number_at(bytes, 4) != 2)
        return unusable_surface(
            format, "its version is " + std::to_string(number_at(bytes, 4)) + "; only version 2 is supported");
    if (bytes.size() < kHead || number_at(bytes, 8) > bytes.size() || number_at(bytes, 12) > bytes.size() - kHead)
        return unusable_surface(format, "it is truncated");
    const auto size = static_cast<std::size_t>(number_at(bytes, 12));
    const std::string_view rest = bytes.substr(kHead + size);
    return GltfParts{trim(bytes.substr(kHead, size), std::string_view(" \0", 2)),
                     rest.substr(std::min(kChunkHead, rest.size()))};
}

/// Reads the JSON of a glTF.
class Gltf {
public:
    Gltf(JsonValue root, std::string_view binary, SurfaceFormat format)
        : root_(root), binary_(binary), format_(format) {}

    /// Returns bounds of the triangles and vertices of the scene.
    Result<Bounds> bounds() const {
        if (const auto checked = check_contents(); !checked) return tl::unexpected(checked.error());
        const auto nodes = list(root_, "nodes"), meshes = list(root_, "meshes");
        struct Visit {
            std::size_t node;
            int depth;
        };
        std::vector<Visit> waiting;
        std::vector<std::uint8_t> is_reached(nodes.size(), 0);
        const auto reach = [&](JsonValue parent, std::string_view name, int depth) {
            return std::ranges::all_of(list(parent, name), [&](JsonValue child) {
                const auto node = index(child, nodes.size());
                if (!node || std::exchange(is_reached[*node], std::uint8_t{1}) != 0 || depth > kMaxDepth) return false;
                waiting.push_back({*node, depth});
                return true;
            });
        };
        const auto scenes = list(root_, "scenes");
        const std::size_t scene = index(member(root_, "scene"), scenes.size()).value_or(0);
        bool is_tree = scenes.empty() || reach(scenes[scene], "nodes", 0);
        Bounds bounds{.is_exact = true};
        while (is_tree && !waiting.empty()) {
            const auto [node, depth] = waiting.back();
            waiting.pop_back();
            is_tree = reach(nodes[node], "children", depth + 1);
            if (const auto mesh = index(member(nodes[node], "mesh"), meshes.size())) add_mesh(meshes[*mesh], bounds);
        }
        if (is_tree) return bounds;
        return unusable_surface(format_, "its nodes do not form a tree with at most 500 levels");
    }

    /// Adds the pictures of materials to the header: their pixels, and the memory for reading them.
    void add_pictures(std::size_t max_pixels, SurfaceHeader& header) const {
        const auto textures = list(root_, "textures"), images = list(root_, "images");
        std::vector<std::uint8_t> is_used(images.size(), 0);
        for (const JsonValue material : list(root_, "materials")) {
            const auto colour = member(member(material, "pbrMetallicRoughness"), "baseColorTexture");
            const auto texture = index(member(colour, "index"), textures.size());
            const auto image = texture ? index(member(textures[*texture], "source"), images.size()) : std::nullopt;
            if (image) is_used[*image] = 1;
        }
        std::uint64_t largest = 0;
        for (std::size_t i = 0; i < images.size(); ++i) {
            if (is_used[i] == 0) continue;
            const auto picture = read_image_header(bytes_of(images[i]), max_pixels);
            if (!picture) continue;                // the decoder reports the error
            constexpr std::uint64_t kPlanes = 16;  // bytes of a pixel
            largest = std::max(largest, picture->decoder_bytes + kPlanes * picture->pixels());
            header.texels += picture->pixels();
        }
        header.max_pixels = max_pixels;
        header.texels = std::min<std::uint64_t>(header.texels, max_pixels);
        header.decoder_bytes += largest + 2 * sizeof(TriangleSoup::texels[0]) * header.texels;
    }

private:
    static constexpr int kMaxDepth = 500;  ///< the library recurses

    static std::optional<JsonValue> member(std::optional<JsonValue> object, std::string_view name) {
        return object && object->is_object() ? object->find(name) : std::nullopt;
    }

    static std::vector<JsonValue> list(JsonValue object, std::string_view name) {
        std::vector<JsonValue> values;
        const auto array = member(object, name);
        if (!array || !array->is_array()) return values;
        for (const JsonValue value : *array) values.push_back(value);
        return values;
    }

    /// Reads an index or a size below a limit.
    static std::optional<std::size_t> index(std::optional<JsonValue> value, std::size_t limit) {
        if (!value || !value->is_number()) return std::nullopt;
        const double number = value->number();
        if (!(number >= 0 && number < static_cast<double>(limit))) return std::nullopt;
        return static_cast<std::size_t>(number);
    }

    /// Whether the offsets and scales of all texture transformations below a value are pairs of numbers. The library
    /// aborts otherwise.
    static bool has_valid_transforms(JsonValue value) {
        if (!value.is_object()) return true;
        return std::ranges::all_of(value.members(), [](const JsonValue::Member& each) {
            if (each.name != "KHR_texture_transform") return has_valid_transforms(each.value);
            return std::ranges::all_of(std::array{"offset", "scale"}, [&](std::string_view name) {
                const auto pair = list(each.value, name);
                return !member(each.value, name) || (pair.size() == 2 && pair[0].is_number() && pair[1].is_number());
            });
        });
    }

    Result<void> check_contents() const {
        const auto version = member(member(root_, "asset"), "version");
        if (!version || !version->is_string() || !version->text().starts_with("2."))
            return unusable_surface(format_, "asset/version is not 2.x; only glTF 2 is supported");
        for (const JsonValue buffer : list(root_, "buffers")) {
            const auto uri = member(buffer, "uri");
            if (uri && uri->is_string() && !uri->text().starts_with("data:"))
                return unusable_surface(format_, "its data is in another file (" + uri->text().substr(0, 100) +
                                                     "); send a GLB, or embed the data");
        }
        if (!std::ranges::all_of(list(root_, "materials"), has_valid_transforms))
            return unusable_surface(format_, "a KHR_texture_transform is damaged");
        for (const JsonValue image : list(root_, "images")) {
            const auto declared = member(image, "mimeType"), uri = member(image, "uri");
            std::string_view type = declared && declared->is_string() ? std::string_view(declared->text()) : "image/";
            std::string_view data = uri && uri->is_string() ? std::string_view(uri->text()) : "";
            if (data.starts_with("data:")) type = data.substr(5, data.find_first_of(";,") - 5);
            // The library reads beyond the end of a type without a slash.
            if (!type.empty() && type.find('/') == std::string_view::npos)
                return unusable_surface(format_, "an image has an invalid media type");
        }
        constexpr auto kUnsupported = std::to_array<std::string_view>(
            {"KHR_mesh_quantization", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing"});
        for (const JsonValue extension : list(root_, "extensionsRequired")) {
            if (extension.is_string() && std::ranges::find(kUnsupported, extension.text()) != kUnsupported.end())
                return unusable_surface(format_, "the extension " + extension.text() + " is not supported");
        }
        return {};
    }

    void add_mesh(JsonValue mesh, Bounds& bounds) const {
        constexpr std::size_t kMost = std::size_t{1} << 32;
        const auto accessors = list(root_, "accessors");
        const auto count_of = [&](std::optional<JsonValue> accessor) -> std::optional<std::uint64_t> {
            const auto found = index(accessor, accessors.size());
            return found ? index(member(accessors[*found], "count"), kMost) : std::nullopt;
        };
        for (const JsonValue primitive : list(mesh, "primitives")) {
            const std::uint64_t vertices = count_of(member(member(primitive, "attributes"), "POSITION")).value_or(0);
            const std::uint64_t corners = count_of(member(primitive, "indices")).value_or(vertices);
            const std::size_t mode = index(member(primitive, "mode"), kMost).value_or(4);
            bounds.vertices += vertices;
            const std::uint64_t triangles = mode > 4 ? triangles_of(corners, 1) : mode == 4 ? corners / 3 : 0;
            bounds.triangles += triangles;
            bounds.faces += triangles;
        }
    }

    /// Returns the bytes of an image; none if it is not in the file.
    std::string bytes_of(JsonValue image) const {
        const auto uri_of = [](JsonValue object) {
            const auto uri = member(object, "uri");
            std::string_view text = uri && uri->is_string() ? std::string_view(uri->text()) : std::string_view();
            if (text.starts_with("data:")) take_until(text, ",");
            return text;
        };
        if (const std::string_view text = uri_of(image); !text.empty()) return decode_base64(text).value_or("");
        const auto views = list(root_, "bufferViews"), buffers = list(root_, "buffers");
        const auto view = index(member(image, "bufferView"), views.size());
        const auto buffer = view ? index(member(views[*view], "buffer"), buffers.size()) : std::nullopt;
        if (!buffer) return {};
        constexpr std::size_t kMost = std::size_t{1} << 32;
        const std::size_t offset = index(member(views[*view], "byteOffset"), kMost).value_or(0);
        const std::size_t length = index(member(views[*view], "byteLength"), kMost).value_or(0);
        const std::string_view text = uri_of(buffers[*buffer]);
        if (text.empty()) return std::string(binary_.substr(std::min(offset, binary_.size()), length));
        const std::size_t begin = offset / 3 * 4, end = (offset + length + 2) / 3 * 4;
        std::string bytes = decode_base64(text.substr(std::min(begin, text.size()), end - begin)).value_or("");
        return bytes.substr(std::min(offset % 3, bytes.size()), length);
    }

    JsonValue root_;
    std::string_view binary_;
    SurfaceFormat format_;
};

/// Whether a text is JSON with member names that each glTF has.
bool is_gltf(std::string_view text) {
    const auto has = [text](std::string_view name) { return text.find(name) != std::string_view::npos; };
    return trim(text.substr(0, text.find('{') + 1), kBlanks) == "{" && has("\"asset\"") && has("\"bufferViews\"");
}

/// Returns bounds of a file that is not a glTF.
Result<Bounds> bounds_of(std::string_view bytes, SurfaceFormat format) {
    if (format == SurfaceFormat::StlText) return bounds_of_text_stl(bytes);
    if (format == SurfaceFormat::StlBinary) return bounds_of_binary_stl(bytes);
    if (format == SurfaceFormat::Obj) return bounds_of_obj(bytes);
    if (format == SurfaceFormat::Ply) return bounds_of_ply(bytes, format);
    return ply_of_off(bytes).and_then([&](const std::string& ply) { return bounds_of_ply(ply, format); });
}

/// Returns the memory for reading a file: twice the memory measured with files of a million faces.
std::uint64_t decoder_bytes_of(const SurfaceHeader& header, std::size_t file) {
    constexpr std::uint64_t kBase = std::uint64_t{48} << 20;
    const std::uint64_t per_triangle = header.format == SurfaceFormat::Obj ? 300 : 60;
    return kBase + 2 * file + per_triangle * header.max_triangles + 110 * header.max_vertices;
}

Result<SurfaceHeader> header_of(const Result<Bounds>& bounds, std::size_t file, SurfaceFormat format,
                                std::size_t max_faces) {
    if (!bounds) return tl::unexpected(bounds.error());
    if (bounds->triangles == 0) return unusable_surface(format, "it has no triangles or polygons");
    // Vertices are limited, too, because a file with few faces may have any number of them.
    const std::uint64_t least = bounds->is_exact ? bounds->triangles : bounds->faces;
    if (least > max_faces || bounds->vertices / 3 > max_faces) return too_many_faces(max_faces);
    SurfaceHeader header{format, bounds->faces, std::min<std::uint64_t>(bounds->triangles, max_faces),
                         bounds->vertices};
    header.decoder_bytes = decoder_bytes_of(header, file);
    return header;
}

}  // namespace

std::optional<SurfaceFormat> recognise_surface(std::string_view bytes, std::string_view media_type) {
    bytes = without_byte_order_mark(bytes);
    if (bytes.starts_with("glTF")) return SurfaceFormat::Glb;
    if (is_binary_stl(bytes)) return SurfaceFormat::StlBinary;
    std::string_view text = bytes;
    const std::string_view first = take_word(text);
    if (first == "ply") return SurfaceFormat::Ply;
    if (is_off(bytes)) return SurfaceFormat::Off;
    if (first == "solid") return SurfaceFormat::StlText;
    if (is_gltf(bytes)) return SurfaceFormat::Gltf;
    if (is_obj(bytes)) return SurfaceFormat::Obj;
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

std::uint64_t size_of_ply_type(std::string_view type) {
    const auto is_any_of = [type](auto... names) { return ((type == names) || ...); };
    if (is_any_of("char", "uchar", "int8", "uint8")) return 1;
    if (is_any_of("short", "ushort", "int16", "uint16")) return 2;
    if (is_any_of("int", "uint", "int32", "uint32", "float", "float32")) return 4;
    return is_any_of("double", "float64") ? 8 : 0;
}

tl::unexpected<Error> too_many_faces(std::uint64_t max_faces) {
    return failure(ErrorCode::LimitExceeded,
                   "the mesh has too many faces; this server's limit (max-faces) is " + std::to_string(max_faces));
}

Result<SurfaceHeader> read_surface_header(std::string_view bytes, SurfaceFormat format, std::size_t max_faces,
                                          std::size_t max_pixels) {
    if (format != SurfaceFormat::Gltf && format != SurfaceFormat::Glb)
        return header_of(bounds_of(bytes, format), bytes.size(), format, max_faces);
    const auto parts = parts_of_gltf(bytes, format);
    if (!parts) return tl::unexpected(parts.error());
    const auto document = JsonDocument::parse(parts->json);
    if (!document) return unusable_surface(format, document.error().message);
    const Gltf gltf(document->root(), parts->binary, format);
    auto header = header_of(gltf.bounds(), bytes.size(), format, max_faces);
    if (header && max_pixels > 0) gltf.add_pictures(max_pixels, *header);
    return header;
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
