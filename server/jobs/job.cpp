// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job.h"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <iterator>

#include "api/json/job_document.h"
#include "api/problem.h"
#include "api/text/text.h"
#include "server/http/http.h"
#include "server/http/problem.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kNames[] = {"queued", "running", "succeeded", "failed", "cancelled"};

/// Formats a time according to RFC 3339, in UTC.
std::string text_of(Time time) {
    const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
    const std::time_t whole = seconds.time_since_epoch().count();
    std::tm parts{};
    gmtime_r(&whole, &parts);
    char date[32];
    std::strftime(date, sizeof(date), "%Y-%m-%dT%H:%M:%S", &parts);
    char text[40];
    std::snprintf(text, sizeof(text), "%s.%03dZ", date, static_cast<int>((time - seconds).count()));
    return text;
}

std::optional<std::string> text_of(std::optional<Time> time) {
    if (!time) return std::nullopt;
    return text_of(*time);
}

}  // namespace

std::string_view name_of(JobStatus status) {
    return kNames[static_cast<std::size_t>(status)];
}

std::optional<JobStatus> status_named(std::string_view name) {
    const auto found = std::ranges::find(kNames, name);
    if (found == std::end(kNames)) return std::nullopt;
    return static_cast<JobStatus>(found - std::begin(kNames));
}

std::string text_of(const std::vector<Header>& headers) {
    std::string text;
    for (const auto& [name, value] : headers) text.append(name).append(": ").append(value) += '\n';
    return text;
}

std::vector<Header> headers_in(std::string_view text) {
    constexpr std::size_t kLongestName = 64;
    std::vector<Header> headers;
    while (!text.empty()) {
        auto line = api::take_until(text, "\n");
        const auto name = api::take_until(line, ": ");
        if (api::is_plain_name(name, kLongestName)) headers.push_back({std::string(name), std::string(line)});
    }
    return headers;
}

std::string status_json(const Job& job) {
    api::JobDocument document{job.id,
                              name_of(job.status),
                              job.progress.fraction,
                              job.progress.iteration,
                              job.progress.variation,
                              text_of(job.created),
                              text_of(job.started),
                              text_of(job.finished),
                              {}};
    if (job.failure) {
        const int status = job.failure->status;
        document.error = api::problem_json(status, status_phrase(status), job.failure->error, "/jobs/" + job.id);
    }
    return api::job_json(document);
}

}  // namespace ccdt::server
