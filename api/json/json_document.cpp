// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/json/json_document.h"

#include <algorithm>
#include <bit>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/text/byte_order_mark.h"
#include "api/text/numbers.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

constexpr char kRecordSeparator = '\x1E';  // RFC 8142
constexpr std::string_view kBlanks = " \t\r\n";
constexpr std::string_view kBetweenTexts = " \t\r\n\x1E";

/// Greatest integer up to which doubles hold all integers.
constexpr std::int64_t kMaxExact = std::int64_t{1} << 53;

/// Whether a number is an integer without an exponent. Integers that have more than 64 bits are floats for the library.
bool is_long_integer(std::string_view number) {
    return number.find_first_not_of("-0123456789") == std::string_view::npos;
}

/// @param position  position of the error, counted from 1
/// @param reason    empty if it is unknown
tl::unexpected<Error> invalid_at(std::size_t position, std::string_view reason = {}) {
    return failure(ErrorCode::Malformed, "the body is not valid JSON: error at byte " + std::to_string(position) +
                                             (reason.empty() ? "" : ": ") + std::string(reason));
}

/// Returns the reason of a parser's error, for errors whose position alone does not tell the reason; empty for others.
/// @param rest     text from the error on
/// @param message  message of the parser
std::string_view reason_of(std::string_view rest, std::string_view message) {
    const auto says = [message](std::string_view words) { return message.find(words) != std::string_view::npos; };
    if (says("unexpected end of input")) return "the text ends";
    if (says("ill-formed UTF-8")) return "the text is not in UTF-8";
    if (says("number overflow")) return "the number is too large";
    return rest.starts_with("NaN") || rest.starts_with("Infinity") ? "numbers must be finite" : "";
}

}  // namespace

/// Receives the events of the parser. Stops the parser at the first error or exceeded limit. The library prescribes the
/// names of the functions.
class JsonBuilder {
public:
    using Kind = JsonDocument::Kind;

    bool null() { return add(Kind::Null, 0); }
    bool boolean(bool value) { return add(Kind::Boolean, value ? 1 : 0); }
    bool number_integer(std::int64_t value) {
        return value < -kMaxExact ? add_long_integer(std::to_string(value)) : add_number(static_cast<double>(value));
    }
    bool number_unsigned(std::uint64_t value) {
        return value > kMaxExact ? add_long_integer(std::to_string(value)) : add_number(static_cast<double>(value));
    }
    bool number_float(double value, const std::string& text) {
        return is_long_integer(text) ? add_long_integer(text) : add_number(value);
    }
    bool string(std::string& value) { return add_text(value); }
    bool key(std::string& value) { return add_text(value); }
    bool binary(nlohmann::json::binary_t&) { return fail(ErrorCode::Malformed, "the body is not JSON text"); }

    bool start_array(std::size_t) { return open(Kind::Array); }
    bool start_object(std::size_t) { return open(Kind::Object); }
    bool end_array() { return close(1); }
    bool end_object() { return names_differ() && close(2); }

    bool parse_error(std::size_t position, const std::string&, const nlohmann::json::exception& error) {
        stopped_at_ = start_ + position;
        const std::string_view rest = text_.substr(std::min(stopped_at_ - 1, text_.size()));
        error_ = invalid_at(stopped_at_, reason_of(rest, error.what())).value();
        return false;
    }

    /// Reads the value at a position of a text.
    /// @returns  position of an object or a record separator directly after the value; none at the end of the text and
    ///           after errors
    std::optional<std::size_t> read(std::string_view text, std::size_t start) {
        const std::size_t levels = open_.size(), before = document_.nodes_.size();
        text_ = text;
        start_ = start;
        stopped_at_ = 0;
        nlohmann::json::sax_parse(text.begin() + static_cast<std::ptrdiff_t>(start), text.end(), this);
        const bool is_complete = open_.size() == levels && document_.nodes_.size() > before;
        if (stopped_at_ == 0 || !is_complete) return std::nullopt;
        const std::size_t next = stopped_at_ - 1;
        if (next >= text.size() || (text[next] != '{' && text[next] != kRecordSeparator)) return std::nullopt;
        error_.reset();
        return next;
    }

    /// Reads a sequence of values as the features of a FeatureCollection.
    void read_features(std::string_view text, std::size_t start) {
        std::string type = "type", collection = "FeatureCollection", features = "features";
        start_object(0);
        key(type);
        string(collection);
        key(features);
        start_array(0);
        for (std::optional<std::size_t> at = start; at;) {
            *at = text.find_first_not_of(kBetweenTexts, *at);
            at = *at == std::string_view::npos ? std::nullopt : read(text, *at);
        }
        if (error_) return;
        end_array();
        end_object();
    }

    Result<JsonDocument> take() {
        if (error_) return tl::unexpected<Error>(*std::move(error_));
        return std::move(document_);
    }

private:
    bool add(Kind kind, std::uint64_t payload) {
        auto& nodes = document_.nodes_;
        if (nodes.size() == JsonDocument::kMaxValues) {
            return fail(ErrorCode::LimitExceeded, "the body has more than " + std::to_string(JsonDocument::kMaxValues) +
                                                      " JSON values, the limit");
        }
        nodes.push_back({payload, static_cast<std::uint32_t>(nodes.size() + 1), kind});
        return true;
    }

    bool add_number(double value) { return add(Kind::Number, std::bit_cast<std::uint64_t>(value)); }

    /// Adds an integer that a double may not hold.
    bool add_long_integer(std::string_view digits) {
        const std::size_t at = document_.digits_.size();
        document_.digits_.append(digits) += ' ';
        return add(Kind::LongInteger, at);
    }

