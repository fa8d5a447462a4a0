// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "server/http/http.h"
#include "server/page/page_files.h"

namespace ccdt::server {

/// Finds the file of the page with a URL path.
/// @returns  null if there is no such file
const PageFile* find_page_file(std::string_view path);

/// Returns the media type of a document by the suffix of its path; `application/octet-stream` if it is unknown.
std::string_view document_type(std::string_view path);

/// Returns an answer like page_response() for a document. The entity tag is a digest of the content.
Response document_response(std::string_view path, std::string content, std::string_view if_none_match);

/// Returns an answer with the file, or with status 304 if `if_none_match` contains the file's entity tag.
Response page_response(const PageFile& file, std::string_view if_none_match);

}  // namespace ccdt::server
