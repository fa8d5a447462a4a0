#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ccdt::api {

/// State of a job, as its client is told.
struct JobDocument {
    std::string_view id;
    std::string_view status;
    double progress = 0;  ///< 0 to 1
    int iteration = 0;
    std::optional<double> variation;
    std::string created;  ///< times as in RFC 3339
    std::optional<std::string> started;
    std::optional<std::string> finished;
    std::string error;  ///< a problem as JSON; empty: none
};

/// Writes the state of a job as JSON, in one line without an end. What there is not yet is null.
std::string job_json(const JobDocument& document);

}  // namespace ccdt::api
