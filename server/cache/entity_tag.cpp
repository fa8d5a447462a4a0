#include "server/cache/entity_tag.h"

#include <string_view>

#include "api/input/text.h"
#include "server/digest.h"
#include "server/http/multipart.h"

namespace ccdt::server {
namespace {

void add_form(const Question& question, Digest& digest) {
    const auto parts = parse_multipart(question.body, question.content_type);
    if (!parts) return digest.add(question.body);
    for (const FormPart& part : *parts) {
        digest.add(part.name);
        digest.add(part.content(question.body));
    }
}

}  // namespace

std::string name_of_answer(const Question& question, const api::Limits& limits) {
    const std::string type = media_type(question.content_type);
    // What is not asked for is chosen within the limits.
    const std::string server =
        CCDT_VERSION " " + std::to_string(limits.max_sites) + ' ' + std::to_string(limits.max_pixels);
    Digest digest;
    for (const std::string& text : {server, question.path, question.query, type, question.accept}) digest.add(text);
    if (type == "multipart/form-data") {
        add_form(question, digest);
    } else {
        digest.add(question.body);
    }
    return digest.finish();
}

std::optional<std::string_view> find_tag(std::string_view if_none_match, std::string_view name) {
    while (!if_none_match.empty()) {
        const auto tag = api::trim(api::take_until(if_none_match, ","));
        auto opaque = tag;
        if (opaque.starts_with("W/")) opaque.remove_prefix(2);
        if (opaque.size() < 2 || opaque.front() != '"' || opaque.back() != '"') continue;
        opaque = opaque.substr(1, opaque.size() - 2);
        if (opaque.ends_with("-gzip")) opaque.remove_suffix(5);
        if (opaque == name) return tag;
    }
    return std::nullopt;
}

Response not_modified(std::string_view tag) {
    Response response;
    response.status = 304;
    response.tag = tag;
    return response;
}

}  // namespace ccdt::server
