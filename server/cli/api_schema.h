// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/cli/option.h"
#include "server/page/page_files.h"

namespace ccdt::server {

/// Returns the description of the API, openapi.json. embed.cmake generates the definition during the build.
std::span<const PageFile> api_files();

/// Lists the options that schemas of openapi.json describe, each with its range, default and description. If several
/// schemas have an option of the same name, the first one describes it, and the words of all are accepted.
/// @param schemas  names of schemas, such as `HalftoneOptions`
std::vector<Option> read_options(std::span<const std::string_view> schemas);

}  // namespace ccdt::server
