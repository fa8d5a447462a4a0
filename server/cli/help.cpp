// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/help.h"

#include <algorithm>

#include "api/text/text.h"
#include "server/flags/manual_page.h"

namespace ccdt::server {
namespace {

constexpr std::size_t kIndent = 8;   ///< indentation of the description of an option
constexpr std::size_t kColumn = 14;  ///< width of the column of commands and exit statuses

constexpr std::string_view kPurpose =
    "Places dots evenly and according to a density, by Capacity-Constrained Delaunay Triangulation: turns pictures "
    "into halftones, spreads points in areas, and measures how evenly points are spread. Answers are the same bytes "
    "as those of ccdt-server, for the same input, options and seed.";

/// Describes the forms of options and their values.
std::string describe_forms(std::span<const Option> options) {
    std::string text =
        "Options may be mixed with inputs, and written as --name=value and with underscores instead of hyphens.";
    if (std::ranges::any_of(options, &Option::is_json))
        text +=
            " A value JSON is JSON text, or @FILE for the JSON in a file. Where an image is accepted, FILE may be a "
            "picture.";
    return text;
}

/// Returns the forms of an option: `-o, --output`.
std::string forms_of(const Option& option) {
    const std::string letter = option.letter == 0 ? "" : std::string{'-', option.letter, ',', ' '};
    return letter + "--" + (option.default_value == "true" && option.is_flag() ? "[no-]" : "") + option.name;
}

std::string title_of(const Command& command) {
    return "ccdt " + std::string(command.name) + ' ' + std::string(command.synopsis);
}

/// Formats a row of a table of two columns.
std::string row(std::string_view name, std::string_view text, std::size_t width) {
    std::string lines = wrapped(text, kColumn, width);
    lines.replace(2, name.size(), name);
    return lines;
}

std::string exit_status_rows(std::size_t width) {
    std::string text;
    for (const auto& [value, meaning] : exit_statuses()) text += row(value, meaning, width);
    return text;
}

void add_exit_statuses(ManualPage& page) {
    page.begin_section("EXIT STATUS");
    for (const auto& [value, meaning] : exit_statuses()) page.add_option(value, {}, meaning);
}

}  // namespace

std::string wrapped(std::string_view text, std::size_t indent, std::size_t width) {
    std::string out, line;
    const auto end_line = [&] {
        out.append(indent, ' ').append(line).append("\n");
        line.clear();
    };
    while (!text.empty()) {
        const auto word = api::take_until(text, " ");
        if (!line.empty() && indent + line.size() + 1 + word.size() > width) end_line();
        if (!line.empty()) line += ' ';
        line += word;
    }
    end_line();
    return out;
}

std::string program_help(std::size_t width) {
    std::string text = "Usage: ccdt COMMAND [ARGUMENT]...\n\n" + wrapped(kPurpose, 0, width) + "\nCommands:\n";
    for (const Command& command : commands()) text += row(command.name, command.summary, width);
    for (const OtherCommand& command : other_commands()) text += row(command.name, command.summary, width);
    text += "\nExamples:\n";
    for (const Command& command : commands()) text.append("  ").append(command.examples.front()).append("\n");
    return text + "\nExit status:\n" + exit_status_rows(width) + '\n' +
           wrapped(
               "ccdt help COMMAND or ccdt COMMAND --help lists the options of a command. ccdt --version prints the "
               "version.",
               0, width);
}

std::string command_help(const Command& command, std::size_t width) {
    const auto options = options_of(command);
    std::string text = "Usage: " + title_of(command) + "\n\n" + wrapped(command.details, 0, width) + '\n' +
                       wrapped(describe_forms(options), 0, width);
    for (const auto& [title, members] : group_options(options)) {
        text.append("\n").append(title).append(":\n");
        for (const Option* option : members) {
            text += "  " + forms_of(*option) + (option->is_flag() ? "" : " " + option->value) + '\n';
            const std::string values = describe_values(*option);
            text +=
                wrapped(std::string(first_sentence(option->description)) + '.' + (values.empty() ? "" : " ") + values,
                        kIndent, width);
        }
    }
    text += "\nExamples:\n";
    for (const std::string_view example : command.examples) text.append("  ").append(example).append("\n");
    return text + "\nccdt manual " + std::string(command.name) + " | man -l - shows all details.\n";
}

std::string program_manual() {
    ManualPage page("ccdt", 1, "turn pictures into dots, spread points evenly, and analyze points");
    page.begin_section("SYNOPSIS");
    for (const Command& command : commands()) page.add_command(title_of(command));
    for (const OtherCommand& command : other_commands()) page.add_command("ccdt " + std::string(command.synopsis));
    page.begin_section("DESCRIPTION");
    page.add_paragraph(kPurpose);
    page.begin_section("COMMANDS");
    for (const Command& command : commands())
        page.add_option(command.name, {},
                        std::string(command.summary) + "; see ccdt-" + std::string(command.name) + "(1)");
    for (const OtherCommand& command : other_commands()) page.add_option(command.name, {}, command.summary);
    page.begin_section("OPTIONS");
    page.add_option("--help", {}, "prints help");
    page.add_option("--version", {}, "prints the version");
    page.begin_section("EXAMPLES");
    for (const Command& command : commands()) page.add_command(command.examples.front());
    add_exit_statuses(page);
    page.begin_section("SEE ALSO");
    std::string others;
    for (const Command& command : commands()) others += "ccdt-" + std::string(command.name) + "(1), ";
    page.add_paragraph(others + "ccdt-server(8)");
    return page.text();
}

std::string command_manual(const Command& command) {
    ManualPage page("ccdt-" + std::string(command.name), 1, command.summary);
    page.begin_section("SYNOPSIS");
    page.add_command(title_of(command));
    page.begin_section("DESCRIPTION");
    page.add_paragraph(command.details);
    const auto options = options_of(command);
    page.add_paragraph(describe_forms(options));
    page.begin_section("OPTIONS");
    for (const auto& [title, members] : group_options(options)) {
        page.begin_subsection(title);
        for (const Option* option : members) {
            const std::string values = describe_values(*option);
            page.add_option(forms_of(*option), option->value,
                            option->description + (values.empty() ? "" : " ") + values);
        }
    }
    page.begin_section("EXAMPLES");
    for (const std::string_view example : command.examples) page.add_command(example);
    add_exit_statuses(page);
    page.begin_section("SEE ALSO");
    page.add_paragraph("ccdt(1), ccdt-server(8)");
    return page.text();
}

}  // namespace ccdt::server
