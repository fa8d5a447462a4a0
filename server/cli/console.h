// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>

namespace ccdt::server {

// Exit statuses; exit_statuses() describes them for users.
inline constexpr int kFailed = 1;
inline constexpr int kWrongUsage = 2;
inline constexpr int kInputFailed = 3;
inline constexpr int kOutputFailed = 4;

/// Returns the length of lines for help texts: the width of the terminal, at most 100.
std::size_t terminal_width();

/// Writes a text to standard output.
/// @returns  exit status
int print(const std::string& text);

}  // namespace ccdt::server
