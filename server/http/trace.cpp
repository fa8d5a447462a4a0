// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/trace.h"

#include <algorithm>
#include <cstddef>

namespace ccdt::server {
namespace {

constexpr std::size_t kSize = 55;  ///< 00-<32 digits>-<16 digits>-00

bool is_hexadecimal(std::string_view text) {
    return std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

bool is_identifier(std::string_view text) {
    return is_hexadecimal(text) && text.find_first_not_of('0') != std::string_view::npos;
}

}  // namespace

std::optional<Trace> parse_traceparent(std::string_view header) {
    if (header.size() < kSize || header[2] != '-' || header[35] != '-' || header[52] != '-') return std::nullopt;
    const auto version = header.substr(0, 2);
    const bool is_first = version == "00";
    if (!is_hexadecimal(version) || version == "ff" || (is_first && header.size() != kSize)) return std::nullopt;
    if (header.size() > kSize && header[kSize] != '-') return std::nullopt;
    const Trace trace{header.substr(3, 32), header.substr(36, 16)};
    if (!is_identifier(trace.id) || !is_identifier(trace.parent) || !is_hexadecimal(header.substr(53, 2)))
        return std::nullopt;
    return trace;
}

std::string_view whole_traceparent(std::string_view header) {
    return parse_traceparent(header) ? header.substr(0, kSize) : "";
}

}  // namespace ccdt::server
