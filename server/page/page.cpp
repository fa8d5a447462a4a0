// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/page/page.h"

#include <algorithm>
#include <string>

#include "api/text/text.h"
#include "server/http/entity_tag.h"

namespace ccdt::server {
namespace {

/// Content security policy of the page. Forbids content of other hosts, inline scripts and styles, and frames.
constexpr std::string_view kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

}  // namespace

const PageFile* find_page_file(std::string_view path) {
    const auto files = page_files();
    const auto found = std::ranges::find(files, path, &PageFile::path);
    return found == files.end() ? nullptr : &*found;
}

Response page_response(const PageFile& file, std::string_view if_none_match) {
    Response response;
    response.tag = '"' + std::string(file.digest) + '"';
    response.headers = {{"Cache-Control", "no-cache"}};
    const auto known = find_tag(if_none_match, file.digest);
    if (known || api::trim(if_none_match) == "*") {
        response.status = 304;
        if (known) response.tag = *known;
        return response;
    }
    response.media_type = file.media_type;
    response.body = file.content;
    response.headers.push_back({"Content-Security-Policy", std::string(kPolicy)});
    response.headers.push_back({"X-Content-Type-Options", "nosniff"});
    response.headers.push_back({"Referrer-Policy", "no-referrer"});
    return response;
}

}  // namespace ccdt::server
