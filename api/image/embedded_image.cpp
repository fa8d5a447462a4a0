// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/embedded_image.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "api/image/image_header.h"

namespace ccdt::api {
namespace {

constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::string_view kBlanks = " \t\r\n";
constexpr std::uint8_t kNoDigit = 64, kBlank = 65;

constexpr auto kDigits = [] {
    std::array<std::uint8_t, 256> digits{};
    digits.fill(kNoDigit);
    for (std::uint8_t i = 0; i < 64; ++i) digits[static_cast<unsigned char>(kAlphabet[i])] = i;
    for (const char blank : kBlanks) digits[static_cast<unsigned char>(blank)] = kBlank;
    return digits;
}();

std::string_view without_blanks_at_the_end(std::string_view text) {
    return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

/// Removes the padding, if the text has a whole number of groups of four digits. Blanks do not count.
std::string_view without_padding(std::string_view text) {
    const auto blanks =
        std::ranges::count_if(text, [](char c) { return kDigits[static_cast<unsigned char>(c)] == kBlank; });
    if ((text.size() - static_cast<std::size_t>(blanks)) % 4 != 0) return text;
    text = without_blanks_at_the_end(text);
    for (int i = 0; i < 2 && text.ends_with('='); ++i)
        text = without_blanks_at_the_end(text.substr(0, text.size() - 1));
    return text;
}

tl::unexpected<Error> not_base64(const std::string& why) {
    return failure(ErrorCode::Malformed, "is not base64: " + why);
}

}  // namespace

Result<std::string> decode_base64(std::string_view text) {
    text = without_padding(text);
    std::string bytes;
    bytes.reserve(text.size() / 4 * 3 + 2);
    std::uint32_t bits = 0;
    int count = 0;  // number of the lowest bits of `bits` that are not output yet
    for (std::size_t i = 0; i < text.size(); ++i) {
        const std::uint8_t digit = kDigits[static_cast<unsigned char>(text[i])];
        if (digit == kBlank) continue;
        if (digit == kNoDigit) return not_base64("character " + std::to_string(i + 1) + " is not a base64 digit");
        bits = (bits << 6 | digit) & 0xFFFF;
        count += 6;
        if (count >= 8) {
            count -= 8;
            bytes += static_cast<char>(bits >> count & 0xFF);
        }
    }
    if (count == 6) return not_base64("its length is impossible");
    if ((bits & ((1U << count) - 1)) != 0) return not_base64("its last digit has unused bits that are not 0");
    return bytes;
}

Result<ImageFile> read_embedded_image(const Input& input, const Limits& limits) {
    auto text = read_text(input);
    if (!text) return tl::unexpected(text.error());
    if (text->starts_with("data:")) {
        const auto comma = text->find(',');
        if (comma == std::string_view::npos || !text->substr(0, comma).ends_with(";base64")) {
            return malformed(input, "is not a data: URI in base64");
        }
        text->remove_prefix(comma + 1);
    }
    auto bytes = decode_base64(*text);
    if (!bytes) return malformed(input, bytes.error().message);
    const auto header = read_image_header(*bytes, limits.max_pixels);
    if (!header) return failure(header.error().code, input.name + ": " + header.error().message, input.field);
    const auto decoded = std::make_shared<const std::string>(*std::move(bytes));
    return ImageFile{*decoded, *header, decoded};
}

}  // namespace ccdt::api
