// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>

#include "server/cli/command.h"

namespace ccdt::server {

/// Returns the help of the whole program.
/// @param width  maximum length of lines
std::string program_help(std::size_t width);

/// Returns the help of a command: the first sentence about each option, its values and its default.
std::string command_help(const Command& command, std::size_t width);

/// Returns the manual page ccdt(1) in roff.
std::string program_manual();

/// Returns the manual page of a command in roff, with all that openapi.json says about its options.
std::string command_manual(const Command& command);

/// Wraps a text at blanks. Each line begins with `indent` blanks and ends with a line break. A word that is longer than
/// a line has a line of its own.
std::string wrapped(std::string_view text, std::size_t indent, std::size_t width);

}  // namespace ccdt::server
