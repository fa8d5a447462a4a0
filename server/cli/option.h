// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace ccdt::server {

/// An option of a command.
struct Option {
    std::string name;                     ///< without the leading `--`, with hyphens
    std::string member = {};              ///< name in the API; empty for an option of the program itself
    std::string value = {};               ///< name of the value in help texts; empty for a flag
    std::string description = {};         ///< full sentences
    std::string allowed = {};             ///< range of numbers, such as "from 0 to 1"; may be empty
    std::string default_value = {};       ///< may be empty
    std::vector<std::string> words = {};  ///< words that the option accepts, possibly besides other values
    bool takes_number = false;
    bool takes_text = false;  ///< accepts texts other than `words`
    bool takes_json = false;  ///< accepts JSON arrays or objects
    bool in_body = false;     ///< a member of a JSON body that has no form as a query parameter
    char letter = 0;          ///< short form, such as `o` for `-o`; 0: none

    bool is_flag() const { return value.empty(); }

    /// Whether all values are JSON or one of `words`. Such a value may also be `@` and the name of a file.
    bool is_json() const { return takes_json && !takes_number && !takes_text; }
};

/// Returns a text with hyphens instead of underscores.
inline std::string hyphenated(std::string_view text) {
    std::string out(text);
    std::ranges::replace(out, '_', '-');
    return out;
}

}  // namespace ccdt::server
