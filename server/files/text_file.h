// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "core/base/result.h"

namespace ccdt::server {

/// Reads a file of the operator, such as keys or settings, of at most 16 MiB.
/// Errors (Unusable): the file cannot be read or is larger. The message names the file.
Result<std::string> read_text_file(const std::string& path);

}  // namespace ccdt::server
