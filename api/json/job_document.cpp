// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/json/job_document.h"

#include <nlohmann/json.hpp>

#include "api/text/text.h"

namespace ccdt::api {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json or_null(const std::optional<T>& value) {
    return value ? Json(*value) : Json();
}

}  // namespace

std::string job_json(const JobDocument& document) {
    const Json known = {{"id", document.id},
                        {"status", document.status},
                        {"progress", document.progress},
                        {"iteration", document.iteration},
                        {"variation", or_null(document.variation)},
                        {"created", document.created},
                        {"started", or_null(document.started)},
                        {"finished", or_null(document.finished)}};
    std::string text = known.dump();
    text.pop_back();
    return text + ",\"error\":" + (document.error.empty() ? "null" : std::string(trim(document.error, "\n"))) + '}';
}

}  // namespace ccdt::api
