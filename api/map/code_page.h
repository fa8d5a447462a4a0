// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ccdt::api {

/// Character encoding of texts. ISO 8859-1 counts as Windows-1252, which adds characters to it.
enum class CodePage { Utf8, Windows1252 };

/// Finds a code page by the text of a .cpg file, or by `LDID/` and the number of a .dbf file's language driver.
/// @returns  none for one that is not known
std::optional<CodePage> find_code_page(std::string_view name);

/// Converts a text to UTF-8. Each byte of Windows-1252 is a character: those without one are control characters, as
/// browsers have it.
std::string to_utf8(std::string_view text, CodePage page);

/// Tells whether a text is the same in every code page.
bool is_ascii(std::string_view text);

}  // namespace ccdt::api
