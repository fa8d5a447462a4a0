// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/routes/routes.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <exception>
#include <iterator>
#include <random>
#include <utility>

#include "api/capabilities.h"
#include "api/problem.h"
#include "api/text/text.h"
#include "server/access/signed_url.h"
#include "server/http/compression.h"
#include "server/http/cors.h"
#include "server/http/hosts.h"
#include "server/http/http.h"
#include "server/page/page.h"
#include "server/requests/operation.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kJson = "application/json";
constexpr std::string_view kProblem = "application/problem+json";
constexpr std::size_t kMaxIdLength = 64;

/// Maximum length of a logged origin, in bytes. Host names have at most 253.
constexpr std::size_t kMaxOriginLength = 300;
constexpr std::size_t kMaxHostLength = 260;

/// Maximum size of a text, in bytes, that the thread of a connection compresses. Workers compress longer texts.
constexpr std::size_t kMaxQuicklyCompressed = 262'144;

/// Bytes of pieces of results that are kept for clients that read many small parts.
constexpr std::size_t kKeptResults = std::size_t{32} << 20;

/// Methods that at least one path accepts, for `OPTIONS *`.
constexpr std::string_view kAllMethods = "GET, HEAD, POST, DELETE, OPTIONS";

/// Time in seconds after which a worker that still runs a cancelled job counts as stuck.
constexpr double kMaxOverdueSeconds = 10;

std::string hexadecimal(std::uint64_t number, int digits) {
    char text[17];
    std::snprintf(text, sizeof(text), "%0*llx", digits, static_cast<unsigned long long>(number));
    return text;
}

std::string server_timing(const Stages& stages) {
    const auto& [queue, work] = stages;
    char text[280];
    int size = std::snprintf(text, sizeof(text),
                             "queue;dur=%.1f, decode;dur=%.1f, prepare;dur=%.1f, optimise;dur=%.1f, encode;dur=%.1f",
                             queue, work.decode, work.prepare, work.optimise, work.encode);
    if (work.threads > 0)
        std::snprintf(text + size, sizeof(text) - static_cast<std::size_t>(size), ", cpu;dur=%.1f, threads;desc=\"%u\"",
                      work.processor, work.threads);
    return text;
}

/// Adds the ETag header. A strong tag identifies the bytes of the body, so it gets a suffix for the content coding. A
/// weak tag does not depend on the coding.
void add_entity_tag(Response& response) {
    if (response.tag.empty()) return;
    if (!response.coding.empty() && response.tag.front() == '"')
        response.tag.insert(response.tag.size() - 1, '-' + response.coding);
    response.headers.push_back({"ETag", response.tag});
}

/// Finds the part of a path that placeholders match, in a pattern such as `/jobs/{id}/events`: from the first one to
/// the last one. The placeholder `{path}`, at the end of a pattern, also matches slashes and an empty text.
/// @returns  none if the path does not match; empty if the pattern has no placeholder
std::optional<std::string_view> match(std::string_view pattern, std::string_view path) {
    const auto begin = pattern.find('{');
    if (begin == std::string_view::npos) return pattern == path ? std::optional(std::string_view()) : std::nullopt;
    if (!path.starts_with(pattern.substr(0, begin))) return std::nullopt;
    if (pattern.substr(begin) == "{path}") return path.substr(begin);
    const auto end = pattern.rfind('}') + 1;
    const auto wanted = pattern.substr(begin, end - begin), rest = pattern.substr(end);
    if (path.size() <= begin + rest.size() || !path.ends_with(rest)) return std::nullopt;
    const auto found = path.substr(begin, path.size() - begin - rest.size());
    if (std::ranges::count(found, '/') != std::ranges::count(wanted, '/')) return std::nullopt;
    return found;
}

/// Whether a route for the method `of_route` accepts requests with `method`. Routes for GET also accept HEAD.
bool accepts_method(std::string_view method, std::string_view of_route) {
    return method == of_route || (method == "HEAD" && of_route == "GET");
}

