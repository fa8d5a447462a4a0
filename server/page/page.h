// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "server/http/http.h"
#include "server/page/page_files.h"

namespace ccdt::server {

/// Finds the file of the page with a URL path.
/// @returns  null if there is no such file
const PageFile* find_page_file(std::string_view path);

/// Returns an answer with the file, or with status 304 if `if_none_match` contains the file's entity tag.
Response page_response(const PageFile& file, std::string_view if_none_match);

}  // namespace ccdt::server
