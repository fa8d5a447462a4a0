// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/input/file_formats.h"
#include "server/cli/option.h"

namespace ccdt::server {

/// A command that computes answers: a row of the table in command.cpp.
struct Command {
    std::string_view name;      ///< such as `halftone`
    std::string_view summary;   ///< purpose in a few words, as an imperative
    std::string_view synopsis;  ///< arguments, for help texts
    std::string_view details;   ///< a paragraph about the input
    std::span<const std::string_view> examples;
    std::span<const std::string_view> schemas;  ///< schemas of the options in openapi.json
    /// Formats of answers, in the order of preference.
    std::vector<const api::FileFormat*> (*formats)();
};

/// Returns all commands that compute answers.
std::span<const Command> commands();

/// Finds a command by name; null if there is none.
const Command* find_command(std::string_view name);

/// A command that computes no answers: a row of another table in command.cpp.
struct OtherCommand {
    std::string_view name;
    std::string_view synopsis;
    std::string_view summary;
};

/// Returns all commands that compute no answers.
std::span<const OtherCommand> other_commands();

/// Returns the options of a command: those of the API, then those of the program.
std::vector<Option> options_of(const Command& command);

/// A heading of help texts, and the options below it.
struct OptionGroup {
    std::string_view title;
    std::vector<const Option*> options;
};

/// Groups options by subject. Every option is in exactly one group. No group is empty.
std::vector<OptionGroup> group_options(std::span<const Option> options);

/// Returns the first sentence of a text, without the full stop.
std::string_view first_sentence(std::string_view text);

/// Describes the values of an option: "From 0 to 1." or "One of png, json.", and the default. May be empty.
std::string describe_values(const Option& option);

/// An exit status of the program, and its meaning.
struct ExitStatus {
    std::string_view value;
    std::string_view meaning;
};

/// Returns all exit statuses, for help texts.
std::span<const ExitStatus> exit_statuses();

}  // namespace ccdt::server