/// Makes the Cache-Control header of GET /halftone/{name}. Freshness ends when the signed URL expires. A partial
/// answer, which has no tag, must not be stored.
/// @param max_age     time for which caches may reuse the answer without revalidation
/// @param is_private  whether an API key was needed, so that only the client may store the answer
Header cache_control(const Response& response, const SignedUrl& url, std::chrono::seconds max_age, bool is_private) {
    if (response.tag.empty()) return {"Cache-Control", "no-store"};
    auto seconds = static_cast<std::uint64_t>(max_age.count());
    if (url.expires) {
        const auto now = static_cast<std::uint64_t>(std::time(nullptr));
        seconds = std::min(seconds, *url.expires - std::min(now, *url.expires));
    }
    return {"Cache-Control", (is_private ? "private, max-age=" : "public, max-age=") + std::to_string(seconds)};
}

tl::unexpected<Problem> no_slot(ConnectionClass connection_class) {
    return busy(503,
                connection_class == ConnectionClass::Streams ? "too many event streams are open (max-streams)"
                                                             : "too many connections are open (max-connections)",
                std::chrono::seconds(1));
}

api::OfferedPictures offered_pictures(const Config& config) {
    if (config.pictures.empty()) return api::OfferedPictures::None;
    return config.signing.empty() ? api::OfferedPictures::Unsigned : api::OfferedPictures::Signed;
}

/// Returns the folder of a setting; none if the setting is empty.
/// @param noun  see FileFolder
std::optional<FileFolder> folder_of(const std::string& path, const char* noun) {
    if (path.empty()) return std::nullopt;
    return std::optional<FileFolder>(std::in_place, path, noun);
}

Response json_response(std::string body) {
    Response response;
    response.media_type = kJson;
    response.body = std::move(body);
    return response;
}

}  // namespace

/// The table of routes: fixed ones, and one for each operation in kOperations.
struct Routes::Table {
    static constexpr auto kFixed = std::to_array<Route>({
        {"/", "GET", ConnectionClass::Common, Access::Read, &Routes::page, nullptr},
        {"/openapi.json", "GET", ConnectionClass::Common, Access::Read, &Routes::page, nullptr},
        {"/docs/{path}", "GET", ConnectionClass::Common, Access::Read, &Routes::document, nullptr},
        {"/capabilities", "GET", ConnectionClass::Common, Access::Read, &Routes::capabilities, nullptr},
        {"/health", "GET", ConnectionClass::Reserve, Access::Anyone, &Routes::live, nullptr},
        {"/health/live", "GET", ConnectionClass::Reserve, Access::Anyone, &Routes::live, nullptr},
        {"/health/ready", "GET", ConnectionClass::Reserve, Access::Anyone, &Routes::ready, nullptr},
        {"/metrics", "GET", ConnectionClass::Reserve, Access::ApiKey, &Routes::metrics, nullptr},
        {"/halftone/{name}", "GET", ConnectionClass::Common, Access::Signature, &Routes::picture,
         find_operation("/halftone")},
        {"/jobs/{id}", "GET", ConnectionClass::Common, Access::ApiKey, &Routes::job_status, nullptr},
        {"/jobs/{id}", "DELETE", ConnectionClass::Common, Access::ApiKey, &Routes::remove_job, nullptr},
        {"/jobs/{id}/events", "GET", ConnectionClass::Streams, Access::ApiKey, &Routes::job_events, nullptr},
        {"/jobs/{id}/result", "GET", ConnectionClass::Common, Access::ApiKey, &Routes::job_result, nullptr},
        {"/tiles/{id}.json", "GET", ConnectionClass::Common, Access::ApiKey, &Routes::tile_document, nullptr},
        {"/tiles/{id}/{z}/{x}/{y}.mvt", "GET", ConnectionClass::Common, Access::ApiKey, &Routes::tile, nullptr},
    });

    static constexpr Route row_of(const Operation& operation) {
        return {operation.path, "POST", ConnectionClass::Common, Access::ApiKey, &Routes::compute, &operation};
    }

    static const std::array<Route, kFixed.size() + kOperations.size()> kRows;
};

constexpr std::array<Routes::Route, Routes::Table::kFixed.size() + kOperations.size()> Routes::Table::kRows = [] {
    std::array<Route, kFixed.size() + kOperations.size()> rows{};
    std::ranges::transform(kOperations, std::ranges::copy(kFixed, rows.begin()).out, row_of);
    return rows;
}();

