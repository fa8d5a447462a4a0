// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/gltf_document.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <utility>

#include "api/image/embedded_image.h"
#include "api/surface/bytes.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kMax = std::numeric_limits<std::uint32_t>::max();
constexpr std::string_view kData = "data:";

std::size_t components_of(std::string_view shape) {
    constexpr auto kShapes = std::to_array<std::pair<std::string_view, std::size_t>>(
        {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}});
    const auto found = std::ranges::find(kShapes, shape, [](const auto& each) { return each.first; });
    return found == kShapes.end() ? 0 : found->second;
}

/// Returns the part of a data URI after its media type; none for other URIs.
std::optional<std::string_view> data_of(std::string_view uri) {
    if (in_small_letters(uri.substr(0, kData.size())) != kData) return std::nullopt;
    take_until(uri, ",");
    return uri;
}

/// Returns the memory of a value in a JsonDocument, in bytes.
std::uint64_t memory_of(JsonValue value) {
    constexpr std::uint64_t kNode = 16;
    if (value.is_string()) return kNode + sizeof(std::string) + value.text().size();
    std::uint64_t bytes = kNode;
    if (value.is_array()) {
        for (const JsonValue element : value) bytes += memory_of(element);
    } else if (value.is_object()) {
        for (const auto& [name, member] : value.members())
            bytes += kNode + sizeof(std::string) + name.size() + memory_of(member);
    }
    return bytes;
}

/// Parts of a file.
struct Parts {
    std::string_view json;
    std::string_view binary = {};
    std::size_t trailing_bytes = 0;
};

tl::unexpected<Error> wrong_glb(const std::string& reason) {
    return unusable_surface(SurfaceFormat::Glb, reason);
}

/// Divides a GLB into its chunks.
Result<Parts> parts_of_glb(std::string_view bytes) {
    constexpr std::size_t kHead = 12, kChunkHead = 8, kJson = kHead + kChunkHead;
    const auto number = [bytes](std::size_t at) { return std::size_t{number_at<std::uint32_t>(bytes.data() + at)}; };
    const auto chunk_type = [bytes](std::size_t at) { return bytes.substr(std::min(at + 4, bytes.size()), 4); };
    if (bytes.size() >= kHead && number(4) != 2)
        return wrong_glb("its version is " + std::to_string(number(4)) + "; only version 2 is supported");
    if (bytes.size() < kJson) return wrong_glb("it is truncated");
    const std::size_t size = number(8), json = number(kHead);
    if (size < kJson) return wrong_glb("its header announces only " + std::to_string(size) + " bytes");
    if (size > bytes.size())
        return wrong_glb("it is truncated: its header announces " + std::to_string(size) + " bytes, but it has " +
                         std::to_string(bytes.size()));
    Parts parts{{}, {}, bytes.size() - size};
    bytes = bytes.substr(0, size);
    if (chunk_type(kHead) != "JSON") return wrong_glb("its first chunk is not JSON");
    if (json > bytes.size() - kJson)
        return wrong_glb("its JSON chunk, with " + std::to_string(json) + " bytes, exceeds the file");
    parts.json = trim(bytes.substr(kJson, json), std::string_view(" \0\n\r\t", 5));
    // The length of the chunk should be a multiple of 4. Some programs leave the padding out, or do not count it.
    constexpr std::string_view kBinary("BIN\0", 4);
    std::size_t at = kJson + json;
    if (chunk_type(at) != kBinary && chunk_type((at + 3) / 4 * 4) == kBinary) at = (at + 3) / 4 * 4;
    while (at + kChunkHead <= bytes.size()) {
        const std::size_t length = number(at);
        if (length > bytes.size() - at - kChunkHead)
            return wrong_glb("its chunk at byte " + std::to_string(at) + ", with " + std::to_string(length) +
                             " bytes, exceeds the file");
        if (chunk_type(at) == kBinary) {
            parts.binary = bytes.substr(at + kChunkHead, length);
            break;
        }
        at += kChunkHead + length;
    }
    return parts;
}

}  // namespace

