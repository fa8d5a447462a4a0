#include "server/routes/answer_headers.h"

#include <utility>

#include "api/text/numbers.h"

namespace ccdt::server {
namespace {

Header number_header(const char* name, double value) {
    Header header{name, {}};
    api::append_shortest(header.value, value);
    return header;
}

}  // namespace

std::vector<Header> answer_headers(const std::optional<api::DotSize>& dots, std::string repaired, bool partial) {
    std::vector<Header> headers;
    if (dots) {
        headers.push_back(number_header("X-Radius", dots->radius));
        headers.push_back(number_header("X-Tone", dots->tone));
    }
    if (!repaired.empty()) headers.push_back({"X-Repaired", std::move(repaired)});
    if (partial) headers.push_back({"X-Partial", "deadline"});
    return headers;
}

}  // namespace ccdt::server
