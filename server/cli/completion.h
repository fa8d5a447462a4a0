// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ccdt::server {

/// Returns the script with which a shell completes commands, options, their words and names of files.
/// @param shell  `bash`, `zsh` or `fish`; none for any other shell
std::optional<std::string> completion_script(std::string_view shell);

}  // namespace ccdt::server
