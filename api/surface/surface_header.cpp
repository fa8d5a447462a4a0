// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/surface_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "api/json/json_document.h"
#include "api/surface/off_header.h"
#include "api/surface/surface_errors.h"
#include "api/text/byte_order_mark.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";
constexpr std::size_t kStlHead = 84;   ///< text and number of facets, bytes
constexpr std::size_t kStlFacet = 50;  ///< bytes

/// Reads a 32-bit little-endian number. The bytes must exist.
std::uint64_t number_at(std::string_view bytes, std::size_t at) {
    std::array<std::uint8_t, 4> raw{};
    std::memcpy(raw.data(), bytes.data() + at, raw.size());
    return raw[0] | raw[1] << 8 | raw[2] << 16 | std::uint64_t{raw[3]} << 24;
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

bool is_binary_stl(std::string_view bytes) {
    return bytes.size() >= kStlHead && (bytes.size() - kStlHead) % kStlFacet == 0 &&
           number_at(bytes, kStlHead - 4) == (bytes.size() - kStlHead) / kStlFacet;
}

Result<Bounds> bounds_of_binary_stl(std::string_view bytes) {
    const std::uint64_t facets = bytes.size() < kStlHead ? 0 : number_at(bytes, kStlHead - 4);
    const std::uint64_t expected = kStlHead + kStlFacet * facets;
    if (bytes.size() != expected)
        return unusable_surface("STL", "its header promises " + std::to_string(facets) + " facets in " +
                                           std::to_string(expected) + " bytes, but the file has " +
                                           std::to_string(bytes.size()));
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
        const std::string_view line = trim(take_until(text, "\n"), kBlanks);
        if (line.empty() || line.starts_with('#')) continue;
        return std::ranges::find(kObjStatements, line.substr(0, line.find_first_of(kBlanks))) != kObjStatements.end();
    }
    return false;
}

