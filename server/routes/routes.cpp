#include "server/routes/routes.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <iterator>
#include <random>
#include <utility>
#include <vector>

#include "api/input/text.h"
#include "api/problem.h"
#include "server/http/compression.h"
#include "server/http/cors.h"
#include "server/http/http.h"
#include "server/page/page.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kJson = "application/json";
constexpr std::string_view kProblem = "application/problem+json";
constexpr std::size_t kLongestId = 64;

/// Longer texts are compressed by workers.
constexpr std::size_t kQuickToCompress = 262'144;

/// What `OPTIONS *` tells: the methods that some path takes.
constexpr std::string_view kAllMethods = "GET, HEAD, POST, DELETE, OPTIONS";

/// Seconds after which a worker that goes on though its job was cancelled is taken for stuck.
constexpr double kLongestOverdue = 10;

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

/// A strong tag names bytes, which differ between codings; a weak one what they mean.
void add_entity_tag(Response& response) {
    if (response.tag.empty()) return;
    if (!response.coding.empty() && response.tag.front() == '"')
        response.tag.insert(response.tag.size() - 1, '-' + response.coding);
    response.headers.push_back({"ETag", response.tag});
}

/// Where an id stands in the paths of jobs.
constexpr std::string_view kJobs = "/jobs/";
constexpr std::string_view kId = "{id}";

/// What is a job's id if the path is one of its.
std::string_view job_id(std::string_view path) {
    path.remove_prefix(std::min(path.size(), kJobs.size()));
    return api::take_until(path, "/");
}

bool matches(std::string_view pattern, std::string_view path) {
    const auto place = pattern.find(kId);
    if (place == std::string_view::npos) return pattern == path;
    const auto id = job_id(path);
    return !id.empty() && path.substr(0, place) == pattern.substr(0, place) &&
           path.substr(place + id.size()) == pattern.substr(place + kId.size());
}

tl::unexpected<Problem> no_place(Room room) {
    return busy(503,
                room == Room::Streams ? "too many streams of events are open (max-streams)"
                                      : "too many connections are open (max-connections)",
                std::chrono::seconds(1));
}

Response json_response(std::string body) {
    Response response;
    response.media_type = kJson;
    response.body = std::move(body);
    return response;
}

}  // namespace

constexpr Routes::Route Routes::kRoutes[] = {
    {"/", "GET", "GET, HEAD, OPTIONS", Room::Common, &Routes::page},
    {"/openapi.json", "GET", "GET, HEAD, OPTIONS", Room::Common, &Routes::page},
    {"/halftone", "POST", "POST, OPTIONS", Room::Common, &Routes::compute},
    {"/sample", "POST", "POST, OPTIONS", Room::Common, &Routes::compute},
    {"/analyze", "POST", "POST, OPTIONS", Room::Common, &Routes::compute},
    {"/health", "GET", "GET, HEAD, OPTIONS", Room::Reserve, &Routes::live},
    {"/health/live", "GET", "GET, HEAD, OPTIONS", Room::Reserve, &Routes::live},
    {"/health/ready", "GET", "GET, HEAD, OPTIONS", Room::Reserve, &Routes::ready},
    {"/metrics", "GET", "GET, HEAD, OPTIONS", Room::Reserve, &Routes::metrics},
    {"/jobs/{id}", "GET", "GET, HEAD, DELETE, OPTIONS", Room::Common, &Routes::job_status},
    {"/jobs/{id}", "DELETE", "GET, HEAD, DELETE, OPTIONS", Room::Common, &Routes::remove_job},
    {"/jobs/{id}/events", "GET", "GET, HEAD, OPTIONS", Room::Streams, &Routes::job_events},
    {"/jobs/{id}/result", "GET", "GET, HEAD, OPTIONS", Room::Common, &Routes::job_result},
};

Routes::Routes(const Config& config, WorkerPool& pool, Compute compute, Jobs& jobs, const Metrics& metrics,
               Lacking lacking)
    : config_(config),
      pool_(pool),
      metrics_(metrics),
      lacking_(std::move(lacking)),
      computing_(config, pool, std::move(compute), jobs),
      job_routes_(jobs, pool.memory(), config.jobs.ping),
      id_prefix_(hexadecimal(std::random_device()(), 8) + "-") {}

Response Routes::answer(const Request& request, const HttpResult<void>& received, Connection& connection) {
    const Route* const route = find_route(request.path, request.method);
    Record record;
    record.request_id = request_id(request);
    record.key = connection.key();
    if (route != nullptr) record.route = route->path;
    Response response;
    try {
        auto outcome = received.and_then([&] { return dispatch(route, {request, connection, record}); });
        response = outcome ? std::move(*outcome) : describe(std::move(outcome.error()), record);
        if (route != nullptr && request.method == "POST") response.headers.push_back({"Vary", "Accept"});
        negotiate_coding(request, response);
        add_entity_tag(response);
    } catch (const std::exception& exception) {
        response = describe(problem(500, exception.what()).value(), record);
    }
    response.record = std::move(record);
    add_common_headers(request, response);
    return response;
}

