// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/routes/job_routes.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "api/output/body.h"
#include "server/http/entity_tag.h"

namespace ccdt::server {
namespace {

using Clock = std::chrono::steady_clock;

/// Interval at which an event stream checks whether its client is still connected.
constexpr std::chrono::milliseconds kPollInterval{200};

constexpr std::chrono::seconds kRetryAfter{1};

/// Maximum size of a result, in bytes, that is loaded as a whole. Larger results are sent in pieces.
constexpr std::size_t kMaxInMemory = api::Body::kMaxInMemory;

/// Makes an answer that caches must not store.
Response uncached_response(std::string media_type, std::string body) {
    Response response;
    response.media_type = std::move(media_type);
    response.body = std::move(body);
    response.headers.push_back({"Cache-Control", "no-store"});
    return response;
}

Response document(const Job& job) {
    return uncached_response("application/json", status_json(job) + '\n');
}

std::string event(const Job& job) {
    const std::string_view name = is_finished(job.status) ? name_of(job.status) : "progress";
    return "event: " + std::string(name) + "\ndata: " + status_json(job) + "\n\n";
}

}  // namespace

tl::unexpected<Problem> no_result(const Job& job) {
    if (job.status == JobStatus::Cancelled) return problem(410, "the job was cancelled");
    if (job.failure) {
        Problem failed{job.failure->status, job.failure->error};  // same as in the status document
        if (failed.status == 500) failed.cause = failed.error.message;
        return tl::unexpected(std::move(failed));
    }
    return problem(409, "the job is " + std::string(name_of(job.status)) + "; its result is not available yet");
}

Response accepted_response(const Job& job) {
    Response response = document(job);
    response.status = 202;
    response.headers.push_back({"Location", "/jobs/" + job.id});
    response.headers.push_back(
        {"Preference-Applied", job.callback.empty() ? "respond-async" : "respond-async, callback"});
    return response;
}

HttpResult<Response> JobRoutes::status(const std::string& id, const Connection& connection) const {
    const auto job = jobs_.find(id, connection.key());
    if (!job) return tl::unexpected(job.error());
    return document(*job);
}

/// Answers with the result of a job, or with a part of it. The job's id is the entity tag, because the result never
/// changes.
HttpResult<Response> JobRoutes::result(const std::string& id, const Request& request, const Connection& connection) {
    const auto job = jobs_.find(id, connection.key());
    if (!job) return tl::unexpected(job.error());
    if (job->status != JobStatus::Succeeded) return no_result(*job);
    if (const auto tag = find_tag(request.header("If-None-Match"), id)) return not_modified(*tag);
    const auto if_range = request.header("If-Range");
    const bool is_current = if_range.empty() || if_range == '"' + id + '"';
    if (const auto range = parse_range(request.header("Range"), job->result_bytes); range && is_current)
        return part(*job, *range);
    const bool in_pieces = job->result_bytes > kMaxInMemory;
    auto lease = memory_.reserve(in_pieces ? 2 * JobStore::kPiece : job->result_bytes);
    if (!lease) return busy(503, "there is too little memory left to send a result of this size", kRetryAfter);
    auto first = in_pieces ? jobs_.piece(id, 0) : jobs_.result(id);
    if (!first) return tl::unexpected(std::move(first.error()));
    Response response;
    response.media_type = job->media_type;
    response.tag = '"' + id + '"';
    if (in_pieces) {
        response.length = job->result_bytes;
        response.stream = stream_of(*job, *std::move(first));
    } else {
        response.body = *std::move(first);
    }
    response.lease = std::make_shared<MemoryBudget::Lease>(*std::move(lease));
    response.headers = job->headers;
    response.headers.push_back({"Accept-Ranges", "bytes"});
    if (job->partial) response.headers.push_back({"X-Partial", "deadline"});
    return response;
}

/// Answers with a part of a result. Long parts are sent in pieces.
HttpResult<Response> JobRoutes::part(const Job& job, const ByteRange& range) {
    const std::string size = '/' + std::to_string(job.result_bytes);
    if (range.length == 0) {
        auto refused = problem(416, "the result has only " + std::to_string(job.result_bytes) + " bytes");
        refused.value().headers.push_back({"Content-Range", "bytes *" + size});
        return refused;
    }
    auto lease = memory_.reserve(2 * JobStore::kPiece);
    if (!lease) return busy(503, "there is too little memory left to send a part of a result", kRetryAfter);
    const auto read = [this, job, range](std::size_t sent) {
        return results_.read(job, range.first + sent, std::min(JobStore::kPiece, range.length - sent));
    };
    auto first = read(0);
    if (!first) return tl::unexpected(std::move(first.error()));
    Response response;
    response.status = 206;
    response.media_type = job.media_type;
    response.tag = '"' + job.id + '"';
    response.headers = job.headers;
    response.headers.push_back({"Accept-Ranges", "bytes"});
    response.headers.push_back({"Content-Range", "bytes " + std::to_string(range.first) + '-' +
                                                     std::to_string(range.first + range.length - 1) + size});
    response.lease = std::make_shared<MemoryBudget::Lease>(*std::move(lease));
    if (first->size() == range.length) {
        response.body = *std::move(first);
        return response;
    }
    response.length = range.length;
    response.stream = [read, piece = *std::move(first), length = range.length](const Send& send, Record& record) {
        std::size_t sent = 0;
        for (HttpResult<std::string> next = piece; next; next = read(sent)) {
            if (!send(*next)) return false;
            sent += next->size();
            if (sent == length) return true;
        }
        record.cause = "a piece of the result could not be read";
        return false;
    };
    return response;
}

/// Returns the function that sends a large result in pieces.
Stream JobRoutes::stream_of(const Job& job, std::string first) const {
    return [this, id = job.id, remaining = job.result_bytes, piece = std::move(first)](const Send& send,
                                                                                       Record& record) mutable {
        for (std::size_t number = 1;; ++number) {
            const bool taken = piece.size() <= remaining && send(piece);
            remaining -= std::min(remaining, piece.size());
            if (!taken || remaining == 0) return taken;
            auto next = jobs_.piece(id, number);
            if (!next) {
                record.cause = next.error().error.message;
                return false;
            }
            piece = *std::move(next);
        }
    };
}

HttpResult<Response> JobRoutes::remove(const std::string& id, const Connection& connection) {
    if (const auto removed = jobs_.remove(id, connection.key()); !removed) return tl::unexpected(removed.error());
    Response response;
    response.status = 204;
    return response;
}

HttpResult<Response> JobRoutes::events(const std::string& id, const Connection& connection) const {
    auto watch = jobs_.watch(id, connection.key());
    if (!watch) return tl::unexpected(std::move(watch.error()));
    Response response = uncached_response("text/event-stream", {});
    response.headers.push_back({"X-Accel-Buffering", "no"});  // disables buffering by nginx
    response.stream = [this, &connection, watch = *std::move(watch)](const Send& send, Record&) {
        send_events(watch, connection, send);
        return true;
    };
    return response;
}

/// Sends events until the job ends, the client disconnects or the server shuts down.
void JobRoutes::send_events(JobService::Watch watch, const Connection& connection, const Send& send) const {
    auto silent_since = Clock::now();
    while (!connection.client_gone()) {
        const bool last_look = jobs_.is_draining();
        const auto ping = silent_since + ping_;
        const auto news = watch.next(last_look ? Clock::now() : std::min(Clock::now() + kPollInterval, ping));
        if (!news && (last_look || watch.is_over())) return;
        if (!news && Clock::now() < ping) continue;
        if (!news) watch.look_again();
        if (!send(news ? event(*news) : ": ping\n\n") || (news && is_finished(news->status))) return;
        silent_since = Clock::now();
    }
}

}  // namespace ccdt::server
