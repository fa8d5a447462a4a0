// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/monitoring/log.h"

#include <algorithm>
#include <iterator>

#include <spdlog/logger.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "api/halftone/device_picture.h"
#include "api/halftone/halftone.h"
#include "api/text/text.h"
#include "server/http/http.h"
#include "server/http/trace.h"

namespace ccdt::server {
namespace {

/// Maximum length of a logged request target, in bytes; longer targets are truncated.
constexpr std::size_t kMaxTargetLength = 512;

/// Text that replaces confidential values in the log.
constexpr std::string_view kHidden = "***";

std::string member(LogFormat format, std::string_view message) {
    if (format == LogFormat::Text) return escape(message);
    return fmt::format(R"("message":"{}")", escape(message));
}

/// Whether a query parameter is an option of /halftone with a harmless value. Other parameters may contain a key.
bool is_plain_option(const api::TextOption& option) {
    static const auto known = [] {  // other paths have no options
        auto names = api::halftone_options();
        std::ranges::copy(api::device_options(), std::back_inserter(names));
        names.emplace_back("preset");
        return names;
    }();
    const auto is_plain = [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               std::string_view("#+,-._").find(c) != std::string_view::npos;
    };
    return std::ranges::find(known, option.name) != known.end() && std::ranges::all_of(option.value, is_plain);
}

/// Returns the target of a request as sent, but hides the fragment and all parameters that are not plain options.
std::string target_of(const Request& request) {
    std::string_view fragment = request.target;
    std::string_view query = api::take_until(fragment, "#");
    std::string target(api::take_until(query, "?"));
    for (char separator = '?'; !query.empty(); separator = '&') {
        const auto parameter = api::take_until(query, "&");
        const auto options = parse_query(parameter);
        target += separator;
        target += options.empty() || is_plain_option(options.front()) ? parameter : kHidden;
    }
    return fragment.empty() ? target : target + '#' + std::string(kHidden);
}

/// Adds a member to a log line, unless its value is empty.
void add_member(std::string& line, const char* form, std::string_view value) {
    if (!value.empty()) line += fmt::format(fmt::runtime(form), escape(value));
}

/// Returns the level of the line for a request or a job.
spdlog::level::level_enum level_of(std::string_view cause) {
    return cause.empty() ? spdlog::level::info : spdlog::level::warn;
}

}  // namespace

std::string escape(std::string_view text) {
    std::string escaped;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            escaped += '\\';
            escaped += c;
        } else if (byte < ' ' || byte >= 0x7f) {
            escaped += fmt::format("\\u{:04x}", byte);
        } else {
            escaped += c;
        }
    }
    return escaped;
}

std::string exchange_line(const Exchange& exchange, LogFormat format) {
    const auto& [request, response, client, in, out, total] = exchange;
    const Record& record = response.record;
    const auto& stages = record.stages;
    constexpr std::string_view kText =
        "{} {} {} {} {} in={} out={} total={:.1f} queue={:.1f} decode={:.1f} prepare={:.1f} optimise={:.1f} "
        "encode={:.1f}";
    constexpr std::string_view kJson =
        R"("message":"request","id":"{}","client":"{}","method":"{}","target":"{}","status":{},"bytes_in":{},)"
        R"("bytes_out":{},"total_ms":{:.1f},"queue_ms":{:.1f},"decode_ms":{:.1f},"prepare_ms":{:.1f},)"
        R"("optimise_ms":{:.1f},"encode_ms":{:.1f})";
    const auto shown = [](std::string_view text) {
        return text.empty() ? "-" : escape(text.substr(0, kMaxTargetLength));
    };
    const bool text = format == LogFormat::Text;
    std::string line =
        fmt::format(fmt::runtime(text ? kText : kJson), shown(record.request_id), shown(client), shown(request.method),
                    shown(target_of(request)), response.status, in, out, total, stages.queue, stages.work.decode,
                    stages.work.prepare, stages.work.optimise, stages.work.encode);
    const auto add = [&](const char* as_text, const char* as_json, std::string_view value) {
        add_member(line, text ? as_text : as_json, value);
    };
    const auto trace = parse_traceparent(request.header("traceparent")).value_or(Trace{});
    add(" key={}", R"(,"key":"{}")", record.key);
    add(" signer={}", R"(,"signer":"{}")", record.signer);
    add(" cache={}", R"(,"cache":"{}")", record.cached ? "hit" : "");
    add(" trace={}", R"(,"trace":"{}")", trace.id);
    add(" parent={}", R"(,"parent":"{}")", trace.parent);
    add(R"( cause="{}")", R"(,"cause":"{}")", record.cause);
    return line;
}

std::string job_line(const JobEnd& end, LogFormat format) {
    constexpr std::string_view kText =
        "job {} {} result={} queue={:.1f} decode={:.1f} prepare={:.1f} optimise={:.1f} encode={:.1f}";
    constexpr std::string_view kJson =
        R"("message":"job","job":"{}","status":"{}","result_bytes":{},"queue_ms":{:.1f},"decode_ms":{:.1f},)"
        R"("prepare_ms":{:.1f},"optimise_ms":{:.1f},"encode_ms":{:.1f})";
    const bool text = format == LogFormat::Text;
    const auto& [queue, work] = end.stages;
    std::string line = fmt::format(fmt::runtime(text ? kText : kJson), end.job.id, name_of(end.job.status),
                                   end.job.result_bytes, queue, work.decode, work.prepare, work.optimise, work.encode);
    if (end.job.failure)
        line += fmt::format(fmt::runtime(text ? " error={}" : R"(,"error":{})"), end.job.failure->status);
    const auto add = [&](const char* as_text, const char* as_json, std::string_view value) {
        add_member(line, text ? as_text : as_json, value);
    };
    const auto trace = parse_traceparent(end.job.traceparent).value_or(Trace{});
    add(" key={}", R"(,"key":"{}")", end.job.owner);
    add(" trace={}", R"(,"trace":"{}")", trace.id);
    add(" parent={}", R"(,"parent":"{}")", trace.parent);
    add(R"( cause="{}")", R"(,"cause":"{}")", end.cause);
    return line;
}

Log::Log(LogFormat format)
    : format_(format),
      logger_(std::make_shared<spdlog::logger>("ccdt", std::make_shared<spdlog::sinks::stderr_color_sink_mt>())) {
    const bool json = format == LogFormat::Json;
    logger_->set_pattern(
        json ? R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l",%v})" : "%Y-%m-%dT%H:%M:%S.%eZ %^%l%$ %v",
        spdlog::pattern_time_type::utc);
    logger_->flush_on(spdlog::level::trace);
}

void Log::info(std::string_view message) const {
    logger_->info(member(format_, message));
}

void Log::warning(std::string_view message) const {
    logger_->warn(member(format_, message));
}

void Log::error(std::string_view message) const {
    logger_->error(member(format_, message));
}

void Log::job(const JobEnd& end) const {
    logger_->log(level_of(end.cause), job_line(end, format_));
}

void Log::exchange(const Exchange& exchange) const {
    logger_->log(level_of(exchange.response.record.cause), exchange_line(exchange, format_));
}

}  // namespace ccdt::server
