#include "server/routes.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <exception>
#include <iterator>
#include <memory>
#include <mutex>
#include <random>
#include <utility>
#include <vector>

#include "api/analyze.h"
#include "api/halftone.h"
#include "api/problem.h"
#include "api/sample.h"
#include "server/compression.h"
#include "server/cors.h"
#include "server/multipart.h"

namespace ccdt::server {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

constexpr std::string_view kJson = "application/json";
constexpr std::string_view kProblem = "application/problem+json";
constexpr std::size_t kLongestId = 64;

/// Longer texts are compressed by workers.
constexpr std::size_t kQuickToCompress = 262'144;

/// What `OPTIONS *` tells: the methods that some path takes.
constexpr std::string_view kAllMethods = "GET, HEAD, POST, OPTIONS";

/// How often a connection looks whether its client still waits.
constexpr std::chrono::milliseconds kPeek{20};

/// Seconds after which a worker that goes on though its job was cancelled is taken for stuck.
constexpr double kLongestOverdue = 10;

/// How long after its deadline a job may take to stop, and to write down what it has.
constexpr std::chrono::seconds kGrace{2};

/// A result on its way from a worker to the connection that waits for it, which may leave before it comes.
class Ticket {
public:
    void begin() {
        const std::lock_guard lock(mutex_);
        stages_.queue = Milliseconds(Clock::now() - submitted_).count();
    }

    void finish(Result<api::Answer> result, const api::Timings& timings) {
        const std::lock_guard lock(mutex_);
        stages_.work = timings;
        result_ = std::move(result);
        finished_.notify_all();
    }

    /// @returns  whether there is a result
    bool wait_until(Clock::time_point time) {
        std::unique_lock lock(mutex_);
        return finished_.wait_until(lock, time, [this] { return result_.has_value(); });
    }

    Result<api::Answer> take_result() {
        const std::lock_guard lock(mutex_);
        return std::move(*result_);
    }

    Stages stages() const {
        const std::lock_guard lock(mutex_);
        return stages_;
    }

private:
    const Clock::time_point submitted_ = Clock::now();

    mutable std::mutex mutex_;  ///< guards the rest
    std::condition_variable finished_;
    std::optional<Result<api::Answer>> result_;
    Stages stages_;
};

bool is_json(std::string_view type) {
    return type == kJson || (type.starts_with("application/") && type.ends_with("+json"));
}

/// Types under which programs send JSON without saying so.
bool may_hold_json(std::string_view type) {
    constexpr std::string_view kUnspecific[] = {"", "text/plain", "application/octet-stream",
                                                "application/x-www-form-urlencoded"};
    return is_json(type) || std::ranges::find(kUnspecific, type) != std::end(kUnspecific);
}

bool is_request_id(std::string_view text) {
    const auto allowed = [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '_' ||
               c == '-';
    };
    return !text.empty() && text.size() <= kLongestId && std::ranges::all_of(text, allowed);
}

std::string hexadecimal(std::uint64_t number, int digits) {
    char text[17];
    std::snprintf(text, sizeof(text), "%0*llx", digits, static_cast<unsigned long long>(number));
    return text;
}

std::string server_timing(const Stages& stages) {
    char text[160];
    std::snprintf(text, sizeof(text), "queue;dur=%.1f, decode;dur=%.1f, optimise;dur=%.1f, encode;dur=%.1f",
                  stages.queue, stages.work.decode, stages.work.optimise, stages.work.encode);
    return text;
}

using Work = std::function<Result<api::Answer>(const Control&, api::Timings&)>;

/// The same work, whose answer is compressed in the end if the client wants it so and no stop has come: what there is
/// by a deadline goes out as it is.
Work compressing(Work work, const Request& request) {
    if (!accepts_gzip(request.header("Accept-Encoding"))) return work;
    return [work = std::move(work)](const Control& control, api::Timings& timings) -> Result<api::Answer> {
        auto answer = work(control, timings);
        if (!answer || !is_worth_compressing(answer->media_type, answer->body)) return answer;
        const auto start = Clock::now();
        if (auto compressed = gzip(answer->body, control.stop)) {
            answer->body = std::move(*compressed);
            answer->coding = "gzip";
        }
        timings.encode += Milliseconds(Clock::now() - start).count();
        return answer;
    };
}

Response json_response(std::string body) {
    Response response;
    response.media_type = kJson;
    response.body = std::move(body);
    return response;
}

}  // namespace

