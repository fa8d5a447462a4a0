#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "server/access/gate.h"
#include "server/config/config.h"
#include "server/http/connection.h"
#include "server/http/message.h"
#include "server/http/problem.h"
#include "server/jobs/jobs.h"
#include "server/monitoring/metrics.h"
#include "server/pictures/picture_folder.h"
#include "server/routes/computing.h"
#include "server/routes/incoming.h"
#include "server/routes/job_routes.h"
#include "server/work/memory_budget.h"
#include "server/work/worker_pool.h"

namespace ccdt::server {

/// Maps paths and methods to what answers them. May be used from any thread.
class Routes {
public:
    /// Tells what is missing to compute now, in words; empty: nothing.
    using Missing = std::function<std::string()>;

    /// Parts that answer requests. All of them must outlive the routes.
    struct Parts {
        Gate& gate;
        WorkerPool& pool;
        MemoryBudget& waiting_memory;  ///< that requests take until they are done, besides what jobs of the pool take
        Compute compute;
        Jobs& jobs;
        const Metrics& metrics;
        Missing missing;
        std::function<void(const std::string&)> warn;  ///< whoever runs the server, in words
        RedisClient* answers = nullptr;                ///< where servers share answers; null: none
        ReadShapefile read_shapefile = {};
    };

    Routes(const Config& config, Parts parts);

    /// Answers anything that came over a connection; what was not to be received is told so.
    Response answer(const Request& request, const HttpResult<void>& received, Connection& connection);

    const ResultCache& cache() const { return computing_.cache(); }

    /// Refuses to compute anything new from now on.
    void drain() {
        draining_ = true;
        computing_.drain();
    }

    /// Stops waiting: whoever waits for a result is told that the server shuts down, from now on.
    void abandon() { computing_.abandon(); }

private:
    using Handler = HttpResult<Response> (Routes::*)(const Incoming&);

    /// Rule for who is answered although there are API keys.
    enum class Entrance {
        Key,        ///< who shows one, and asks no more often than the rate allows
        Signature,  ///< who has a signed URL where there are signing keys: what embeds a picture sends no key
        Read,       ///< who wants to GET, always: a browser that opens the page sends no key
        Anyone      ///< always: balancers send no keys with health checks
    };

    /// A row of the table of all that is answered; no column has a default.
    struct Route {
        std::string_view path;    ///< a placeholder such as `{id}` stands for anything without a slash
        std::string_view method;  ///< of GET, HEAD as well
        Room room;                ///< in which a connection needs its place
        Entrance entrance;
        Handler handler;
        const Operation* operation;  ///< that the handler computes; null: none
    };
    struct Table;

    /// The row of a path, and what else it names.
    struct Found {
        const Route* route = nullptr;
        Target target;
    };
    static Found find(const Request& request);
    static std::string allowed_methods(const Route& route);
    static Gate::Credential needed(const Found& found, const Request& request);

    HttpResult<void> admit(const Found& found, const Request& request, Connection& connection, Record& record);
    HttpResult<Response> dispatch(const Route* route, const Incoming& incoming);
    HttpResult<Response> compute(const Incoming& incoming);
    HttpResult<Response> picture(const Incoming& incoming);
    HttpResult<Response> page(const Incoming& incoming);
    HttpResult<Response> capabilities(const Incoming& incoming);
    HttpResult<Response> live(const Incoming& incoming);
    HttpResult<Response> ready(const Incoming& incoming);
    HttpResult<Response> metrics(const Incoming& incoming);
    HttpResult<Response> job_status(const Incoming& incoming);
    HttpResult<Response> job_result(const Incoming& incoming);
    HttpResult<Response> job_events(const Incoming& incoming);
    HttpResult<Response> remove_job(const Incoming& incoming);

    Response preflight(std::string_view allow, const Request& request) const;

    std::string request_id(const Request& request);
    static Response describe(Problem problem, Record& record);
    static void negotiate_coding(const Request& request, Response& response);
    HttpResult<void> check_host(const Found& found, const Request& request);
    void warn_of_refused_origin(const Request& request);
    void add_common_headers(const Request& request, Response& response) const;

    const Config config_;
    Gate& gate_;
    WorkerPool& pool_;
    const Metrics& metrics_;
    const Missing missing_;
    const std::function<void(const std::string&)> warn_;
    Computing computing_;
    const std::optional<PictureFolder> pictures_;  ///< none: no pictures are asked for by name
    JobRoutes job_routes_;
    std::atomic<bool> draining_ = false;
    std::atomic<bool> warned_of_origins_ = false;
    std::atomic<bool> warned_of_hosts_ = false;
    std::atomic<std::uint64_t> requests_ = 0;
    const std::string id_prefix_;  ///< differs between processes
};

}  // namespace ccdt::server
