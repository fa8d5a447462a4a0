// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

namespace ccdt::api {

/// Removes the next line from the text of an OBJ. Returns this line without its end. A line ends where it ends for the
/// mesh library: at a line feed, a carriage return, both together, a form feed or a NUL.
inline std::string_view take_obj_line(std::string_view& text) {
    const std::string_view line = text.substr(0, text.find_first_of(std::string_view("\n\r\f\0", 4)));
    text.remove_prefix(line.size());
    const bool is_pair = text.starts_with("\r\n");
    text.remove_prefix(text.empty() ? 0 : is_pair ? 2 : 1);
    return line;
}

}  // namespace ccdt::api
