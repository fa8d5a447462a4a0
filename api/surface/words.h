// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace ccdt::api {

/// The words of a text mesh file. Blanks and control characters separate words. A line ends at a line feed, a carriage
/// return, both together, a form feed or a NUL. A comment begins at `#` and ends with its line.
class Words {
public:
    explicit Words(std::string_view text, std::size_t line = 1)
        : at_(text.data()), end_(text.data() + text.size()), line_(line) {}

    /// Returns the next word of the text; an empty text at the end.
    std::string_view next();

    /// Returns the next word of the same line; an empty text at the end of the line. A backslash at the end of a line
    /// continues the line.
    std::string_view next_in_line();

    /// Ignores the rest of the line, whose last backslash does not continue it.
    void skip_line();

    bool at_end() const { return at_ == end_; }

    /// Returns the number of bytes after the last word.
    std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }

    /// Returns the number of the line of the last word, counted from 1.
    std::size_t line() const { return line_; }

    /// Returns the position of the last word for an error message, such as "line 7: ".
    std::string position() const { return "line " + std::to_string(line_) + ": "; }

private:
    void take_line_end();

    const char* at_;
    const char* end_;
    std::size_t line_;
};

/// Returns the start of a word from a file, for messages.
std::string quoted(std::string_view word);

/// Parses a number of a mesh file. Returns NaN or an infinity for the words that printf() writes for them, also in
/// Microsoft's libraries; none for a word that is not a number.
std::optional<double> number_in(std::string_view word);

/// Compares a word with a keyword in lower case, without regard to the case of its letters.
bool is_keyword(std::string_view word, std::string_view keyword);

}  // namespace ccdt::api
