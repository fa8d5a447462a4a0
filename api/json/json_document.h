// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace ccdt::api {

class JsonValue;

/// Parsed JSON text, as a flat list of values in the order of the text. A value takes 16 bytes, in addition to its
/// text. Copying and destroying a document do not recurse, even if the text is deeply nested.
class JsonDocument {
public:
    static constexpr std::size_t kMaxDepth = 32;
    static constexpr std::size_t kMaxValues = std::size_t{1} << 23;  ///< member names count as values

    /// Parses a text. Errors: Malformed for invalid JSON (RFC 8259, UTF-8), for nesting deeper than kMaxDepth, and for
    /// an object with two members of the same name; LimitExceeded for more than kMaxValues values.
    static Result<JsonDocument> parse(std::string_view text);

    /// Parses GeoJSON, after a byte order mark of UTF-8 if there is one. A sequence of objects becomes the features of
    /// a FeatureCollection: objects that each begin after a record separator (RFC 8142), or objects one after the
    /// other, as in newline-delimited GeoJSON. Blanks and empty lines between them are ignored. Errors: those of
    /// parse().
    static Result<JsonDocument> parse_features(std::string_view text);

    /// Returns the value of the whole text. The document must outlive the value and must not move.
    JsonValue root() const;

private:
    friend class JsonValue;
    friend class JsonBuilder;

    enum class Kind : std::uint8_t { Null, Boolean, Number, LongInteger, String, Array, Object };

    struct Node {
        /// Bits of a double, a boolean, an index into texts_, a position in digits_, or the number of elements.
        std::uint64_t payload = 0;
        std::uint32_t end = 0;  ///< index of the first node after this one and its descendants
        Kind kind = Kind::Null;
    };

    std::vector<Node> nodes_;
    std::vector<std::string> texts_;
    std::string digits_;  ///< all long integers, each with a blank after it
};

/// A value in a JsonDocument. Small; pass it by value. boolean(), number(), digits(), text() and the accessors of
/// arrays and objects require a value of their type.
class JsonValue {
public:
    class Iterator;
    struct Member;

    bool is_null() const { return node().kind == JsonDocument::Kind::Null; }
    bool is_boolean() const { return node().kind == JsonDocument::Kind::Boolean; }
    bool is_number() const { return node().kind == JsonDocument::Kind::Number || is_long_integer(); }
    /// Whether the value is an integer above 2^53 in magnitude. number() may round it; digits() does not.
    bool is_long_integer() const { return node().kind == JsonDocument::Kind::LongInteger; }
    bool is_string() const { return node().kind == JsonDocument::Kind::String; }
    bool is_array() const { return node().kind == JsonDocument::Kind::Array; }
    bool is_object() const { return node().kind == JsonDocument::Kind::Object; }

    bool boolean() const { return node().payload != 0; }
    double number() const;
    std::string_view digits() const;
    const std::string& text() const { return document_->texts_[node().payload]; }

    /// Returns the number of elements of an array, or of members of an object.
    std::size_t size() const { return static_cast<std::size_t>(node().payload); }

    /// Iterates over the elements of an array.
    Iterator begin() const;
    Iterator end() const;

    /// Lists the members of an object, in the order of the text.
    std::vector<Member> members() const;

    /// Finds a member of an object by name.
    std::optional<JsonValue> find(std::string_view name) const;

private:
    friend class JsonDocument;

    JsonValue(const JsonDocument* document, std::uint32_t index) : document_(document), index_(index) {}
    const JsonDocument::Node& node() const { return document_->nodes_[index_]; }

    const JsonDocument* document_;
    std::uint32_t index_;
};

class JsonValue::Iterator {
public:
    JsonValue operator*() const { return value_; }
    Iterator& operator++() {
        value_.index_ = value_.node().end;
        return *this;
    }
    bool operator==(const Iterator& other) const { return value_.index_ == other.value_.index_; }

private:
    friend class JsonValue;

    explicit Iterator(JsonValue value) : value_(value) {}

    JsonValue value_;
};

struct JsonValue::Member {
    std::string_view name;
    JsonValue value;
};

/// Appends a value as JSON text. Integers keep all their digits. Other numbers have the fewest digits that read back to
/// the same double.
void append_json(std::string& out, JsonValue value);

/// Appends a text as a JSON string. Replaces bytes that are not UTF-8.
void append_json_text(std::string& out, std::string_view text);

/// Appends a text as a JSON string of printable ASCII characters only, for use in HTTP headers.
void append_ascii_json_text(std::string& out, std::string_view text);

/// Returns the JSON Pointer (RFC 6901) to a member or an element of the value at `pointer`.
std::string pointer_below(std::string_view pointer, std::string_view member);
std::string pointer_below(std::string_view pointer, std::size_t element);

}  // namespace ccdt::api