Bounds bounds_of_obj(std::string_view text) {
    Bounds bounds;
    while (!text.empty()) {
        std::string_view line = trim(take_until(text, "\n"), kBlanks);
        const std::string_view statement = take_word(line);
        if (statement != "f" && statement != "l" && statement != "p") continue;
        std::uint64_t corners = count_words(line);
        while (line.ends_with('\\') && !text.empty()) {  // the statement continues on the next line
            line = trim(take_until(text, "\n"), kBlanks);
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

/// An element of the header of a PLY. Sizes are in bytes, or in words if the file is a text.
struct PlyElement {
    std::string_view name;
    std::uint64_t count = 0;
    std::uint64_t size = 0;  ///< size if all lists are empty
    std::uint64_t item = 0;  ///< smallest size of an entry of a list; 0 without lists
};

struct PlyHeader {
    std::vector<PlyElement> elements;
    bool is_text = true;
    std::string_view data;
};

/// Reads a line that declares a property; returns false for an unknown type.
bool add_property(PlyElement& element, std::string_view line, bool is_text) {
    const auto size_of_next = [&] {
        const std::uint64_t size = size_of_ply_type(take_word(line));
        return is_text ? std::min<std::uint64_t>(size, 1) : size;
    };
    std::string_view rest = line;
    const bool is_list = take_word(rest) == "list";
    if (is_list) line = rest;
    const std::uint64_t size = size_of_next();
    const std::uint64_t item = is_list ? size_of_next() : 0;
    element.size += size;
    if (is_list) element.item = element.item == 0 ? item : std::min(element.item, item);
    return size > 0 && (item > 0 || !is_list);
}

Result<PlyHeader> read_ply_header(std::string_view bytes) {
    PlyHeader header;
    const auto fail = [](int number, std::string_view reason) {
        return unusable_surface("PLY", "line " + std::to_string(number) + " of its header " + std::string(reason));
    };
    for (int number = 1; !bytes.empty(); ++number) {
        std::string_view line = trim(take_until(bytes, "\n"), kBlanks);
        const std::string_view word = take_word(line);
        if (word == "end_header") {
            header.data = bytes;
            return header;
        }
        if (word == "format") {
            header.is_text = take_word(line) == "ascii";
        } else if (word == "element") {
            const std::string_view name = take_word(line);
            const auto count = parse_number<std::uint32_t>(take_word(line));
            if (!count) return fail(number, "does not give a number of elements below 4294967296");
            header.elements.push_back({.name = name, .count = *count});
        } else if (word == "property") {
            if (header.elements.empty() || !add_property(header.elements.back(), line, header.is_text))
                return fail(number, "does not declare a property of a known type");
        }
    }
    return unusable_surface("PLY", "its header has no end");
}

Result<Bounds> bounds_of_ply(std::string_view bytes) {
    const auto header = read_ply_header(bytes);
    if (!header) return tl::unexpected(header.error());
    Bounds bounds;
    std::uint64_t needed = 0;
    std::uint64_t item = 0;
    for (const PlyElement& element : header->elements) {
        needed += element.count * element.size;
        if (element.name == "vertex") bounds.vertices = element.count;
        if (element.name == "face") bounds.faces = element.count;
        // The library returns only one triangle of each strip.
        if (element.name == "tristrips") return unusable_surface("PLY", "triangle strips are not supported");
        if (element.item > 0) item = item == 0 ? element.item : std::min(item, element.item);
    }
    const std::uint64_t present = header->is_text ? count_words(header->data) : header->data.size();
    if (needed > present) {
        const char* const unit = header->is_text ? " numbers" : " bytes";
        return unusable_surface("PLY", "its header promises at least " + std::to_string(needed) + unit +
                                           ", but the file has " + std::to_string(present));
    }
    if (item > 0) bounds.triangles = triangles_of((present - needed) / item, bounds.faces);
    return bounds;
}

Result<Bounds> bounds_of_off(std::string_view text) {
    const auto header = read_off_header(text);
    if (!header) return tl::unexpected(header.error());
    const std::uint64_t needed = header->vertices * header->values_per_vertex() + header->faces;
    const std::uint64_t present = count_words(header->data);
    if (needed > present)
        return unusable_surface("OFF", "its header promises at least " + std::to_string(needed) +
                                           " numbers, but the file has " + std::to_string(present));
    const std::uint64_t triangles = triangles_of(present - needed, header->faces);
    return Bounds{triangles, header->vertices, header->faces};
}

/// Returns the JSON part of a glTF. Errors: Unusable for a damaged container.
Result<std::string_view> json_of_gltf(std::string_view bytes, SurfaceFormat format) {
    if (format == SurfaceFormat::Gltf) return bytes;
    constexpr std::size_t kHead = 20;  // header and the head of the first chunk
    if (bytes.size() < kHead) return unusable_surface(name_of(format), "it is truncated");
    if (number_at(bytes, 4) != 2)
        return unusable_surface(
            name_of(format), "its version is " + std::to_string(number_at(bytes, 4)) + "; only version 2 is supported");
    if (bytes.substr(16, 4) != "JSON") return unusable_surface(name_of(format), "its first chunk is not JSON");
    const std::uint64_t size = number_at(bytes, 12);
    if (size > bytes.size() - kHead || number_at(bytes, 8) > bytes.size())
        return unusable_surface(name_of(format), "it is truncated");
    return trim(bytes.substr(kHead, static_cast<std::size_t>(size)), std::string_view(" \0", 2));
}

/// The JSON part of a glTF.
class Gltf {
public:
    Gltf(JsonValue root, SurfaceFormat format)
        : root_(root),
          format_(format),
          nodes_(list(root, "nodes")),
          meshes_(list(root, "meshes")),
          accessors_(list(root, "accessors")) {}

    /// Counts the triangles and vertices of the scene.
    Result<Bounds> bounds() const {
        if (const auto checked = check_contents(); !checked) return tl::unexpected(checked.error());
        Bounds bounds;
        std::size_t visited = 0;
        struct Visit {
            JsonValue node;
            int depth;
        };
        std::vector<Visit> waiting;
        const auto add = [&](std::vector<JsonValue> references, int depth) -> bool {
            for (const JsonValue reference : references) {
                const auto node = element(nodes_, reference);
                if (!node) return false;
                waiting.push_back({*node, depth});
            }
            return true;
        };
        if (!add(roots(), 0))
            return unusable_surface(name_of(format_), "its scene refers to a node that does not exist");
        while (!waiting.empty()) {
            const auto [node, depth] = waiting.back();
            waiting.pop_back();
            if (++visited > nodes_.size()) return unusable_surface(name_of(format_), "its nodes do not form a tree");
            if (depth > kMaxDepth) return unusable_surface(name_of(format_), "its nodes are nested more than 500 deep");
            if (!add(list(node, "children"), depth + 1))
                return unusable_surface(name_of(format_), "a node refers to a child that does not exist");
            if (const auto added = add_mesh(node, bounds); !added) return tl::unexpected(added.error());
        }
        bounds.faces = bounds.triangles;
        bounds.is_exact = true;
        return bounds;
    }

private:
    static constexpr int kMaxDepth = 500;  ///< the library recurses
    static constexpr double kFloat = 5126;

    static std::vector<JsonValue> list(JsonValue object, std::string_view name) {
        std::vector<JsonValue> values;
        const auto array = object.is_object() ? object.find(name) : std::nullopt;
        if (!array || !array->is_array()) return values;
        for (const JsonValue value : *array) values.push_back(value);
        return values;
    }

    static std::optional<double> number(JsonValue object, std::string_view name) {
        const auto value = object.is_object() ? object.find(name) : std::nullopt;
        if (!value || !value->is_number()) return std::nullopt;
        return value->number();
    }

    /// Returns the element that an index refers to; none if there is no such element.
    static std::optional<JsonValue> element(const std::vector<JsonValue>& values, std::optional<JsonValue> index) {
        if (!index || !index->is_number()) return std::nullopt;
        const double number = index->number();
        if (!(number >= 0 && number < static_cast<double>(values.size()))) return std::nullopt;
        return values[static_cast<std::size_t>(number)];
    }

    Result<void> check_contents() const {
        const auto asset = root_.is_object() ? root_.find("asset") : std::nullopt;
        const auto version = asset && asset->is_object() ? asset->find("version") : std::nullopt;
        if (!version || !version->is_string() || !version->text().starts_with("2."))
            return unusable_surface(name_of(format_), "asset/version is not 2.x; only glTF 2 is supported");
        for (const JsonValue buffer : list(root_, "buffers")) {
            const auto uri = buffer.is_object() ? buffer.find("uri") : std::nullopt;
            if (uri && uri->is_string() && !uri->text().starts_with("data:"))
                return unusable_surface(name_of(format_), "its data is in another file (" + uri->text().substr(0, 100) +
                                                              "); send a GLB, or embed the data");
        }
        constexpr auto kUnsupported = std::to_array<std::string_view>(
            {"KHR_mesh_quantization", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing"});
        for (const JsonValue extension : list(root_, "extensionsRequired")) {
            if (extension.is_string() && std::ranges::find(kUnsupported, extension.text()) != kUnsupported.end())
                return unusable_surface(name_of(format_), "the extension " + extension.text() + " is not supported");
        }
        return {};
    }

    std::vector<JsonValue> roots() const {
        const auto scenes = list(root_, "scenes");
        const auto chosen = root_.find("scene");
        if (const auto scene = element(scenes, chosen)) return list(*scene, "nodes");
        return scenes.empty() ? std::vector<JsonValue>() : list(scenes.front(), "nodes");
    }

    Result<void> add_mesh(JsonValue node, Bounds& bounds) const {
        const auto index = node.is_object() ? node.find("mesh") : std::nullopt;
        if (!index) return {};
        const auto mesh = element(meshes_, index);
        if (!mesh) return unusable_surface(name_of(format_), "a node refers to a mesh that does not exist");
        for (const JsonValue primitive : list(*mesh, "primitives")) {
            if (!add_primitive(primitive, bounds))
                return unusable_surface(name_of(format_),
                                        "a mesh has no positions, or positions that are not of type FLOAT");
        }
        return {};
    }

    /// @returns  false if the primitive has no positions
    bool add_primitive(JsonValue primitive, Bounds& bounds) const {
        if (!primitive.is_object()) return false;
        const auto attributes = primitive.find("attributes");
        if (!attributes || !attributes->is_object()) return false;
        const auto positions = element(accessors_, attributes->find("POSITION"));
        if (!positions || number(*positions, "componentType") != kFloat) return false;
        const auto indices = element(accessors_, primitive.find("indices"));
        const std::uint64_t vertices = count_of(*positions);
        const std::uint64_t corners = indices ? count_of(*indices) : vertices;
        bounds.vertices += vertices;
        const double mode = number(primitive, "mode").value_or(4);
        if (mode == 4) bounds.triangles += corners / 3;
        if (mode > 4) bounds.triangles += triangles_of(corners, 1);
        return true;
    }

    static std::uint64_t count_of(JsonValue accessor) {
        constexpr double kMost = 4'294'967'295;
        const double count = number(accessor, "count").value_or(0);
        return count > 0 ? static_cast<std::uint64_t>(std::min(count, kMost)) : 0;
    }

    JsonValue root_;
    SurfaceFormat format_;
    std::vector<JsonValue> nodes_;
    std::vector<JsonValue> meshes_;
    std::vector<JsonValue> accessors_;
};

Result<Bounds> bounds_of_gltf(std::string_view bytes, SurfaceFormat format) {
    const auto json = json_of_gltf(bytes, format);
    if (!json) return tl::unexpected(json.error());
    const auto document = JsonDocument::parse(*json);
    if (!document) return unusable_surface(name_of(format), document.error().message);
    return Gltf(document->root(), format).bounds();
}

/// Whether a text is a JSON object with a member `asset` that is an object, as in a glTF.
bool is_gltf(std::string_view text) {
    constexpr std::string_view kAsset = "\"asset\"";
    if (!trim(text.substr(0, text.find('{') + 1), kBlanks).starts_with('{')) return false;
    const auto at = text.find(kAsset);
    if (at == std::string_view::npos) return false;
    std::string_view rest = text.substr(at + kAsset.size());
    constexpr std::size_t kLongest = 64;
    std::string opening;
    for (const char c : rest.substr(0, kLongest)) {
        if (kBlanks.find(c) == std::string_view::npos) opening += c;
    }
    return opening.starts_with(":{") && text.find("\"accessors\"") != std::string_view::npos;
}

Result<Bounds> bounds_of(std::string_view bytes, SurfaceFormat format) {
    switch (format) {
        case SurfaceFormat::StlText:
            return bounds_of_text_stl(bytes);
        case SurfaceFormat::StlBinary:
            return bounds_of_binary_stl(bytes);
        case SurfaceFormat::Obj:
            return bounds_of_obj(bytes);
        case SurfaceFormat::Ply:
            return bounds_of_ply(bytes);
        case SurfaceFormat::Off:
            return bounds_of_off(bytes);
        case SurfaceFormat::Gltf:
        case SurfaceFormat::Glb:
            break;
    }
    return bounds_of_gltf(bytes, format);
}

/// Returns the memory for reading a file: twice the memory measured with files of a million faces.
std::uint64_t decoder_bytes_of(const SurfaceHeader& header, std::size_t file) {
    constexpr std::uint64_t kBase = std::uint64_t{48} << 20;
    const std::uint64_t per_triangle = header.format == SurfaceFormat::Obj ? 300 : 60;
    return kBase + 2 * file + per_triangle * header.max_triangles + 110 * header.max_vertices;
}

}  // namespace

std::string_view name_of(SurfaceFormat format) {
    switch (format) {
        case SurfaceFormat::StlText:
        case SurfaceFormat::StlBinary:
            return "STL";
        case SurfaceFormat::Obj:
            return "OBJ";
        case SurfaceFormat::Ply:
            return "PLY";
        case SurfaceFormat::Off:
            return "OFF";
        case SurfaceFormat::Gltf:
            return "glTF";
        case SurfaceFormat::Glb:
            break;
    }
    return "GLB";
}

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
    constexpr auto kTypes = std::to_array<std::pair<std::string_view, SurfaceFormat>>(
        {{"model/stl", SurfaceFormat::StlBinary},
         {"model/x.stl-binary", SurfaceFormat::StlBinary},
         {"application/sla", SurfaceFormat::StlBinary},
         {"application/vnd.ms-pki.stl", SurfaceFormat::StlBinary},
         {"model/x.stl-ascii", SurfaceFormat::StlText},
         {"model/obj", SurfaceFormat::Obj},
         {"model/ply", SurfaceFormat::Ply},
         {"model/off", SurfaceFormat::Off},
         {"model/gltf+json", SurfaceFormat::Gltf},
         {"model/gltf-binary", SurfaceFormat::Glb}});
    const auto* const found = std::ranges::find(kTypes, media_type, &std::pair<std::string_view, SurfaceFormat>::first);
    if (found == kTypes.end()) return std::nullopt;
    return found->second;
}

std::uint64_t size_of_ply_type(std::string_view type) {
    constexpr auto kTypes = std::to_array<std::pair<std::string_view, std::uint64_t>>({{"char", 1},
                                                                                       {"uchar", 1},
                                                                                       {"int8", 1},
                                                                                       {"uint8", 1},
                                                                                       {"short", 2},
                                                                                       {"ushort", 2},
                                                                                       {"int16", 2},
                                                                                       {"uint16", 2},
                                                                                       {"int", 4},
                                                                                       {"uint", 4},
                                                                                       {"int32", 4},
                                                                                       {"uint32", 4},
                                                                                       {"float", 4},
                                                                                       {"float32", 4},
                                                                                       {"double", 8},
                                                                                       {"float64", 8}});
    const auto* const found = std::ranges::find(kTypes, type, &std::pair<std::string_view, std::uint64_t>::first);
    return found == kTypes.end() ? 0 : found->second;
}

tl::unexpected<Error> too_many_faces(std::uint64_t max_faces) {
    return failure(ErrorCode::LimitExceeded,
                   "the mesh has too many faces; this server's limit (max-faces) is " + std::to_string(max_faces));
}

Result<SurfaceHeader> read_surface_header(std::string_view bytes, SurfaceFormat format, std::size_t max_faces) {
    const auto bounds = bounds_of(bytes, format);
    if (!bounds) return tl::unexpected(bounds.error());
    if (bounds->triangles == 0) return unusable_surface(name_of(format), "it has no triangles or polygons");
    // Vertices are limited, too, because a file with few faces may have any number of them.
    const std::uint64_t least = bounds->is_exact ? bounds->triangles : bounds->faces;
    if (least > max_faces || bounds->vertices / 3 > max_faces) return too_many_faces(max_faces);
    SurfaceHeader header{format, bounds->faces, std::min<std::uint64_t>(bounds->triangles, max_faces),
                         bounds->vertices};
    header.decoder_bytes = decoder_bytes_of(header, bytes.size());
    return header;
}

}  // namespace ccdt::api