Result<GltfDocument> GltfDocument::parse(std::string_view bytes, SurfaceFormat format) {
    const auto parts = format == SurfaceFormat::Glb ? parts_of_glb(bytes) : Result<Parts>(Parts{bytes});
    if (!parts) return tl::unexpected(parts.error());
    GltfDocument gltf;
    gltf.format_ = format;
    gltf.binary_ = parts->binary;
    gltf.trailing_bytes_ = parts->trailing_bytes;
    auto document = JsonDocument::parse(parts->json);
    if (!document) return gltf.wrong(document.error().message);
    gltf.document_ = std::make_unique<const JsonDocument>(*std::move(document));
    for (const std::string_view name : {"accessors", "bufferViews", "buffers", "images", "materials", "meshes", "nodes",
                                        "samplers", "scenes", "skins", "textures"})
        gltf.arrays_.push_back({name, list(member(gltf.root(), name))});
    for (const JsonValue accessor : gltf.array("accessors"))
        gltf.counts_.push_back(index(member(accessor, "count"), kMax));
    gltf.buffers_.resize(gltf.array("buffers").size());
    if (const auto checked = gltf.check(); !checked) return tl::unexpected(checked.error());
    return gltf;
}

std::uint64_t GltfDocument::memory() const {
    return 3 * memory_of(root());  // vectors grow by copying
}

GltfDocument::Value GltfDocument::member(Value object, std::string_view name) {
    return object && object->is_object() ? object->find(name) : std::nullopt;
}

GltfDocument::Value GltfDocument::member(Value object, std::string_view name, std::string_view below) {
    return member(member(object, name), below);
}

std::vector<JsonValue> GltfDocument::list(Value array) {
    std::vector<JsonValue> values;
    if (!array || !array->is_array()) return values;
    values.reserve(array->size());
    for (const JsonValue value : *array) values.push_back(value);
    return values;
}

std::optional<std::size_t> GltfDocument::index(Value value, std::size_t limit) {
    if (!value || !value->is_number()) return std::nullopt;
    const double number = value->number();
    if (!(number >= 0 && number < static_cast<double>(limit))) return std::nullopt;
    return static_cast<std::size_t>(number);
}

double GltfDocument::number(Value value, double missing) {
    return value && value->is_number() ? value->number() : missing;
}

std::vector<double> GltfDocument::numbers(Value array, std::size_t size) {
    std::vector<double> numbers;
    if (!array || !array->is_array() || array->size() != size) return numbers;
    for (const JsonValue value : *array) numbers.push_back(number(value, 0));
    return numbers;
}

std::string_view GltfDocument::text(Value value) {
    return value && value->is_string() ? std::string_view(value->text()) : std::string_view();
}

const std::vector<JsonValue>& GltfDocument::array(std::string_view name) const {
    return std::ranges::find(arrays_, name, &Array::name)->values;
}

GltfDocument::Value GltfDocument::element(std::string_view name, Value value) const {
    const auto& values = array(name);
    const auto found = index(value, values.size());
    return found ? Value(values[*found]) : std::nullopt;
}

std::optional<std::size_t> GltfDocument::count(Value value) const {
    const auto found = index(value, counts_.size());
    return found ? counts_[*found] : std::nullopt;
}

std::vector<std::string_view> GltfDocument::unknown_extensions() const {
    // Prefixes of extensions that this project reads or that do not change the geometry.
    constexpr auto kKnown = std::to_array<std::string_view>(
        {"KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "MSFT_packing_", "KHR_lights_",
         "EXT_lights_", "KHR_animation_", "KHR_xmp", "KHR_mesh_quantization"});
    std::vector<std::string_view> unknown;
    for (const JsonValue extension : list(member(root(), "extensionsRequired"))) {
        const std::string_view name = text(extension);
        if (std::ranges::none_of(kKnown, [name](std::string_view known) { return name.starts_with(known); }))
            unknown.push_back(name);
    }
    return unknown;
}

