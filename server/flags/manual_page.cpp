// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/flags/manual_page.h"

#include <utility>

namespace ccdt::server {
namespace {

/// Escapes a text for roff. Hyphens become minus signs, because readers copy options from the page.
std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '\\':
                out += "\\e";
                break;
            case '-':
                out += "\\-";
                break;
            case '\n':
                out += ' ';
                break;
            default:
                out += c;
        }
    }
    // A line that begins with one of these characters would be a request to roff.
    if (out.starts_with('.') || out.starts_with('\'')) out.insert(0, "\\&");
    return out;
}

/// Encloses a text in quotes, as an argument of a macro.
std::string argument(std::string_view text) {
    std::string out = "\"";
    for (const char c : escaped(text)) out += c == '"' ? std::string("\\(dq") : std::string(1, c);
    return out + '"';
}

}  // namespace

ManualPage::ManualPage(std::string_view name, int section, std::string_view summary) {
    // The date stays empty, so that builds are reproducible.
    text_ = ".TH " + argument(name) + ' ' + std::to_string(section) + " \"\" \"ccdt " CCDT_VERSION "\" \"ccdt\"\n";
    begin_section("NAME");
    add_line(std::string(name) + " - " + std::string(summary));
}

void ManualPage::add_line(std::string_view text) {
    text_ += escaped(text) + '\n';
}

void ManualPage::begin_section(std::string_view title) {
    text_ += ".SH " + argument(title) + '\n';
    after_heading_ = true;
}

void ManualPage::begin_subsection(std::string_view title) {
    text_ += ".SS " + argument(title) + '\n';
    after_heading_ = true;
}

void ManualPage::begin_paragraph() {
    if (!std::exchange(after_heading_, false)) text_ += ".PP\n";
}

void ManualPage::add_paragraph(std::string_view text) {
    begin_paragraph();
    add_line(text);
}

void ManualPage::add_command(std::string_view line) {
    begin_paragraph();
    text_ += ".nf\n";
    add_line(line);
    text_ += ".fi\n";
}

void ManualPage::add_option(std::string_view option, std::string_view value, std::string_view description) {
    after_heading_ = false;
    text_ += ".TP\n";
    if (value.empty())
        text_ += ".B " + argument(option) + '\n';
    else
        text_ += ".BI " + argument(option) + " \" \" " + argument(value) + '\n';
    add_line(description);
}

}  // namespace ccdt::server