Routes::Routes(const Config& config, Parts parts)
    : config_(config),
      access_control_(parts.access_control),
      pool_(parts.pool),
      metrics_(parts.metrics),
      obstacle_(std::move(parts.obstacle)),
      warn_(std::move(parts.warn)),
      computing_(config, parts.pool, parts.waiting_memory, std::move(parts.compute), std::move(parts.read_shapefile),
                 parts.jobs, parts.answers),
      pictures_(folder_of(config.pictures, "picture")),
      documents_(folder_of(config.docs, "document")),
      results_(parts.jobs, kKeptResults),
      job_routes_(parts.jobs, results_, parts.pool.memory(), config.jobs.ping),
      tile_routes_(parts.jobs, results_),
      id_prefix_(hexadecimal(std::random_device()(), 8) + "-"),
      live_(std::make_shared<const LiveConfig>(config.live)) {}

void Routes::reload(const LiveConfig& live) {
    auto fresh = std::make_shared<const LiveConfig>(live);
    const std::lock_guard lock(mutex_);
    live_ = std::move(fresh);
}

std::shared_ptr<const LiveConfig> Routes::live() const {
    const std::lock_guard lock(mutex_);
    return live_;
}

Response Routes::answer(const Request& request, const HttpResult<void>& received, Connection& connection, Port port) {
    auto found = find(request);
    if (found.route != nullptr && !is_offered(*found.route, port)) found = {};
    Record record;
    connection.name_client({}, {});  // removes the name that the previous request has set
    const auto admitted = received.and_then([&] { return check_host(found, request, port); }).and_then([&] {
        return admit(found, request, port, connection, record);
    });
    record.request_id = request_id(request);
    record.key = connection.key();
    if (found.route != nullptr) record.route = found.route->path;
    Response response;
    try {
        auto outcome = admitted.and_then([&] {
            return dispatch(found.route, {request, connection, record, found.target});
        });
        response = outcome ? std::move(*outcome) : describe(std::move(outcome.error()), record);
        if (found.target.operation != nullptr && accepts_method(request.method, found.route->method))
            response.headers.push_back({"Vary", "Accept"});
        negotiate_coding(request, response);
        add_entity_tag(response);
    } catch (const std::exception& exception) {
        response = describe(problem(500, exception.what()).value(), record);
    }
    response.record = std::move(record);
    add_common_headers(request, response);
    warn_of_refused_origin(request);
    return response;
}

/// Finds the row with the path and, if possible, the method of a request. Files of the page share one route.
Routes::Found Routes::find(const Request& request) {
    Found found;
    for (const Route& route : Table::kRows) {
        const auto name = match(route.path, request.path);
        if (!name) continue;
        if (found.route == nullptr || route.method == request.method) found.route = &route;
        found.target.name = *name;
    }
    if (found.route == nullptr || found.route->handler == &Routes::page)
        found.target.file = find_page_file(request.path);
    if (found.route == nullptr && found.target.file != nullptr)
        found.route = std::ranges::find(Table::kRows, "/", &Route::path);
    if (found.route != nullptr) found.target.operation = found.route->operation;
    return found;
}

/// Whether a port offers a route.
bool Routes::is_offered(const Route& route, Port port) const {
    const bool is_metrics = route.handler == &Routes::metrics;
    if (port == Port::Metrics) return is_metrics || route.access == Access::Anyone;
    return !is_metrics || !config_.metrics_port;
}

/// Returns the credential that a request needs. Unknown paths below /health/ need none, so that the answer is 404.
AccessControl::Credential Routes::required_credential(const Found& found, const Request& request, Port port) {
    if (port == Port::Metrics) return AccessControl::Credential::None;
    const auto key_unless = [](bool free) {
        return free ? AccessControl::Credential::None : AccessControl::Credential::Key;
    };
    if (found.route == nullptr) return key_unless(request.path.starts_with("/health/"));
    switch (found.route->access) {
        case Access::ApiKey:
            return AccessControl::Credential::Key;
        case Access::Signature:
            return AccessControl::Credential::Signature;
        case Access::Read:
            return key_unless(accepts_method(request.method, "GET"));
        case Access::Anyone:
            break;
    }
    return AccessControl::Credential::None;
}

/// Refuses requests for hosts that are not allowed, except health checks, and metrics for other machines.
HttpResult<void> Routes::check_host(const Found& found, const Request& request, Port port) {
    if (port == Port::Metrics && !is_loopback(config_.bind)) return {};
    const bool is_for_anyone = found.route != nullptr && found.route->access == Access::Anyone;
    if (is_for_anyone || allows_host(live()->allowed_hosts, request.authority)) return {};
    const std::string host = request.authority.substr(0, kMaxHostLength);
    if (!warned_of_hosts_.exchange(true))
        warn_("a request for the host " + host + " was refused; --allowed-host with this name would allow it. " +
              "Further refusals of hosts are not logged");
    return problem(421, "this server does not answer for the host " + host + " (allowed-host)");
}

