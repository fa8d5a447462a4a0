// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/json/json_document.h"
#include "api/surface/bytes.h"
#include "api/surface/surface_format.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Elements of an accessor of a glTF, as numbers.
class GltfAccessor {
public:
    std::size_t count() const { return count_; }
    std::size_t components() const { return components_; }

    /// Whether all components are whole numbers, as indices must be.
    bool is_whole() const { return type_ != kFloat && !is_normalised_; }

    /// Returns a component of an element. Normalised integers are converted.
    double at(std::size_t element, std::size_t component) const;

private:
    friend class GltfDocument;

    /// Types of components, constants of OpenGL.
    enum Type : std::uint32_t {
        kByte = 5120,
        kUnsignedByte = 5121,
        kShort = 5122,
        kUnsignedShort = 5123,
        kUnsignedInt = 5125,
        kFloat = 5126,
    };

    /// Returns the size of a component in bytes; 0 for unknown types.
    std::size_t component_size() const;

    std::string own_;         ///< elements with replacements, or zeros; empty if they are in the buffer
    std::string_view bytes_;  ///< in the buffer
    std::size_t stride_ = 0;  ///< bytes
    std::size_t count_ = 0;
    std::size_t components_ = 0;
    std::uint32_t type_ = 0;  ///< constant of OpenGL
    bool is_normalised_ = false;
};

inline std::size_t GltfAccessor::component_size() const {
    if (type_ == kByte || type_ == kUnsignedByte) return 1;
    if (type_ == kShort || type_ == kUnsignedShort) return 2;
    return type_ == kUnsignedInt || type_ == kFloat ? 4 : 0;
}

inline double GltfAccessor::at(std::size_t element, std::size_t component) const {
    const char* const from =
        (own_.empty() ? bytes_.data() : own_.data()) + element * stride_ + component * component_size();
    const auto normalised = [this](double value, double largest) {
        return is_normalised_ ? std::max(value / largest, -1.0) : value;
    };
    switch (type_) {
        case kByte:
            return normalised(number_at<std::int8_t>(from), 127);
        case kUnsignedByte:
            return normalised(number_at<std::uint8_t>(from), 255);
        case kShort:
            return normalised(number_at<std::int16_t>(from), 32767);
        case kUnsignedShort:
            return normalised(number_at<std::uint16_t>(from), 65535);
        case kUnsignedInt:
            return number_at<std::uint32_t>(from);
        default:
            return double{number_at<float>(from)};
    }
}

/// The JSON and the buffers of a glTF 2.0. Access to its members is safe for any JSON.
class GltfDocument {
public:
    using Value = std::optional<JsonValue>;

    /// Reads the container and its JSON. Errors: Unusable for a damaged container, for data in other files, and for
    /// versions and extensions that are not supported.
    /// @param bytes  must outlive the document
    /// Source: glTF 2.0 (ISO/IEC 12113).
    static Result<GltfDocument> parse(std::string_view bytes, SurfaceFormat format);

    JsonValue root() const { return document_->root(); }
    std::size_t trailing_bytes() const { return trailing_bytes_; }
    /// Returns the memory that parsing the JSON takes at most, in bytes.
    std::uint64_t memory() const;

    /// Returns a member of an object; none if there is none.
    static Value member(Value object, std::string_view name);
    static Value member(Value object, std::string_view name, std::string_view below);
    /// Lists the elements of an array; empty for other values.
    static std::vector<JsonValue> list(Value array);
    /// Reads an integer from 0 to below a limit.
    static std::optional<std::size_t> index(Value value, std::size_t limit);
    static double number(Value value, double missing);
    /// Reads an array of numbers; none if it is missing or has another size.
    static std::vector<double> numbers(Value array, std::size_t size);
    static std::string_view text(Value value);

    /// Returns an array of the document, such as "nodes".
    const std::vector<JsonValue>& array(std::string_view name) const;
    /// Returns the element of an array to which a value refers by its index; none if it is invalid.
    Value element(std::string_view array, Value index) const;

    /// Reads an accessor.
    /// @param count  required number of elements; none: as many as its limit in count()
    /// Errors: Unusable if it exceeds its buffer, has another number of elements, or is damaged.
    Result<GltfAccessor> accessor(Value index, std::optional<std::size_t> count, std::size_t components) const;

    /// Returns the number of elements of an accessor, below 2^32; none if it is invalid.
    std::optional<std::size_t> count(Value index) const;

    /// Lists the required extensions that may change the geometry, but are not supported.
    std::vector<std::string_view> unknown_extensions() const;

    /// Returns the bytes of an image; empty if they are not in the file.
    std::string bytes_of_image(JsonValue image) const;

    tl::unexpected<Error> wrong(const std::string& reason) const { return unusable_surface(format_, reason); }

private:
    /// An array of the document, whose elements have random access.
    struct Array {
        std::string_view name;
        std::vector<JsonValue> values;
    };

    Result<void> check() const;
    Result<std::string_view> view(Value index) const;
    Result<std::string_view> buffer(std::size_t index) const;
    Result<void> replace_elements(JsonValue sparse, GltfAccessor& accessor) const;

    SurfaceFormat format_ = SurfaceFormat::Gltf;
    std::unique_ptr<const JsonDocument> document_;  ///< its values refer to it, so it must not move
    std::string_view binary_;                       ///< content of the first buffer of a GLB
    std::size_t trailing_bytes_ = 0;
    std::vector<Array> arrays_;
    std::vector<std::optional<std::size_t>> counts_;           ///< [accessors]
    mutable std::vector<std::optional<std::string>> buffers_;  ///< [buffers] decoded data URIs, once they are used
};

}  // namespace ccdt::api
