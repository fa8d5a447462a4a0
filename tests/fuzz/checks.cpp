// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/checks.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "api/json/json_document.h"
#include "api/problem.h"

namespace ccdt::fuzz {
namespace {

constexpr std::size_t kMaxFieldLength = 64;  ///< maximum length of an error's field that is never truncated

std::string unescape(std::string_view token) {
    std::string name;
    for (std::size_t i = 0; i < token.size(); ++i) {
        const bool escape = token[i] == '~' && i + 1 < token.size();
        name += !escape ? token[i] : token[++i] == '0' ? '~' : '/';
    }
    return name;
}

std::optional<api::JsonValue> child(api::JsonValue parent, std::string_view token) {
    if (parent.is_object()) return parent.find(unescape(token));
    if (!parent.is_array()) return std::nullopt;
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), index);
    if (error != std::errc() || end != token.data() + token.size() || index >= parent.size()) return std::nullopt;
    auto element = parent.begin();
    for (std::size_t i = 0; i < index; ++i) ++element;
    return *element;
}

/// Whether a JSON Pointer refers to a value or to a missing member of an object.
bool leads_somewhere(std::string_view body, std::string_view pointer) {
    const auto document = api::JsonDocument::parse_features(body);
    if (!document) return pointer.empty();
    std::optional<api::JsonValue> value = document->root();
    while (!pointer.empty() && value) {
        if (pointer.front() != '/') return false;
        pointer.remove_prefix(1);
        const auto token = pointer.substr(0, pointer.find('/'));
        pointer.remove_prefix(token.size());
        const bool may_miss_it = pointer.empty() && value->is_object();
        value = child(*value, token);
        if (!value && may_miss_it) return true;
    }
    return value.has_value();
}

}  // namespace

void give_up(const char* condition, const char* file, int line) {
    std::fprintf(stderr, "%s:%d: does not hold: %s\n", file, line, condition);
    std::abort();
}

std::string_view take_line(std::string_view& text) {
    const auto line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    return line;
}

void check_error(const Error& error) {
    CCDT_CHECK(!error.message.empty());
    CCDT_CHECK(error.code != ErrorCode::Internal && error.code != ErrorCode::Stopped);
    check_json(api::problem_json(400, "Bad Request", error, "urn:request:1"));
}

void check_error(const Error& error, std::string_view body) {
    check_error(error);
    CCDT_CHECK(error.field.size() > kMaxFieldLength || leads_somewhere(body, error.field));
}

void check_error(const Error& error, std::span<const api::TextOption> options) {
    check_error(error);
    const auto is_field = [&](const api::TextOption& option) { return option.name == error.field; };
    const bool is_missing =
        error.message.starts_with(error.field) && error.message.find("missing") != std::string::npos;
    CCDT_CHECK(error.field.empty() || error.field.size() > kMaxFieldLength || is_missing ||
               std::ranges::any_of(options, is_field));
}

void check_problem(const server::Problem& problem) {
    CCDT_CHECK(!problem.error.message.empty());
    CCDT_CHECK(problem.status >= 400 && problem.status < 500);
    CCDT_CHECK(server::status_phrase(problem.status) != "Error");
    check_json(api::problem_json(problem.status, "Bad Request", problem.error, {}));
}

void check_json(std::string_view text) {
    CCDT_CHECK(api::JsonDocument::parse(text).has_value());
}

}  // namespace ccdt::fuzz
