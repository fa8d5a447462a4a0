// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ccdt::api {

/// Character encoding of texts. ISO 8859-1 is read as Windows-1252, which has additional characters.
enum class CodePage { Utf8, Windows1252 };

/// Finds a code page by its name: the text of a .cpg file, or `LDID/` followed by the number of the language driver in
/// a .dbf file.
/// @returns  none for an unknown code page
std::optional<CodePage> find_code_page(std::string_view name);

/// Converts a text to UTF-8. Bytes without a character in Windows-1252 become control characters, as in browsers.
std::string to_utf8(std::string_view text, CodePage page);

/// Returns whether a text is pure ASCII, and thus means the same in every code page.
bool is_ascii(std::string_view text);

}  // namespace ccdt::api
