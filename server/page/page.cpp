#include "server/page/page.h"

#include <algorithm>
#include <string>

#include "api/input/text.h"
#include "server/page/page_files.h"

namespace ccdt::server {
namespace {

/// Nothing from other hosts, nothing inline, no frames around it.
constexpr std::string_view kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

bool names(std::string_view list, std::string_view tag) {
    while (!list.empty()) {
        auto item = api::trim(api::take_until(list, ","));
        if (item == "*") return true;
        if (item.starts_with("W/")) item.remove_prefix(2);
        if (item == tag) return true;
    }
    return false;
}

}  // namespace

const PageFile* find_page_file(std::string_view path) {
    const auto files = page_files();
    const auto found = std::ranges::find(files, path, &PageFile::path);
    return found == files.end() ? nullptr : &*found;
}

Response page_response(const PageFile& file, std::string_view if_none_match) {
    const std::string tag = '"' + std::string(file.digest) + '"';
    Response response;
    // Weak, since the bytes differ between codings.
    response.headers = {{"ETag", "W/" + tag}, {"Cache-Control", "no-cache"}};
    if (names(if_none_match, tag)) {
        response.status = 304;
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
