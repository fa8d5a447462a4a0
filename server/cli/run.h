// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "server/cli/command.h"

namespace ccdt::server {

/// Runs a command that computes answers: one answer for each input, in order. A failed input does not prevent the
/// others. The command line and the names of all outputs are checked first, before any input is read.
/// @param arguments  arguments after the name of the command
/// @returns          exit status: see exit_statuses(); that of the first failure
int run_command(const Command& command, std::span<const char* const> arguments);

}  // namespace ccdt::server
