// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/answer_headers.h"

#include "api/text/numbers.h"

namespace ccdt::server {
namespace {

Header number_header(const char* name, double value) {
    Header header{name, {}};
    api::append_shortest(header.value, value);
    return header;
}

}  // namespace

std::vector<Header> answer_headers(const api::Answer& answer) {
    std::vector<Header> headers;
    if (answer.dots) {
        headers.push_back(number_header("X-Radius", answer.dots->radius));
        headers.push_back(number_header("X-Tone", answer.dots->tone));
    }
    if (answer.plot) headers.push_back(number_header("X-Plot-Seconds", answer.plot->seconds));
    if (!answer.repaired.empty()) headers.push_back({"X-Repaired", answer.repaired});
    if (!answer.warnings.empty()) headers.push_back({"X-Warnings", answer.warnings});
    return headers;
}

}  // namespace ccdt::server
