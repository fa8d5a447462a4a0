#include "server/work/answer_name.h"

#include <string>

#include "server/http/http.h"
#include "server/http/multipart.h"
#include "server/work/digest.h"

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

}  // namespace ccdt::server