int http_status(ErrorCode code) {
    switch (code) {
        case ErrorCode::Malformed:
            return 400;
        case ErrorCode::Unusable:
            return 422;
        case ErrorCode::LimitExceeded:
            return 413;
        case ErrorCode::NotAcceptable:
            return 406;
        case ErrorCode::Unsupported:
            return 415;
        case ErrorCode::Stopped:
            return 503;
        case ErrorCode::Internal:
            break;
    }
    return 500;
}

constexpr Routes::Route Routes::kRoutes[] = {
    {"/halftone", "POST", "POST, OPTIONS", &Routes::halftone},
    {"/sample", "POST", "POST, OPTIONS", &Routes::sample},
    {"/analyze", "POST", "POST, OPTIONS", &Routes::analyze},
    {"/health", "GET", "GET, HEAD, OPTIONS", &Routes::live},
    {"/health/live", "GET", "GET, HEAD, OPTIONS", &Routes::live},
    {"/health/ready", "GET", "GET, HEAD, OPTIONS", &Routes::ready},
    {"/metrics", "GET", "GET, HEAD, OPTIONS", &Routes::metrics},
};

Routes::Routes(const Config& config, WorkerPool& pool, const Metrics& metrics, api::Decode decode)
    : config_(config),
      pool_(pool),
      metrics_(metrics),
      decode_(std::move(decode)),
      id_prefix_(hexadecimal(std::random_device()(), 8) + "-") {}

Response Routes::answer(const Request& request, const std::optional<Fault>& fault, Connection& connection) {
    const std::string id = request_id(request);
    Response response;
    try {
        auto outcome = fault ? Outcome(problem(*fault)) : dispatch(request, connection);
        response = outcome ? std::move(*outcome) : describe(std::move(outcome.error()), id);
        negotiate_coding(request, response);
    } catch (const std::exception& exception) {
        response = describe(problem(500, exception.what()).value(), id);
    }
    response.request_id = id;
    response.route = route_of(request);
    add_common_headers(request, response);
    return response;
}

std::string_view Routes::route_of(const Request& request) {
    const auto* route = std::ranges::find(kRoutes, std::string_view(request.path), &Route::path);
    return route == std::end(kRoutes) ? std::string_view() : route->path;
}

Routes::Outcome Routes::dispatch(const Request& request, Connection& connection) {
    if (request.method == "OPTIONS" && request.target == "*") return preflight(kAllMethods, request);
    const auto* route = std::ranges::find(kRoutes, std::string_view(request.path), &Route::path);
    if (route == std::end(kRoutes)) return problem(404, "there is nothing at this path");
    if (request.method == "OPTIONS") return preflight(route->allow, request);
    const bool headers_only = request.method == "HEAD" && route->method == "GET";
    if (request.method != route->method && !headers_only) {
        auto refused = problem(405, "this path takes " + std::string(route->allow));
        refused.value().headers.push_back({"Allow", std::string(route->allow)});
        return refused;
    }
    return (this->*route->handler)(request, connection);
}

Routes::Outcome Routes::live(const Request&, Connection&) {
    return json_response(R"({"status":"live"})");
}

Routes::Outcome Routes::ready(const Request&, Connection&) {
    if (draining_) return busy(503, "the server is shutting down");
    const WorkerPool::Load load = pool_.load();
    if (load.overdue_seconds > kLongestOverdue) return busy(503, "a worker does not stop when it is told to");
    if (load.backlog_seconds > std::chrono::duration<double>(config_.timeout).count())
        return busy(503, "what waits takes longer than the timeout");
    return json_response(R"({"status":"ready"})");
}

Routes::Outcome Routes::metrics(const Request&, Connection&) {
    Response response;
    response.media_type = "text/plain; version=0.0.4; charset=utf-8";
    response.body = metrics_.text(pool_.load());
    return response;
}

Routes::Outcome Routes::halftone(const Request& request, Connection& connection) {
    auto body = read_body(request, connection);
    if (!body) return tl::unexpected(std::move(body.error()));
    const std::string type = media_type(request.header("Content-Type"));
    if (is_json(type)) {
        Work work = [this, body = std::move(*body), options = parse_query(request.query),
                     accept = std::string(request.header("Accept"))](const Control& control, api::Timings& timings) {
            return api::parse_halftone_json(body, options, accept, config_.limits).and_then([&](const auto& parsed) {
                return api::run_halftone(parsed, config_.limits, decode_, control, timings);
            });
        };
        return compute(compressing(std::move(work), request), connection);
    }
    auto image = std::move(*body);
    auto options = parse_query(request.query);
    if (type == "multipart/form-data") {
        auto form = read_form(std::move(image), request.header("Content-Type"), options);
        if (!form) return tl::unexpected(std::move(form.error()));
        image = std::move(*form);
    }
    auto parsed = api::parse_halftone(std::move(image), options, request.header("Accept"), config_.limits);
    if (!parsed) return problem(std::move(parsed.error()));
    // Shared because functions are copied, and the picture should not be.
    Work work = [this, shared = std::make_shared<const api::HalftoneRequest>(std::move(*parsed))](
                    const Control& control, api::Timings& timings) {
        return api::run_halftone(*shared, config_.limits, decode_, control, timings);
    };
    return compute(compressing(std::move(work), request), connection);
}

