// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/json/json_document.h"

#include <set>

#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

using api::JsonDocument;
using api::JsonValue;

/// Compares two values recursively, and counts the visited ones.
bool equal(JsonValue a, JsonValue b, std::size_t depth, std::size_t& values) {
    CCDT_CHECK(depth <= JsonDocument::kMaxDepth);
    CCDT_CHECK(++values <= JsonDocument::kMaxValues);
    if (a.is_boolean()) return b.is_boolean() && a.boolean() == b.boolean();
    if (a.is_number()) return b.is_number() && a.number() == b.number();
    if (a.is_string()) return b.is_string() && a.text() == b.text();
    if (a.is_array()) {
        if (!b.is_array() || a.size() != b.size()) return false;
        std::size_t met = 0;
        auto other = b.begin();
        for (const JsonValue element : a) {
            if (!equal(element, *other, depth + 1, values)) return false;
            ++other;
            ++met;
        }
        return met == a.size();
    }
    if (a.is_object()) {
        if (!b.is_object()) return false;
        std::set<std::string_view> names;
        for (const auto& [name, value] : a.members()) {
            const auto other = b.find(name);
            if (!other || !names.insert(name).second || !equal(value, *other, depth + 1, values)) return false;
        }
        return names.size() == a.size() && a.size() == b.size();
    }
    return true;  // null
}

/// Checks that a sequence of texts is read as a collection, and any other text like JSON.
void check_features(std::string_view text, const Result<JsonDocument>& document) {
    const auto features = JsonDocument::parse_features(text);
    std::size_t values = 0;
    if (document) CCDT_CHECK(features && equal(document->root(), features->root(), 0, values));
    if (document || !features) return;
    std::string written;
    api::append_json(written, features->root());
    check_json(written);
    CCDT_CHECK(text.starts_with('\xef') || written.starts_with(R"({"type":"FeatureCollection","features":[)"));
}

/// Checks that white space around a document changes nothing. A byte order mark must stay first.
void check_padded(std::string_view text, const JsonDocument& document) {
    std::string padded = text.starts_with('\xef') ? "" : " \r\n\t";
    padded.append(text).append("\n");
    const auto again = JsonDocument::parse(padded);
    std::size_t values = 0;
    CCDT_CHECK(again && equal(document.root(), again->root(), 0, values));
}

}  // namespace
}  // namespace ccdt::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt::fuzz;
    const auto text = text_of(data, size);
    const auto document = ccdt::api::JsonDocument::parse(text);
    check_features(text, document);
    if (document) {
        check_padded(text, *document);
    } else {
        check_error(document.error());
    }
    return 0;
}
