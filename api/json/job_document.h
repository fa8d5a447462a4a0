// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ccdt::api {

/// State of a job, as clients see it.
struct JobDocument {
    std::string_view id;
    std::string_view status;
    double progress = 0;  ///< 0 to 1
    int iteration = 0;
    std::optional<double> variation;
    std::string created;  ///< time in RFC 3339 format, like `started` and `finished`
    std::optional<std::string> started;
    std::optional<std::string> finished;
    std::string error;  ///< a problem document in JSON; empty: no error
};

/// Writes the state of a job as JSON, on one line without a line break. Values that are not set are null.
std::string job_json(const JobDocument& document);

}  // namespace ccdt::api