/// Checks the credentials and the rate of a request. Stores the client's name in the connection.
HttpResult<void> Routes::admit(const Found& found, const Request& request, Port port, Connection& connection,
                               Record& record) {
    auto verdict =
        access_control_.check(request, connection.client().address, required_credential(found, request, port));
    connection.name_client(std::move(verdict.client), std::move(verdict.key));
    record.signer = std::move(verdict.signer);
    return std::move(verdict.admission);
}

/// Returns the methods that a path accepts, as the value of the Allow header.
std::string Routes::allowed_methods(const Route& route) {
    std::string methods;
    for (const Route& other : Table::kRows) {
        if (other.path != route.path) continue;
        methods += std::string(other.method) + ", ";
        if (other.method == "GET") methods += "HEAD, ";
    }
    return methods + "OPTIONS";
}

HttpResult<Response> Routes::dispatch(const Route* route, const Incoming& incoming) {
    const Request& request = incoming.request;
    static_assert(std::ranges::all_of(
        Table::kRows, [](const Route& row) { return kAllMethods.find(row.method) != std::string_view::npos; }));
    if (request.method == "OPTIONS" && request.target == "*") return preflight(kAllMethods, request);
    if (route == nullptr) return problem(404, "there is nothing at this path");
    if (request.method == "OPTIONS") return preflight(allowed_methods(*route), request);
    if (!accepts_method(request.method, route->method)) {
        const std::string allowed = allowed_methods(*route);
        auto refused = problem(405, "this path accepts " + allowed);
        refused.value().headers.push_back({"Allow", allowed});
        return refused;
    }
    if (!incoming.connection.move_to(route->connection_class)) return no_slot(route->connection_class);
    return (this->*route->handler)(incoming);
}

HttpResult<Response> Routes::compute(const Incoming& incoming) {
    return computing_.answer(*incoming.target.operation, live()->presets, incoming);
}

HttpResult<Response> Routes::picture(const Incoming& incoming) {
    if (!pictures_) return problem(404, "this server has no folder of pictures (pictures)");
    const auto url = SignedUrl::parse(incoming.request.resource);
    if (!url) return tl::unexpected(url.error());
    auto file = pictures_->open(incoming.target.name, config_.max_body);
    if (!file) return tl::unexpected(file.error());
    auto response =
        computing_.answer(*incoming.target.operation, live()->presets, *std::move(file), url->options, incoming);
    if (response)
        response->headers.push_back(
            cache_control(*response, *url, live()->pictures_max_age, !incoming.connection.key().empty()));
    return response;
}

HttpResult<Response> Routes::page(const Incoming& incoming) {
    return page_response(*incoming.target.file, incoming.request.header("If-None-Match"));
}

/// Answers with a file of the folder of documentation. Memory for the file is reserved until it is sent.
HttpResult<Response> Routes::document(const Incoming& incoming) {
    if (!documents_) return problem(404, "this server has no folder of documentation (docs)");
    const auto path = incoming.target.name.empty() ? std::string_view("index.html") : incoming.target.name;
    auto file = documents_->open(path, config_.max_body);
    if (!file) return tl::unexpected(file.error());
    auto lease = pool_.memory().reserve(file->size());
    if (!lease) return busy(503, "no memory is left for the document", std::chrono::seconds(1));
    auto content = file->read();
    if (!content) return tl::unexpected(content.error());
    Response response = document_response(path, *std::move(content), incoming.request.header("If-None-Match"));
    response.lease = std::make_shared<MemoryBudget::Lease>(*std::move(lease));
    return response;
}

HttpResult<Response> Routes::capabilities(const Incoming& /*incoming*/) {
    return json_response(api::capabilities_json(config_.limits, offered_pictures(config_), documents_.has_value(),
                                                {live()->presets.names(), config_.presets_only}));
}

HttpResult<Response> Routes::live(const Incoming& /*incoming*/) {
    return json_response(R"({"status":"live"})");
}

