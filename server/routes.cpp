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

#include "api/cost.h"
#include "api/input/text.h"
#include "api/problem.h"
#include "server/http/compression.h"
#include "server/http/cors.h"
#include "server/http/multipart.h"
#include "server/page/page.h"

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

/// Shorter JSON is read by the connection's own thread.
constexpr std::size_t kQuickToParse = 8'192;

/// Longer bodies are never for short jobs.
constexpr std::size_t kLongBody = 65'536;

/// A result on its way from a worker to the connection that waits for it, which may leave before it comes.
template <class T>
class Ticket {
public:
    void begin() {
        const std::lock_guard lock(mutex_);
        stages_.queue = Milliseconds(Clock::now() - submitted_).count();
    }

    void finish(Result<T> result, const api::Timings& timings) {
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

    Result<T> take_result() {
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
    std::optional<Result<T>> result_;
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
    {"/", "GET", "GET, HEAD, OPTIONS", &Routes::page},
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
      waiting_memory_(pool.memory().total() / 3),  // a quarter of both
      id_prefix_(hexadecimal(std::random_device()(), 8) + "-") {}

Response Routes::answer(const Request& request, const std::optional<Fault>& fault, Connection& connection) {
    const std::string id = request_id(request);
    const Route* const route = find_route(request.path);
    Response response;
    try {
        auto outcome = fault ? Outcome(problem(*fault)) : dispatch(route, request, connection);
        response = outcome ? std::move(*outcome) : describe(std::move(outcome.error()), id);
        if (route != nullptr && request.method == "POST") response.headers.push_back({"Vary", "Accept"});
        negotiate_coding(request, response);
    } catch (const std::exception& exception) {
        response = describe(problem(500, exception.what()).value(), id);
    }
    response.request_id = id;
    if (route != nullptr) response.route = route->path;
    add_common_headers(request, response);
    return response;
}

const Routes::Route* Routes::find_route(std::string_view path) {
    if (find_page_file(path) != nullptr) path = "/";  // one route for all of them
    const auto* route = std::ranges::find(kRoutes, path, &Route::path);
    return route == std::end(kRoutes) ? nullptr : route;
}

Routes::Outcome Routes::dispatch(const Route* route, const Request& request, Connection& connection) {
    if (request.method == "OPTIONS" && request.target == "*") return preflight(kAllMethods, request);
    if (route == nullptr) return problem(404, "there is nothing at this path");
    if (request.method == "OPTIONS") return preflight(route->allow, request);
    const bool headers_only = request.method == "HEAD" && route->method == "GET";
    if (request.method != route->method && !headers_only) {
        auto refused = problem(405, "this path takes " + std::string(route->allow));
        refused.value().headers.push_back({"Allow", std::string(route->allow)});
        return refused;
    }
    return (this->*route->handler)(request, connection);
}

Routes::Outcome Routes::page(const Request& request, Connection&) {
    return page_response(*find_page_file(request.path), request.header("If-None-Match"));
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
    auto options = parse_query(request.query);
    if (is_json(type)) {
        const auto parse = [this, options = std::move(options)](std::string_view text, std::string_view accept) {
            return api::parse_halftone_json(text, options, accept, config_.limits)
                .map([this](api::HalftoneRequest parsed) { return plan(std::move(parsed)); });
        };
        return compute_json(parse, *std::move(body), request, connection);
    }
    if (type == "multipart/form-data") {
        body = read_form(*std::move(body), request.header("Content-Type"), options);
        if (!body) return tl::unexpected(std::move(body.error()));
    }
    auto parsed = api::parse_halftone(*std::move(body), options, request.header("Accept"), config_.limits);
    if (!parsed) return problem(std::move(parsed.error()));
    return compute(plan(*std::move(parsed)), request, connection, Clock::now() + config_.timeout);
}

Routes::Outcome Routes::sample(const Request& request, Connection& connection) {
    const auto parse = [this](std::string_view text, std::string_view accept) {
        return api::parse_sample(text, accept, config_.limits).map([this](api::SampleRequest parsed) {
            return plan(std::move(parsed));
        });
    };
    return compute_json(parse, request, connection);
}

Routes::Outcome Routes::analyze(const Request& request, Connection& connection) {
    const auto parse = [this](std::string_view text, std::string_view accept) {
        return api::parse_analyze(text, accept, config_.limits).map([](api::AnalyzeRequest parsed) {
            return plan(std::move(parsed));
        });
    };
    return compute_json(parse, request, connection);
}

/// The request is shared because functions are copied, and pictures should not be.
template <class Parsed, class Run>
Routes::Plan Routes::plan_for(Parsed request, const api::Cost& cost, Run run) {
    const std::size_t size = api::size_of(request);
    return {cost, size,
            [run = std::move(run), shared = std::make_shared<const Parsed>(std::move(request))](
                const Control& control, api::Timings& timings) { return run(*shared, control, timings); }};
}

Routes::Plan Routes::plan(api::HalftoneRequest request) const {
    const auto cost = api::cost_of(request, config_.limits);
    return plan_for(std::move(request), cost, [this](const auto& parsed, const Control& control, auto& timings) {
        return api::run_halftone(parsed, config_.limits, decode_, control, timings);
    });
}

Routes::Plan Routes::plan(api::SampleRequest request) const {
    const auto cost = api::cost_of(request, config_.limits);
    return plan_for(std::move(request), cost, [this](const auto& parsed, const Control& control, auto& timings) {
        return api::run_sample(parsed, config_.limits, decode_, control, timings);
    });
}

Routes::Plan Routes::plan(api::AnalyzeRequest request) {
    const auto cost = api::cost_of(request);
    return plan_for(std::move(request), cost, api::run_analyze);
}

/// For paths whose options are members of a JSON body.
Routes::Outcome Routes::compute_json(const Parse& parse, const Request& request, Connection& connection) {
    const std::string type = media_type(request.header("Content-Type"));
    if (!may_hold_json(type)) return problem(415, "the body must be application/json, not " + type);
    if (!request.query.empty()) return problem(400, "the options of this path are members of the JSON body");
    auto body = read_body(request, connection);
    if (!body) return tl::unexpected(std::move(body.error()));
    return compute_json(parse, *std::move(body), request, connection);
}

/// What a body asks for costs is known once it is read, which a worker does unless it is short.
Routes::Outcome Routes::compute_json(const Parse& parse, std::string body, const Request& request,
                                     Connection& connection) {
    const auto deadline = Clock::now() + config_.timeout;
    std::string accept(request.header("Accept"));
    if (body.size() <= kQuickToParse) {
        auto plan = parse(body, accept);
        if (!plan) return problem(std::move(plan.error()));
        return compute(*std::move(plan), request, connection, deadline);
    }
    const std::size_t size = body.size();
    const auto cost = api::cost_of_parsing(body);
    // All of it is the worker's own: the connection may leave before it is done.
    Job<Plan> read = [parse, accept = std::move(accept), shared = std::make_shared<const std::string>(std::move(body))](
                         const Control&, api::Timings&) { return parse(*shared, accept); };
    Stages stages;
    auto plan = have_done(cost, size, std::move(read), connection, deadline, stages);
    if (!plan) return tl::unexpected(std::move(plan.error()));
    return compute(*std::move(plan), request, connection, deadline, stages.queue);
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
    const bool may_be_short = request.content_length.value_or(kLongBody) < kLongBody;
    if (pool_.is_full(connection.client_name(), may_be_short)) return busy(429, "too many requests are waiting");
    auto body = connection.read_body(request, config_.max_body);
    if (!body) return problem(std::move(body.error()));
    return std::move(*body);
}

/// The same work, whose answer is compressed in the end if no stop has come: what there is by a deadline goes out as it
/// is.
Routes::Work Routes::compressing(Work work) {
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

/// Has a worker do it, and waits: for the result, the deadline or the client's leaving.
///
/// @param held    bytes that the request holds until it is done
/// @param stages  filled as far as it came
template <class T>
tl::expected<T, Routes::Problem> Routes::have_done(const api::Cost& cost, std::size_t held, Job<T> work,
                                                   Connection& connection, Clock::time_point deadline, Stages& stages) {
    if (cost.memory > pool_.memory().total() || held > waiting_memory_.total()) return too_large(cost.memory + held);
    auto lease = waiting_memory_.take(held);
    if (!lease) return busy(429, "too many large requests are waiting");
    const auto ticket = std::make_shared<Ticket<T>>();
    const auto job = pool_.submit(
        connection.client_name(),
        [ticket, work = std::move(work),
         lease = std::make_shared<MemoryBudget::Lease>(*std::move(lease))](std::stop_token stop) {
            ticket->begin();
            api::Timings timings;
            try {
                ticket->finish(work(Control{std::move(stop), {}}, timings), timings);
            } catch (const std::exception& exception) {
                ticket->finish(failure(ErrorCode::Internal, exception.what()), timings);
            }
        },
        cost);
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
    stages = ticket->stages();
    return *std::move(result);
}

/// An answer, and its part of the memory that computing it had.
struct Routes::Product {
    api::Answer answer;
    MemoryBudget::Lease lease;
};

/// @param waited  milliseconds in the queue so far
Routes::Outcome Routes::compute(Plan plan, const Request& request, Connection& connection, Clock::time_point deadline,
                                double waited) {
    if (accepts_gzip(request.header("Accept-Encoding"))) plan.work = compressing(std::move(plan.work));
    Job<Product> job = [this, work = std::move(plan.work)](const Control& control, api::Timings& timings) {
        return work(control, timings).map([this](api::Answer answer) {
            const std::size_t size = answer.body.size();
            return Product{std::move(answer), pool_.memory().hold(size)};
        });
    };
    Response response;
    auto product = have_done(plan.cost, plan.size, std::move(job), connection, deadline, response.stages);
    if (!product) return tl::unexpected(std::move(product.error()));
    api::Answer& answer = product->answer;
    response.stages.queue += waited;
    response.media_type = std::move(answer.media_type);
    response.body = std::move(answer.body);
    response.coding = std::move(answer.coding);
    response.computed = Computed{answer.sites, answer.pixels};
    response.lease = std::make_shared<MemoryBudget::Lease>(std::move(product->lease));
    if (answer.partial) {
        response.headers.push_back({"X-Partial", "deadline"});
        response.cancelled = "deadline";
    }
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

tl::unexpected<Routes::Problem> Routes::too_large(std::size_t bytes) const {
    const auto mebibytes = [](std::size_t size) { return std::to_string((size >> 20) + 1) + " MiB"; };
    return problem(413, "this would take about " + mebibytes(bytes) + " of memory; of this server's limit (memory) " +
                            mebibytes(pool_.memory().total()) + " are for computing and " +
                            mebibytes(waiting_memory_.total()) + " for requests");
}

tl::unexpected<Routes::Problem> Routes::too_slow() const {
    auto late = problem(504, "the computation took longer than the timeout of " +
                                 std::to_string(config_.timeout.count()) + " ms (timeout)");
    late.value().cancelled = "deadline";
    return late;
}

std::string Routes::request_id(const Request& request) {
    const auto given = request.header("X-Request-ID");
    if (api::is_plain_name(given, kLongestId)) return std::string(given);
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
