// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "server/access/access_control.h"
#include "server/config/config.h"
#include "server/files/file_folder.h"
#include "server/http/connection.h"
#include "server/http/message.h"
#include "server/http/problem.h"
#include "server/jobs/job_service.h"
#include "server/monitoring/metrics.h"
#include "server/pool/memory_budget.h"
#include "server/pool/worker_pool.h"
#include "server/routes/compute_routes.h"
#include "server/routes/incoming.h"
#include "server/routes/job_routes.h"
#include "server/routes/tile_routes.h"

namespace ccdt::server {

/// Answers requests by the handler of their path and method. Thread-safe.
class Routes {
public:
    /// Returns the reason why the server cannot compute now; empty if it can.
    using Obstacle = std::function<std::string()>;

    /// Parts of the server that handlers use. They must outlive the routes.
    struct Parts {
        AccessControl& access_control;
        WorkerPool& pool;
        MemoryBudget& waiting_memory;  ///< see Computing
        Compute compute;
        JobService& jobs;
        const Metrics& metrics;
        Obstacle obstacle;
        std::function<void(const std::string&)> warn;  ///< logs a warning
        RedisClient* answers = nullptr;                ///< Redis in which servers share answers; null: none
        ReadShapefile read_shapefile = {};
    };

    Routes(const Config& config, Parts parts);

    /// The port at which a request arrived.
    enum class Port {
        Common,   ///< all paths, except /metrics if it has a port of its own
        Metrics,  ///< /metrics, without a key, and health checks
    };

    /// Answers a request. If `received` is a problem, the answer reports the problem.
    Response answer(const Request& request, const HttpResult<void>& received, Connection& connection,
                    Port port = Port::Common);

    /// Applies new values of settings to later requests.
    void reload(const LiveConfig& live);

    const ResultCache& cache() const { return computing_.cache(); }

    /// Begins the shutdown: from now on, reports that the server is not ready, and refuses computations (see
    /// ComputeRoutes::drain).
    void drain() {
        draining_ = true;
        computing_.drain();
    }

    /// Tells all waiting clients, also those of later requests, that the server is shutting down.
    void abandon() { computing_.abandon(); }

private:
    using Handler = HttpResult<Response> (Routes::*)(const Incoming&);

    /// Credential that a request needs if there are API keys.
    enum class Access {
        ApiKey,     ///< an API key; the rate is limited
        Signature,  ///< for <img>: a signed URL if there are signing keys, otherwise an API key
        Read,       ///< none for GET and HEAD, because browsers open the page without a key; otherwise a key
        Anyone      ///< none, because load balancers send health checks without keys
    };

    /// A row of the table of routes; no column has a default.
    struct Route {
        std::string_view path;             ///< `{path}` matches any text, other placeholders texts without slashes
        std::string_view method;           ///< GET includes HEAD
        ConnectionClass connection_class;  ///< class of the slot that the connection needs
        Access access;
        Handler handler;
        const Operation* operation;  ///< operation for the handler; null: none
    };
    struct Table;

    /// The route of a path, and the variable parts of the path.
    struct Found {
        const Route* route = nullptr;
        Target target;
    };
    static Found find(const Request& request);
    bool is_offered(const Route& route, Port port) const;
    static std::string allowed_methods(const Route& route);
    static AccessControl::Credential required_credential(const Found& found, const Request& request, Port port);

    HttpResult<void> admit(const Found& found, const Request& request, Port port, Connection& connection,
                           Record& record);
    HttpResult<Response> dispatch(const Route* route, const Incoming& incoming);
    HttpResult<Response> compute(const Incoming& incoming);
    HttpResult<Response> picture(const Incoming& incoming);
    HttpResult<Response> page(const Incoming& incoming);
    HttpResult<Response> document(const Incoming& incoming);
    HttpResult<Response> capabilities(const Incoming& incoming);
    HttpResult<Response> live(const Incoming& incoming);
    HttpResult<Response> ready(const Incoming& incoming);
    HttpResult<Response> metrics(const Incoming& incoming);
    HttpResult<Response> job_status(const Incoming& incoming);
    HttpResult<Response> job_result(const Incoming& incoming);
    HttpResult<Response> job_events(const Incoming& incoming);
    HttpResult<Response> remove_job(const Incoming& incoming);
    HttpResult<Response> tile_document(const Incoming& incoming);
    HttpResult<Response> tile(const Incoming& incoming);

    Response preflight(std::string_view allow, const Request& request) const;

    std::shared_ptr<const LiveConfig> live() const;
    std::string request_id(const Request& request);
    static Response describe(Problem problem, Record& record);
    static void negotiate_coding(const Request& request, Response& response);
    HttpResult<void> check_host(const Found& found, const Request& request, Port port);
    void warn_of_refused_origin(const Request& request);
    void add_common_headers(const Request& request, Response& response) const;

    const Config config_;
    AccessControl& access_control_;
    WorkerPool& pool_;
    const Metrics& metrics_;
    const Obstacle obstacle_;
    const std::function<void(const std::string&)> warn_;
    ComputeRoutes computing_;
    const std::optional<FileFolder> pictures_;   ///< none: GET /halftone/{name} is disabled
    const std::optional<FileFolder> documents_;  ///< none: GET /docs/{path} is disabled
    ResultReader results_;
    JobRoutes job_routes_;
    TileRoutes tile_routes_;
    std::atomic<bool> draining_ = false;
    std::atomic<bool> warned_of_origins_ = false;
    std::atomic<bool> warned_of_hosts_ = false;
    std::atomic<std::uint64_t> requests_ = 0;
    const std::string id_prefix_;  ///< prefix of request ids; differs between processes

    mutable std::mutex mutex_;  ///< guards the live settings
    std::shared_ptr<const LiveConfig> live_;
};

}  // namespace ccdt::server