Routes::Outcome Routes::sample(const Request& request, Connection& connection) {
    return compute_json(
        [this](const std::string& body, std::string_view accept, const Control& control, api::Timings& timings) {
            return api::parse_sample(body, accept, config_.limits).and_then([&](const auto& parsed) {
                return api::run_sample(parsed, config_.limits, decode_, control, timings);
            });
        },
        request, connection);
}

Routes::Outcome Routes::analyze(const Request& request, Connection& connection) {
    return compute_json(
        [this](const std::string& body, std::string_view accept, const Control& control, api::Timings& timings) {
            return api::parse_analyze(body, accept, config_.limits).and_then([&](const auto& parsed) {
                return api::run_analyze(parsed, control, timings);
            });
        },
        request, connection);
}

/// For paths whose options are members of a JSON body.
Routes::Outcome Routes::compute_json(JsonWork work, const Request& request, Connection& connection) {
    const std::string type = media_type(request.header("Content-Type"));
    if (!may_hold_json(type)) return problem(415, "the body must be application/json, not " + type);
    if (!request.query.empty()) return problem(400, "the options of this path are members of the JSON body");
    auto body = read_body(request, connection);
    if (!body) return tl::unexpected(std::move(body.error()));
    Work whole = [work = std::move(work), body = std::move(*body), accept = std::string(request.header("Accept"))](
                     const Control& control, api::Timings& timings) { return work(body, accept, control, timings); };
    return compute(compressing(std::move(whole), request), connection);
}

/// The picture of a form; its other fields are added to the options.
tl::expected<std::string, Routes::Problem> Routes::read_form(std::string body, std::string_view content_type,
                                                             std::vector<api::TextOption>& options) {
    const auto parts = parse_multipart(body, content_type);
    if (!parts) return problem(parts.error().status, parts.error().detail);
    const FormPart* picture = nullptr;
    for (const FormPart& part : *parts) {
        if (part.name != "image" && part.name != "file") {
            options.push_back({part.name, std::string(part.content(body))});
        } else if (picture == nullptr) {
            picture = &part;
        } else {
            return problem(400, "the form holds more than one picture", "image");
        }
    }
    if (picture == nullptr) return problem(400, "the form has no part `image`", "image");
    // In place: the picture may be as large as the body.
    body.resize(picture->begin + picture->size);
    body.erase(0, picture->begin);
    return body;
}

/// The body of a request that is to be computed, unless it is clear already that it will not be.
tl::expected<std::string, Routes::Problem> Routes::read_body(const Request& request, Connection& connection) const {
    const auto encoding = request.header("Content-Encoding");
    if (!encoding.empty() && !equals_ignoring_case(encoding, "identity"))
        return problem(415, "a Content-Encoding is not understood; send the body as it is");
    if (draining_) return busy(503, "the server is shutting down");
    if (pool_.is_full(connection.client_name())) return busy(429, "too many requests are waiting");
    auto body = connection.read_body(request, config_.max_body);
    if (!body) return problem(std::move(body.error()));
    return std::move(*body);
}

