#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "server/config/config.h"
#include "server/http/http_server.h"
#include "server/jobs/jobs.h"

namespace spdlog {
class logger;
}

namespace ccdt::server {

/// Writes to standard error, for people or as one JSON object a line. May be used from any thread.
class Log {
public:
    explicit Log(LogFormat format);

    void info(std::string_view message) const;
    void warning(std::string_view message) const;
    void error(std::string_view message) const;

    /// One line for a request.
    void exchange(const Exchange& exchange) const;

    /// One line for a job that has ended.
    void job(const JobEnd& end) const;

private:
    const LogFormat format_;
    std::shared_ptr<spdlog::logger> logger_;
};

/// The line for a request: `key=value` pairs, or the members of a JSON object. Of the query it has only what can be an
/// option: a client may have put its key there, under whatever name.
std::string exchange_line(const Exchange& exchange, LogFormat format);

std::string job_line(const JobEnd& end, LogFormat format);

/// Makes text fit for one line and for the inside of a JSON string: quotes, backslashes, control characters and
/// bytes beyond ASCII are escaped.
std::string escape(std::string_view text);

}  // namespace ccdt::server
