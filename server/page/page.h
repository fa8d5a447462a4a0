// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "server/http/http.h"

namespace ccdt::server {

/// A file of the page, as the build embedded it.
struct PageFile {
    std::string_view path;  ///< at which it is served
    std::string_view media_type;
    std::string_view digest;  ///< of the content
    std::string_view content;
};

/// @returns  the file served at that path; null: there is none
const PageFile* find_page_file(std::string_view path);

/// The file, or 304 if one of the entity tags in `if_none_match` is the file's.
Response page_response(const PageFile& file, std::string_view if_none_match);

}  // namespace ccdt::server
