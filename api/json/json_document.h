#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace ccdt::api {

class JsonValue;

/// JSON text that was read: a flat list of values in the order they stand in the text: it costs 16 bytes a value, and
/// neither copying nor destroying it recurses, however deep the text nests.
class JsonDocument {
public:
    static constexpr std::size_t kMaxDepth = 32;
    static constexpr std::size_t kMaxValues = std::size_t{1} << 23;  ///< member names count as values

    /// Parses a text. Errors: Malformed for what is not JSON (RFC 8259, UTF-8), deeper than kMaxDepth, or an object
    /// with two members of one name; LimitExceeded for more than kMaxValues.
    static Result<JsonDocument> parse(std::string_view text);

    /// Gives the whole text's value; the document must outlive it and stay where it is.
    JsonValue root() const;

private:
    friend class JsonValue;
    friend class JsonBuilder;

    enum class Kind : std::uint8_t { Null, Boolean, Number, String, Array, Object };

    struct Node {
        std::uint64_t payload = 0;  ///< a double's bits, a boolean, an index into texts_, a count of elements
        std::uint32_t end = 0;      ///< index of the node after this one and all that it holds
        Kind kind = Kind::Null;
    };

    std::vector<Node> nodes_;
    std::vector<std::string> texts_;
};

/// Value inside a JsonDocument. Small; pass it by value. What is asked must fit the kind.
class JsonValue {
public:
    class Iterator;
    struct Member;

    bool is_null() const { return node().kind == JsonDocument::Kind::Null; }
    bool is_boolean() const { return node().kind == JsonDocument::Kind::Boolean; }
    bool is_number() const { return node().kind == JsonDocument::Kind::Number; }
    bool is_string() const { return node().kind == JsonDocument::Kind::String; }
    bool is_array() const { return node().kind == JsonDocument::Kind::Array; }
    bool is_object() const { return node().kind == JsonDocument::Kind::Object; }

    bool boolean() const { return node().payload != 0; }
    double number() const;
    const std::string& text() const { return document_->texts_[node().payload]; }

    /// Counts the elements of an array, or the members of an object.
    std::size_t size() const { return static_cast<std::size_t>(node().payload); }

    /// Iterates over the elements of an array.
    Iterator begin() const;
    Iterator end() const;

    /// Lists the members of an object, in the order of the text.
    std::vector<Member> members() const;

    /// Finds a member of an object by its name.
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

/// Appends a value as JSON text; numbers are the shortest that read back to the same double.
void append_json(std::string& out, JsonValue value);

/// Appends a text as a JSON string; bytes that are not UTF-8 are replaced.
void append_json_text(std::string& out, std::string_view text);

/// Makes a JSON Pointer (RFC 6901) one step below another.
std::string pointer_below(std::string_view pointer, std::string_view member);
std::string pointer_below(std::string_view pointer, std::size_t element);

}  // namespace ccdt::api
