// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/access/key_ring.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "api/text/text.h"
#include "server/files/text_file.h"
#include "server/http/http.h"
#include "server/requests/digest.h"

namespace ccdt::server {
namespace {

constexpr std::size_t kMaxKeyLength = 256;
constexpr std::size_t kMaxNameLength = 64;
constexpr std::string_view kBlanks = " \t\r";

/// Compares two keys in constant time. The time reveals neither the first difference nor the length of the real key.
bool is_same(std::string_view real, std::string_view shown) {
    unsigned difference = real.size() == shown.size() ? 0 : 1;
    for (std::size_t i = 0; i < kMaxKeyLength; ++i) {
        const char a = i < real.size() ? real[i] : '\0';
        const char b = i < shown.size() ? shown[i] : '\0';
        difference |= static_cast<unsigned>(static_cast<unsigned char>(a ^ b));
    }
    return difference == 0;
}

bool is_key(std::string_view text, std::size_t shortest) {
    return text.size() >= shortest && text.size() <= kMaxKeyLength &&
           std::ranges::all_of(text, [](char c) { return c > ' ' && c < 0x7f; });
}

std::string wanted_key(std::size_t shortest) {
    return "a key must have " + std::to_string(shortest) + " to " + std::to_string(kMaxKeyLength) +
           " visible characters";
}

tl::unexpected<Error> wrong_line(std::size_t number, const std::string& why) {
    return failure(ErrorCode::Malformed, "line " + std::to_string(number) + ": " + why);
}

}  // namespace

Result<KeyRing> KeyRing::parse(std::string_view text, std::size_t shortest) {
    KeyRing ring;
    for (std::size_t number = 1; !text.empty(); ++number) {
        const auto line = api::trim(api::take_until(text, "\n"), kBlanks);
        if (line.empty() || line.starts_with('#')) continue;
        const auto separator = std::min(line.find_first_of(": \t"), line.size());
        const auto name = line.substr(0, separator);
        const auto key = api::trim(line.substr(std::min(separator + 1, line.size())), kBlanks);
        if (!api::is_plain_name(name, kMaxNameLength))
            return wrong_line(number, "a name must have 1 to 64 letters, digits, dots or dashes");
        if (!is_key(key, shortest)) return wrong_line(number, wanted_key(shortest));
        if (ring.find(key).value_or(std::string(name)) != name)
            return wrong_line(number, "this key already has another name");
        ring.entries_.push_back({std::string(name), std::string(key)});
    }
    if (ring.entries_.empty()) return failure(ErrorCode::Malformed, "there are no keys");
    return ring;
}

Result<KeyRing> KeyRing::read(const std::string& file, std::size_t shortest) {
    const auto text = read_text_file(file);
    if (!text) return tl::unexpected(text.error());
    return parse(*text, shortest).map_error([&](Error error) {
        error.message.insert(0, file + ": ");
        return error;
    });
}

Result<KeyRing> KeyRing::of(std::string name, std::string key, std::size_t shortest) {
    if (!is_key(key, shortest)) return failure(ErrorCode::Malformed, wanted_key(shortest));
    KeyRing ring;
    ring.entries_.push_back({std::move(name), std::move(key)});
    return ring;
}

std::optional<std::string> KeyRing::find(std::string_view key) const {
    return find_if([key](std::string_view real) { return is_same(real, key); });
}

std::optional<std::string> KeyRing::find_signer(std::string_view text, std::string_view signature) const {
    return find_if([=](std::string_view key) { return is_same(sign(key, text), signature); });
}

std::vector<std::string> KeyRing::keys() const {
    std::vector<std::string> keys;
    for (const Entry& entry : entries_) keys.push_back(entry.key);
    return keys;
}

std::optional<std::string> KeyRing::find_if(const std::function<bool(std::string_view key)>& fits) const {
    const Entry* found = nullptr;
    for (const Entry& entry : entries_) {
        if (fits(entry.key)) found = &entry;
    }
    return found == nullptr ? std::nullopt : std::optional(found->name);
}

std::string_view bearer_key(std::string_view authorization) {
    constexpr std::string_view kScheme = "Bearer ";
    if (!equals_ignoring_case(authorization.substr(0, kScheme.size()), kScheme)) return {};
    return api::trim(authorization.substr(kScheme.size()), kBlanks);
}

}  // namespace ccdt::server
