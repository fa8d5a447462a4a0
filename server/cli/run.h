// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "server/cli/command.h"

namespace ccdt::server {

/// Runs a command that computes answers: one answer for each input, in order. After a failed input, the next ones are
/// still answered, unless an option was wrong. The names of options and of all outputs are checked before any input is
/// read.
/// @param arguments  arguments after the name of the command
/// @returns          exit status of the first failure; 0 without failures; see exit_statuses()
int run_command(const Command& command, std::span<const char* const> arguments);

}  // namespace ccdt::server
