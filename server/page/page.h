// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "server/http/http.h"

namespace ccdt::server {

/// A file of the page, which the build has embedded in the program.
struct PageFile {
    std::string_view path;  ///< path of the URL
    std::string_view media_type;
    std::string_view digest;  ///< digest of the content, used as its entity tag
    std::string_view content;
};

/// Finds the file that is served at a path.
/// @returns  null if there is none
const PageFile* find_page_file(std::string_view path);

/// Returns the answer with the file, or with status 304 if `if_none_match` contains the file's entity tag.
Response page_response(const PageFile& file, std::string_view if_none_match);

}  // namespace ccdt::server