Result<void> GltfDocument::check() const {
    if (!text(member(root(), "asset", "version")).starts_with("2."))
        return wrong("asset/version is not 2.x; only glTF 2 is supported");
    for (const JsonValue buffer : array("buffers")) {
        const std::string_view uri = text(member(buffer, "uri"));
        if (!uri.empty() && !data_of(uri))
            return wrong("its data is in another file (" + std::string(uri.substr(0, 100)) +
                         "); send a GLB, or embed the data");
    }
    constexpr auto kUnsupported =
        std::to_array<std::string_view>({"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                         "KHR_meshopt_compression", "EXT_mesh_gpu_instancing"});
    for (const JsonValue extension : list(member(root(), "extensionsRequired"))) {
        if (extension.is_string() && std::ranges::find(kUnsupported, extension.text()) != kUnsupported.end())
            return wrong("the extension " + extension.text() + " is not supported");
    }
    return {};
}

Result<std::string_view> GltfDocument::buffer(std::size_t index) const {
    const JsonValue object = array("buffers")[index];
    const auto name = "buffer " + std::to_string(index);
    std::string_view bytes = binary_;
    if (const auto data = data_of(text(member(object, "uri")))) {
        if (!buffers_[index]) {
            auto decoded = decode_base64(*data);
            if (!decoded) return wrong(name + " is not base64: " + decoded.error().message);
            buffers_[index] = *std::move(decoded);
        }
        bytes = *buffers_[index];
    } else if (index > 0) {
        return wrong(name + " has no data");
    }
    const auto size = GltfDocument::index(member(object, "byteLength"), kMax);
    if (!size || *size > bytes.size())
        return wrong(name + " has " + std::to_string(bytes.size()) + " bytes, fewer than it announces");
    return bytes.substr(0, *size);
}

Result<std::string_view> GltfDocument::view(Value value) const {
    const auto found = element("bufferViews", value);
    const auto at = index(member(found, "buffer"), array("buffers").size());
    if (!at) return wrong("an accessor or an image has no valid buffer");
    return buffer(*at).and_then([&](std::string_view bytes) -> Result<std::string_view> {
        const auto length = index(member(found, "byteLength"), kMax);
        const std::size_t offset = index(member(found, "byteOffset"), kMax).value_or(0);
        if (!length || offset > bytes.size() || *length > bytes.size() - offset)
            return wrong("buffer view " + std::to_string(static_cast<std::size_t>(value->number())) +
                         " exceeds its buffer");
        return bytes.substr(offset, *length);
    });
}

Result<GltfAccessor> GltfDocument::accessor(Value value, std::optional<std::size_t> count,
                                            std::size_t components) const {
    const auto object = element("accessors", value);
    if (!object) return wrong("a mesh refers to an accessor that is missing");
    const std::string name = "accessor " + std::to_string(static_cast<std::size_t>(value->number()));
    GltfAccessor accessor;
    accessor.count_ = this->count(value).value_or(0);
    accessor.components_ = components_of(text(member(object, "type")));
    accessor.type_ = static_cast<std::uint32_t>(index(member(object, "componentType"), kMax).value_or(0));
    const auto normalised = member(object, "normalized");
    accessor.is_normalised_ = normalised && normalised->is_boolean() && normalised->boolean();
    const std::size_t element = accessor.components_ * accessor.component_size();
    if (element == 0 || accessor.components_ < components || (count && *count != accessor.count_))
        return wrong(name + " has an unsuitable type or number of elements");
    accessor.stride_ = element;
    if (const auto view_index = member(object, "bufferView")) {
        const auto bytes = view(view_index);
        if (!bytes) return tl::unexpected(bytes.error());
        const auto stride = index(member(this->element("bufferViews", view_index), "byteStride"), kMax);
        const std::size_t offset = index(member(object, "byteOffset"), kMax).value_or(0);
        accessor.stride_ = std::max(stride.value_or(0), element);
        const std::size_t needed = accessor.count_ == 0 ? 0 : (accessor.count_ - 1) * accessor.stride_ + element;
        if (offset > bytes->size() || needed > bytes->size() - offset) return wrong(name + " exceeds its buffer view");
        accessor.bytes_ = bytes->substr(offset);
    }
    const auto sparse = member(object, "sparse");
    if (accessor.bytes_.empty() || sparse) {
        accessor.own_.resize(std::max<std::size_t>(accessor.count_, 1) * element);
        for (std::size_t i = 0; i < accessor.count_ && !accessor.bytes_.empty(); ++i)
            accessor.bytes_.copy(&accessor.own_[i * element], element, i * accessor.stride_);
        accessor.stride_ = element;
    }
    if (sparse) {
        if (const auto replaced = replace_elements(*sparse, accessor); !replaced)
            return tl::unexpected(replaced.error());
    }
    return accessor;
}

/// Replaces the elements of an accessor that a sparse storage lists.
Result<void> GltfDocument::replace_elements(JsonValue sparse, GltfAccessor& accessor) const {
    const auto part = [&](std::string_view name) -> Result<std::string_view> {
        return view(member(sparse, name, "bufferView")).map([&](std::string_view bytes) {
            const std::size_t offset = index(member(sparse, name, "byteOffset"), kMax).value_or(0);
            return bytes.substr(std::min(offset, bytes.size()));
        });
    };
    const auto positions = part("indices"), values = part("values");
    if (!positions) return tl::unexpected(positions.error());
    if (!values) return tl::unexpected(values.error());
    const std::size_t count = index(member(sparse, "count"), accessor.count_ + 1).value_or(0);
    GltfAccessor indices;
    indices.bytes_ = *positions;
    indices.type_ = static_cast<std::uint32_t>(index(member(sparse, "indices", "componentType"), kMax).value_or(0));
    indices.stride_ = indices.component_size();
    const std::size_t element = accessor.stride_;
    if (!indices.is_whole()) return wrong("the indices of a sparse accessor are not whole numbers");
    if (indices.stride_ == 0 || positions->size() / indices.stride_ < count || values->size() / element < count)
        return wrong("a sparse accessor exceeds its buffer view");
    for (std::size_t i = 0; i < count; ++i) {
        const double to = indices.at(i, 0);
        if (!(to >= 0 && to < static_cast<double>(accessor.count_)))
            return wrong("a sparse accessor replaces an element that is missing");
        values->copy(&accessor.own_[static_cast<std::size_t>(to) * element], element, i * element);
    }
    return {};
}

std::string GltfDocument::bytes_of_image(JsonValue image) const {
    if (const auto data = data_of(text(member(image, "uri")))) return decode_base64(*data).value_or("");
    const auto view = element("bufferViews", member(image, "bufferView"));
    const auto buffer = element("buffers", member(view, "buffer"));
    if (!buffer) return {};
    const std::size_t offset = index(member(view, "byteOffset"), kMax).value_or(0);
    const std::size_t length = index(member(view, "byteLength"), kMax).value_or(0);
    const auto data = data_of(text(member(buffer, "uri")));
    if (!data) return std::string(binary_.substr(std::min(offset, binary_.size()), length));
    // Decodes only the groups of four characters that hold the image.
    const std::size_t begin = offset / 3 * 4, end = (offset + length + 2) / 3 * 4;
    std::string bytes = decode_base64(data->substr(std::min(begin, data->size()), end - begin)).value_or("");
    return bytes.substr(std::min(offset % 3, bytes.size()), length);
}

}  // namespace ccdt::api