    bool add_text(std::string& value) {
        document_.texts_.push_back(std::move(value));
        value.clear();
        return add(Kind::String, document_.texts_.size() - 1);
    }

    bool open(Kind kind) {
        if (open_.size() == JsonDocument::kMaxDepth) {
            return fail(ErrorCode::Malformed,
                        "the body nests deeper than " + std::to_string(JsonDocument::kMaxDepth) + " levels");
        }
        open_.push_back(static_cast<std::uint32_t>(document_.nodes_.size()));
        return add(kind, 0);
    }

    /// @param nodes_per_child  1 for an array; 2 for an object, where a child is a name and a value
    bool close(std::uint64_t nodes_per_child) {
        auto& nodes = document_.nodes_;
        const std::uint32_t start = open_.back();
        open_.pop_back();
        std::uint64_t children = 0;
        for (std::uint32_t i = start + 1; i < nodes.size(); i = nodes[i].end) ++children;
        nodes[start].payload = children / nodes_per_child;
        nodes[start].end = static_cast<std::uint32_t>(nodes.size());
        return true;
    }

    bool names_differ() {
        const auto& nodes = document_.nodes_;
        std::vector<std::string_view> names;
        for (std::uint32_t i = open_.back() + 1; i < nodes.size(); i = nodes[i + 1].end) {
            names.push_back(document_.texts_[nodes[i].payload]);
        }
        std::sort(names.begin(), names.end());
        const auto twin = std::adjacent_find(names.begin(), names.end());
        if (twin == names.end()) return true;
        return fail(ErrorCode::Malformed,
                    "a JSON object has the member '" + std::string(twin->substr(0, 64)) + "' twice");
    }

    bool fail(ErrorCode code, std::string message) {
        error_ = Error{code, std::move(message), {}};
        return false;
    }

    JsonDocument document_;
    std::vector<std::uint32_t> open_;  ///< indices of the arrays and objects that are not closed yet
    std::optional<Error> error_;
    std::string_view text_;       ///< text with the value that is being read
    std::size_t start_ = 0;       ///< position in the text of the value that is being read
    std::size_t stopped_at_ = 0;  ///< position of the first invalid byte, counted from 1; 0: none
};

Result<JsonDocument> JsonDocument::parse(std::string_view text) {
    // The library treats a NUL as the end of the text.
    if (const auto nul = text.find('\0'); nul != std::string_view::npos) return invalid_at(nul + 1);
    JsonBuilder builder;
    if (const auto next = builder.read(text, 0)) return invalid_at(*next + 1);
    return builder.take();
}

Result<JsonDocument> JsonDocument::parse_features(std::string_view text) {
    if (const auto nul = text.find('\0'); nul != std::string_view::npos) return invalid_at(nul + 1);
    const std::size_t start = text.size() - without_byte_order_mark(text).size();
    if (!trim(text.substr(start), kBlanks).starts_with(kRecordSeparator)) {
        JsonBuilder builder;
        if (!builder.read(text, start)) return builder.take();
    }
    JsonBuilder builder;
    builder.read_features(text, start);
    return builder.take();
}

JsonValue JsonDocument::root() const {
    return {this, 0};
}

double JsonValue::number() const {
    if (is_long_integer()) return parse_number<double>(digits()).value_or(0);
    return std::bit_cast<double>(node().payload);
}

std::string_view JsonValue::digits() const {
    const std::string_view all = std::string_view(document_->digits_).substr(size());
    return all.substr(0, all.find(' '));
}

JsonValue::Iterator JsonValue::begin() const {
    return Iterator({document_, index_ + 1});
}

JsonValue::Iterator JsonValue::end() const {
    return Iterator({document_, node().end});
}

std::vector<JsonValue::Member> JsonValue::members() const {
    std::vector<Member> members;
    members.reserve(size());
    for (Iterator i = begin(); i != end(); ++i) {
        const JsonValue name = *i;
        members.push_back({name.text(), *++i});
    }
    return members;
}

std::optional<JsonValue> JsonValue::find(std::string_view name) const {
    for (Iterator i = begin(); i != end(); ++i) {
        const bool found = (*i).text() == name;
        ++i;
        if (found) return *i;
    }
    return std::nullopt;
}

void append_json(std::string& out, JsonValue value) {
    if (value.is_null()) {
        out += "null";
    } else if (value.is_boolean()) {
        out += value.boolean() ? "true" : "false";
    } else if (value.is_long_integer()) {
        out += value.digits();
    } else if (value.is_number()) {
        append_shortest(out, value.number());
    } else if (value.is_string()) {
        append_json_text(out, value.text());
    } else if (value.is_array()) {
        out += '[';
        const char* comma = "";
        for (const JsonValue element : value) {
            out += std::exchange(comma, ",");
            append_json(out, element);
        }
        out += ']';
    } else {
        out += '{';
        const char* comma = "";
        for (const auto& [name, member] : value.members()) {
            out += std::exchange(comma, ",");
            append_json_text(out, name);
            out += ':';
            append_json(out, member);
        }
        out += '}';
    }
}

void append_json_text(std::string& out, std::string_view text) {
    out += nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void append_ascii_json_text(std::string& out, std::string_view text) {
    out += nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

std::string pointer_below(std::string_view pointer, std::string_view member) {
    std::string result(pointer);
    result += '/';
    for (const char c : member) {
        if (c == '~') {
            result += "~0";
        } else if (c == '/') {
            result += "~1";
        } else {
            result += c;
        }
    }
    return result;
}

std::string pointer_below(std::string_view pointer, std::size_t element) {
    return std::string(pointer) + '/' + std::to_string(element);
}

}  // namespace ccdt::api
