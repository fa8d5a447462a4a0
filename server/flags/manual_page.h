// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace ccdt::server {

/// Writes a manual page for man(1), in the macros of man(7). All texts are plain; special characters are escaped.
class ManualPage {
public:
    /// @param name     name of the page, such as `ccdt-halftone`
    /// @param section  section of the manual: 1 for commands, 8 for servers
    /// @param summary  purpose in a few words, without a full stop
    ManualPage(std::string_view name, int section, std::string_view summary);

    void begin_section(std::string_view title);
    void begin_subsection(std::string_view title);
    void add_paragraph(std::string_view text);

    /// Adds a line that shows a command, not wrapped.
    void add_command(std::string_view line);

    /// Adds an entry of a list: an option and its value, then their description.
    /// @param value  name of the value; may be empty
    void add_option(std::string_view option, std::string_view value, std::string_view description);

    const std::string& text() const { return text_; }

private:
    void add_line(std::string_view text);
    void begin_paragraph();

    std::string text_;
    bool after_heading_ = false;  ///< whether the next paragraph begins by itself
};

}  // namespace ccdt::server