/// The route of a path, of several that of the method if there is one.
const Routes::Route* Routes::find_route(std::string_view path, std::string_view method) {
    const Route* found = nullptr;
    for (const Route& route : kRoutes) {
        if (!matches(route.path, path)) continue;
        if (found == nullptr || route.method == method) found = &route;
    }
    if (found == nullptr && find_page_file(path) != nullptr) return find_route("/", method);  // one for all of them
    return found;
}

HttpResult<Response> Routes::dispatch(const Route* route, const Incoming& incoming) {
    const Request& request = incoming.request;
    if (request.method == "OPTIONS" && request.target == "*") return preflight(kAllMethods, request);
    if (route == nullptr) return problem(404, "there is nothing at this path");
    if (request.method == "OPTIONS") return preflight(route->allow, request);
    const bool headers_only = request.method == "HEAD" && route->method == "GET";
    if (request.method != route->method && !headers_only) {
        auto refused = problem(405, "this path takes " + std::string(route->allow));
        refused.value().headers.push_back({"Allow", std::string(route->allow)});
        return refused;
    }
    if (!incoming.connection.move_to(route->room)) return no_place(route->room);
    return (this->*route->handler)(incoming);
}

HttpResult<Response> Routes::compute(const Incoming& incoming) {
    return computing_.answer(incoming);
}

HttpResult<Response> Routes::page(const Incoming& incoming) {
    return page_response(*find_page_file(incoming.request.path), incoming.request.header("If-None-Match"));
}

HttpResult<Response> Routes::live(const Incoming& /*incoming*/) {
    return json_response(R"({"status":"live"})");
}

HttpResult<Response> Routes::ready(const Incoming& /*incoming*/) {
    if (draining_) return computing_.busy(503, "the server is shutting down");
    if (auto lacking = lacking_(); !lacking.empty()) return computing_.busy(503, std::move(lacking));
    const WorkerPool::Load load = pool_.load();
    if (load.overdue_seconds > kLongestOverdue)
        return computing_.busy(503, "a worker does not stop when it is told to");
    if (load.backlog_seconds > std::chrono::duration<double>(config_.timeout).count())
        return computing_.busy(503, "what waits takes longer than the timeout");
    return json_response(R"({"status":"ready"})");
}

HttpResult<Response> Routes::metrics(const Incoming& /*incoming*/) {
    Response response;
    response.media_type = "text/plain; version=0.0.4; charset=utf-8";
    response.body = metrics_.text(pool_.load());
    return response;
}

HttpResult<Response> Routes::job_status(const Incoming& incoming) {
    return job_routes_.status(std::string(job_id(incoming.request.path)), incoming.connection);
}

HttpResult<Response> Routes::job_result(const Incoming& incoming) {
    return job_routes_.result(std::string(job_id(incoming.request.path)), incoming.request.header("If-None-Match"),
                              incoming.connection);
}

HttpResult<Response> Routes::job_events(const Incoming& incoming) {
    return job_routes_.events(std::string(job_id(incoming.request.path)), incoming.connection);
}

HttpResult<Response> Routes::remove_job(const Incoming& incoming) {
    return job_routes_.remove(std::string(job_id(incoming.request.path)), incoming.connection);
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

std::string Routes::request_id(const Request& request) {
    const auto given = request.header("X-Request-ID");
    if (api::is_plain_name(given, kLongestId)) return std::string(given);
    return id_prefix_ + hexadecimal(++requests_, 8);
}

Response Routes::describe(Problem problem, Record& record) {
    record.cause = std::move(problem.cause);
    Response response;
    response.status = problem.status;
    response.headers = std::move(problem.headers);
    response.media_type = kProblem;
    response.body = api::problem_json(problem.status, status_phrase(problem.status), problem.error,
                                      "urn:request:" + record.request_id);
    return response;
}

/// Compresses a text for clients that want it so, unless a worker has done it.
void Routes::negotiate_coding(const Request& request, Response& response) {
    const bool done = !response.coding.empty();
    const bool told = response.status == 304;  // which says what the whole answer would have said
    if (!done && !told && !is_worth_compressing(response.media_type, response.body)) return;
    response.headers.push_back({"Vary", "Accept-Encoding"});
    if (!done && !told && response.body.size() <= kQuickToCompress && accepts_gzip(request.header("Accept-Encoding"))) {
        response.body = *gzip(response.body);
        response.coding = "gzip";
    }
    if (!response.coding.empty()) response.headers.push_back({"Content-Encoding", response.coding});
}

void Routes::add_common_headers(const Request& request, Response& response) const {
    response.headers.push_back({"X-Request-ID", response.record.request_id});
    response.headers.push_back({"Server-Timing", server_timing(response.record.stages)});
    std::ranges::move(cors_headers(config_.cors_origins, request.header("Origin")),
                      std::back_inserter(response.headers));
}

}  // namespace ccdt::server
