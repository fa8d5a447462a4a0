// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace ccdt::api {

/// Character encoding of texts, which the C library converts to UTF-8.
class CodePage {
public:
    /// Finds a code page by its name: the text of a .cpg file, such as `UTF-8`, `1252`, `ANSI 1251` or `CP932`, or
    /// `LDID/` followed by the number of the language driver in a .dbf file. ISO 8859-1 is read as Windows-1252, which
    /// has additional characters. Errors: Unusable for an unknown code page; the message says what is missing.
    static Result<CodePage> find(std::string_view name);

    /// Converts a text to UTF-8. Bytes that are not a character of the code page become U+FFFD.
    std::string to_utf8(std::string_view text) const;

private:
    explicit CodePage(void* converter);

    std::shared_ptr<void> converter_;  ///< null: UTF-8
};

/// Loads the tables of all code pages, so that they can be found by a process that cannot open files. They take 2 MB.
void load_code_pages();

/// Returns whether a text is pure ASCII, and thus means the same in every code page.
bool is_ascii(std::string_view text);

}  // namespace ccdt::api
