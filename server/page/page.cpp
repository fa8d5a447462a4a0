// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/page/page.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "api/text/text.h"
#include "server/http/entity_tag.h"
#include "server/requests/digest.h"

namespace ccdt::server {
namespace {

/// Content security policy of the page. Forbids content of other hosts, inline scripts and styles, and frames.
constexpr std::string_view kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Suffixes of documents and their media types. Texts without another encoding are UTF-8.
constexpr auto kDocumentTypes = std::to_array<std::pair<std::string_view, std::string_view>>({
    {".html", "text/html; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".json", "application/json"},
    {".txt", "text/plain; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".webp", "image/webp"},
    {".jpg", "image/jpeg"},
});

}  // namespace

const PageFile* find_page_file(std::string_view path) {
    const auto files = page_files();
    const auto found = std::ranges::find(files, path, &PageFile::path);
    return found == files.end() ? nullptr : &*found;
}

std::string_view document_type(std::string_view path) {
    const auto found = std::ranges::find_if(kDocumentTypes, [&](const auto& row) { return path.ends_with(row.first); });
    return found == kDocumentTypes.end() ? "application/octet-stream" : found->second;
}

Response document_response(std::string_view path, std::string content, std::string_view if_none_match) {
    Digest digest;
    digest.add(content);
    const std::string tag = digest.finish();
    Response response = page_response({path, document_type(path), tag, {}}, if_none_match);
    if (response.status != 304) response.body = std::move(content);
    return response;
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
