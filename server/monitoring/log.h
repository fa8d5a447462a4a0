// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "server/config/config.h"
#include "server/http/http_server.h"
#include "server/jobs/job_service.h"

namespace spdlog {
class logger;
}

namespace ccdt::server {

/// Writes the log to standard error, as text or as one JSON object per line. Thread-safe.
class Log {
public:
    explicit Log(LogFormat format);

    void info(std::string_view message) const;
    void warning(std::string_view message) const;
    void error(std::string_view message) const;

    /// Writes one line for an answered request.
    void exchange(const Exchange& exchange) const;

    /// Writes one line for a finished job.
    void job(const JobEnd& end) const;

private:
    const LogFormat format_;
    std::shared_ptr<spdlog::logger> logger_;
};

/// Returns the line for a request: `key=value` pairs, or the members of a JSON object. Hides unknown parameters of the
/// query, which may contain an API key.
std::string exchange_line(const Exchange& exchange, LogFormat format);

std::string job_line(const JobEnd& end, LogFormat format);

/// Escapes quotes, backslashes, control characters and bytes beyond ASCII, for one log line and JSON strings.
std::string escape(std::string_view text);

}  // namespace ccdt::server
