// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/embedded_image.h"

#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

std::string encode(std::string_view bytes) {
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    std::uint32_t bits = 0;
    unsigned count = 0;
    for (const char byte : bytes) {
        bits = bits << 8 | static_cast<unsigned char>(byte);
        for (count += 8; count >= 6; count -= 6) text += kDigits[bits >> (count - 6) & 63];
    }
    if (count > 0) text += kDigits[bits << (6 - count) & 63];
    return text;
}

}  // namespace
}  // namespace ccdt::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt::fuzz;
    const auto text = text_of(data, size);
    const auto bytes = ccdt::api::decode_base64(text);
    if (bytes) {
        // Apart from blanks and the padding, only one text encodes the same bytes.
        std::string dense(text);
        std::erase_if(dense, [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; });
        const std::string again = encode(*bytes);
        CCDT_CHECK(dense.starts_with(again));
        CCDT_CHECK(dense.find_first_not_of('=', again.size()) == std::string::npos);
        CCDT_CHECK(dense.size() == again.size() || (dense.size() % 4 == 0 && dense.size() < again.size() + 3));
    } else {
        check_error(bytes.error());
    }
    const auto encoded = encode(text);
    CCDT_CHECK(ccdt::api::decode_base64(encoded) == std::string(text));
    return 0;
}