/// Has a worker do it, and waits: for the result, the deadline or the client's leaving.
Routes::Outcome Routes::compute(Work work, Connection& connection) {
    const auto deadline = Clock::now() + config_.timeout;
    const auto ticket = std::make_shared<Ticket>();
    const auto job = pool_.submit(connection.client_name(), [ticket, work = std::move(work)](std::stop_token stop) {
        ticket->begin();
        api::Timings timings;
        try {
            ticket->finish(work(Control{std::move(stop), {}}, timings), timings);
        } catch (const std::exception& exception) {
            ticket->finish(failure(ErrorCode::Internal, exception.what()), timings);
        }
    });
    if (!job) return busy(429, "too many requests are waiting");

    const auto give_up = [&](tl::unexpected<Problem> reason) {
        reason.value().stages = ticket->stages();
        return reason;
    };
    while (!ticket->wait_until(std::min(Clock::now() + kPeek, deadline))) {
        if (connection.client_gone()) {
            pool_.cancel(*job);
            auto gone = problem(499, "the client went away");
            gone.value().deliver = false;
            gone.value().cancelled = "client_gone";
            return give_up(std::move(gone));
        }
        if (abandoned_) {
            pool_.cancel(*job);
            auto refused = busy(503, "the server is shutting down");
            refused.value().cancelled = "shutdown";
            return give_up(std::move(refused));
        }
        if (Clock::now() < deadline) continue;
        if (pool_.cancel(*job) == WorkerPool::Cancelled::Queued) {
            auto refused = busy(503, "no worker was free in time");
            refused.value().cancelled = "deadline";
            return give_up(std::move(refused));
        }
        if (ticket->wait_until(deadline + kGrace)) break;
        return give_up(too_slow());
    }
    auto result = ticket->take_result();
    if (!result && result.error().code == ErrorCode::Stopped) return give_up(too_slow());
    if (!result) return give_up(problem(std::move(result.error())));
    Response response;
    response.media_type = std::move(result->media_type);
    response.body = std::move(result->body);
    response.coding = std::move(result->coding);
    response.computed = Computed{result->sites, result->pixels};
    if (result->partial) {
        response.headers.push_back({"X-Partial", "deadline"});
        response.cancelled = "deadline";
    }
    response.stages = ticket->stages();
    return response;
}

/// Answers OPTIONS, to people and to browsers that ask before a request from another origin.
Response Routes::preflight(std::string_view allow, const Request& request) const {
    Response response;
    response.status = 204;
    response.headers.push_back({"Allow", std::string(allow)});
    if (!config_.cors_origins.empty() && !request.header("Access-Control-Request-Method").empty())
        std::ranges::move(preflight_headers(allow), std::back_inserter(response.headers));
    return response;
}

tl::unexpected<Routes::Problem> Routes::problem(int status, std::string message, std::string field) {
    return tl::unexpected<Problem>(
        Problem{status, Error{ErrorCode::Internal, std::move(message), std::move(field)}, {}, {}, true});
}

tl::unexpected<Routes::Problem> Routes::problem(Error error) {
    const int status = http_status(error.code);
    return tl::unexpected<Problem>(Problem{status, std::move(error), {}, {}, true});
}

tl::unexpected<Routes::Problem> Routes::problem(Fault fault) {
    auto refused = problem(fault.status, std::move(fault.detail));
    refused.value().headers = std::move(fault.headers);
    return refused;
}

/// A refusal that may end well a little later.
tl::unexpected<Routes::Problem> Routes::busy(int status, std::string message) const {
    auto refused = problem(status, std::move(message));
    refused.value().headers.push_back({"Retry-After", std::to_string(pool_.backlog().count())});
    return refused;
}

tl::unexpected<Routes::Problem> Routes::too_slow() const {
    auto late = problem(504, "the computation took longer than the timeout of " +
                                 std::to_string(config_.timeout.count()) + " ms (timeout)");
    late.value().cancelled = "deadline";
    return late;
}

std::string Routes::request_id(const Request& request) {
    const auto given = request.header("X-Request-ID");
    if (is_request_id(given)) return std::string(given);
    return id_prefix_ + hexadecimal(++requests_, 8);
}

Response Routes::describe(Problem problem, const std::string& id) const {
    Response response;
    if (problem.status == 500) {
        response.cause = std::move(problem.error.message);
        problem.error.message = "the server failed; its log holds the cause";
        problem.error.field.clear();
    }
    response.status = problem.status;
    response.media_type = kProblem;
    response.body =
        api::problem_json(problem.status, status_phrase(problem.status), problem.error, "urn:request:" + id);
    response.headers = std::move(problem.headers);
    response.stages = problem.stages;
    response.deliver = problem.deliver;
    response.cancelled = problem.cancelled;
    return response;
}

/// Compresses a text for clients that want it so, unless a worker has done it.
void Routes::negotiate_coding(const Request& request, Response& response) {
    const bool done = !response.coding.empty();
    if (!done && !is_worth_compressing(response.media_type, response.body)) return;
    response.headers.push_back({"Vary", "Accept-Encoding"});
    if (!done && response.body.size() <= kQuickToCompress && accepts_gzip(request.header("Accept-Encoding"))) {
        response.body = *gzip(response.body);
        response.coding = "gzip";
    }
    if (!response.coding.empty()) response.headers.push_back({"Content-Encoding", response.coding});
}

void Routes::add_common_headers(const Request& request, Response& response) const {
    response.headers.push_back({"X-Request-ID", response.request_id});
    response.headers.push_back({"Server-Timing", server_timing(response.stages)});
    std::ranges::move(cors_headers(config_.cors_origins, request.header("Origin")),
                      std::back_inserter(response.headers));
}

}  // namespace ccdt::server
