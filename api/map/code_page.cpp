// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/map/code_page.h"

#include <algorithm>
#include <array>
#include <string>

namespace ccdt::api {
namespace {

struct Named {
    std::string_view name;  ///< capital letters and digits; other characters have been removed
    CodePage page;
};

/// Names that programs write to .cpg files, and numbers of language drivers. The drivers 3 and 87 to 89 are Windows
/// drivers for western languages.
constexpr auto kNames = std::to_array<Named>({
    {"UTF8", CodePage::Utf8},
    {"65001", CodePage::Utf8},
    {"CP65001", CodePage::Utf8},
    {"ISO88591", CodePage::Windows1252},
    {"88591", CodePage::Windows1252},
    {"LATIN1", CodePage::Windows1252},
    {"1252", CodePage::Windows1252},
    {"CP1252", CodePage::Windows1252},
    {"ANSI1252", CodePage::Windows1252},
    {"WINDOWS1252", CodePage::Windows1252},
    {"LDID3", CodePage::Windows1252},
    {"LDID87", CodePage::Windows1252},
    {"LDID88", CodePage::Windows1252},
    {"LDID89", CodePage::Windows1252},
});

/// Code points of the bytes 0x80 to 0x9F.
constexpr std::array<char32_t, 32> kWindows1252 = {0x20AC, 0x81,   0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021,
                                                   0x02C6, 0x2030, 0x0160, 0x2039, 0x0152, 0x8D,   0x017D, 0x8F,
                                                   0x90,   0x2018, 0x2019, 0x201C, 0x201D, 0x2022, 0x2013, 0x2014,
                                                   0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0x9D,   0x017E, 0x0178};

/// @param code  from 0x80 to 0xFFFF
void append_utf8(std::string& out, char32_t code) {
    if (code >= 0x800) {
        out += static_cast<char>(0xE0 | code >> 12);
        out += static_cast<char>(0x80 | (code >> 6 & 0x3F));
    } else {
        out += static_cast<char>(0xC0 | code >> 6);
    }
    out += static_cast<char>(0x80 | (code & 0x3F));
}

}  // namespace

std::optional<CodePage> find_code_page(std::string_view name) {
    std::string plain;
    for (const char c : name) {
        if (c >= 'a' && c <= 'z') plain += static_cast<char>(c - 'a' + 'A');
        if ((c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z')) plain += c;
    }
    const auto found = std::ranges::find(kNames, std::string_view(plain), &Named::name);
    return found == kNames.end() ? std::nullopt : std::optional(found->page);
}

std::string to_utf8(std::string_view text, CodePage page) {
    if (page == CodePage::Utf8 || is_ascii(text)) return std::string(text);
    std::string converted;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x80) {
            converted += c;
        } else {
            append_utf8(converted, byte < 0xA0 ? kWindows1252[byte - 0x80] : byte);
        }
    }
    return converted;
}

bool is_ascii(std::string_view text) {
    return std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

}  // namespace ccdt::api
