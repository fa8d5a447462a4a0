// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace ccdt::api {

/// Splits CSV (RFC 4180) into records of fields. Lines may end with or without a carriage return.
class CsvReader {
public:
    /// @param separator  between fields. If it is a tab, quotes have no meaning, as in text/tab-separated-values
    explicit CsvReader(std::string_view text, char separator = ',') : text_(text), rest_(text), separator_(separator) {}

    /// Returns the separator of a text: the one of comma, semicolon and tab that is most frequent in the first line.
    static char find_separator(std::string_view text);

    /// Reads the next record, which may contain line breaks in quoted fields. Returns false at the end of the text.
    /// Errors: Malformed, with the line in the message.
    Result<bool> next();

    const std::vector<std::string>& fields() const { return fields_; }

    /// Returns the beginning of messages about the current record.
    std::string position() const { return "line " + std::to_string(line_); }

    /// Returns the position in the text of the next record.
    std::size_t offset() const { return text_.size() - rest_.size(); }

private:
    Result<void> read_field();

    std::string_view text_, rest_;
    char separator_;
    std::vector<std::string> fields_;
    std::size_t line_ = 0;
    std::size_t next_line_ = 1;
};

}  // namespace ccdt::api