HttpResult<Response> Routes::ready(const Incoming& /*incoming*/) {
    if (draining_) return computing_.busy(503, "the server is shutting down");
    if (auto obstacle = obstacle_(); !obstacle.empty()) return computing_.busy(503, std::move(obstacle));
    const WorkerPool::Load load = pool_.load();
    if (load.overdue_seconds > kMaxOverdueSeconds)
        return computing_.busy(503, "a worker has not stopped after a request to stop");
    if (load.backlog_seconds > std::chrono::duration<double>(config_.timeout).count())
        return computing_.busy(503, "waiting requests take longer than the timeout");
    return json_response(R"({"status":"ready"})");
}

HttpResult<Response> Routes::metrics(const Incoming& /*incoming*/) {
    Response response;
    response.media_type = "text/plain; version=0.0.4; charset=utf-8";
    response.body = metrics_.text(pool_.load());
    return response;
}

HttpResult<Response> Routes::job_status(const Incoming& incoming) {
    return job_routes_.status(std::string(incoming.target.name), incoming.connection);
}

HttpResult<Response> Routes::job_result(const Incoming& incoming) {
    return job_routes_.result(std::string(incoming.target.name), incoming.request, incoming.connection);
}

HttpResult<Response> Routes::tile_document(const Incoming& incoming) {
    return tile_routes_.document(std::string(incoming.target.name), incoming.request, incoming.connection);
}

HttpResult<Response> Routes::tile(const Incoming& incoming) {
    return tile_routes_.tile(incoming.target.name, incoming.request, incoming.connection);
}

HttpResult<Response> Routes::job_events(const Incoming& incoming) {
    return job_routes_.events(std::string(incoming.target.name), incoming.connection);
}

HttpResult<Response> Routes::remove_job(const Incoming& incoming) {
    return job_routes_.remove(std::string(incoming.target.name), incoming.connection);
}

/// Answers OPTIONS requests, including CORS preflights.
Response Routes::preflight(std::string_view allow, const Request& request) const {
    Response response;
    response.status = 204;
    response.headers.push_back({"Allow", std::string(allow)});
    if (!live()->cors_origins.empty() && !request.header("Access-Control-Request-Method").empty())
        std::ranges::move(preflight_headers(allow), std::back_inserter(response.headers));
    return response;
}

std::string Routes::request_id(const Request& request) {
    const auto given = request.header("X-Request-ID");
    if (api::is_plain_name(given, kMaxIdLength)) return std::string(given);
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

/// Compresses a text if the client accepts gzip and no worker has compressed it.
void Routes::negotiate_coding(const Request& request, Response& response) {
    if (response.status == 206) return;  // a part of the text without a coding
    const bool done = !response.coding.empty();
    const bool is_not_modified = response.status == 304;  // has the same headers as the full answer
    const bool streamed =
        response.stream && !response.length && is_compressible(response.media_type);  // a worker compresses it
    if (!done && !is_not_modified && !streamed && !is_worth_compressing(response.media_type, response.body)) return;
    response.headers.push_back({"Vary", "Accept-Encoding"});
    if (!done && !is_not_modified && !streamed && response.body.size() <= kMaxQuicklyCompressed &&
        accepts_gzip(request.header("Accept-Encoding"))) {
        response.body = *gzip(response.body);
        response.coding = "gzip";
    }
    if (!response.coding.empty()) response.headers.push_back({"Content-Encoding", response.coding});
}

/// Logs a warning at the first refusal of a page of another origin. The warning names the flag that would allow the
/// origin, because browsers do not show the reason.
void Routes::warn_of_refused_origin(const Request& request) {
    const auto origin = request.header("Origin").substr(0, kMaxOriginLength);
    if (!asks_for_other_origin(request) || allows_origin(live()->cors_origins, origin)) return;
    if (warned_of_origins_.exchange(true)) return;
    warn_("a page of " + std::string(origin) + " may not call this server; --cors-origin " + std::string(origin) +
          " would allow it. Further refusals of origins are not logged");
}

void Routes::add_common_headers(const Request& request, Response& response) const {
    response.headers.push_back({"X-Request-ID", response.record.request_id});
    response.headers.push_back({"Server-Timing", server_timing(response.record.stages)});
    std::ranges::move(cors_headers(live()->cors_origins, request.header("Origin")),
                      std::back_inserter(response.headers));
}

}  // namespace ccdt::server
