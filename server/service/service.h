// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "server/access/access_control.h"
#include "server/compute/compute_supervisor.h"
#include "server/config/config.h"
#include "server/config/memory_plan.h"
#include "server/decoder/decoder_client.h"
#include "server/decoder/decoder_supervisor.h"
#include "server/http/http_server.h"
#include "server/http/sockets.h"
#include "server/jobs/job_service.h"
#include "server/jobs/job_store.h"
#include "server/monitoring/log.h"
#include "server/monitoring/metrics.h"
#include "server/pool/memory_budget.h"
#include "server/pool/worker_pool.h"
#include "server/redis/redis_client.h"
#include "server/routes/routes.h"
#include "server/webhooks/webhooks.h"

namespace ccdt::server {

/// Owns all parts of the server, and starts and ends them.
class Service {
public:
    /// Starts all parts: decoder, fork server, Redis clients, keys, job store, listening socket, and finally the stored
    /// jobs. The decoder and the fork server take longest and get ready in the background. Clients that connect wait
    /// until `serve` is called.
    ///
    /// @param log  must outlive the service
    /// Errors: those of the parts. After an error, no part runs.
    static Result<std::unique_ptr<Service>> start(const Config& config, const Log& log);

    Service(const Service&) = delete;
    Service& operator=(const Service&) = delete;

    /// Waits until the programs that decode and compute are ready, and logs the confinement of decoders. Requests that
    /// need these programs wait meanwhile.
    /// Errors: Internal if a program did not become ready; Stopped.
    Result<void> wait_until_ready(const std::stop_token& stop) const;

    /// Returns the listening address: a URL, or `unix:PATH`.
    std::string address() const;

    /// The URL of the metrics; empty if they have no port of their own.
    std::string metrics_address() const;

    /// Applies new values of settings, and reloads the key files. An error changes nothing.
    Result<void> reload(const LiveConfig& live);

    /// Serves until `drain` is called. Returns once all accepted requests are answered.
    /// @returns  false if accepting connections failed permanently
    bool serve();

    /// Begins the shutdown: refuses new connections and new computations. May be called from any thread.
    void drain();

    /// Tells all waiting clients that the server is shutting down.
    void abandon() { routes_.abandon(); }

    /// Waits until no computation runs. Must be called after `serve` has returned.
    void finish() { pool_.drain(); }

private:
    /// Redis clients by purpose; null: not used.
    struct RedisClients {
        std::unique_ptr<RedisClient> jobs;
        std::unique_ptr<RedisClient> answers;
        std::unique_ptr<RedisClient> rates;
    };

    /// Parts whose start may fail. Redis comes first, because other parts use it.
    struct Parts {
        RedisClients redis;
        std::unique_ptr<DecoderSupervisor> decoder;
        std::unique_ptr<AccessControl> access_control;
        ComputeMemory memory;
        std::unique_ptr<JobStore> store;
        std::unique_ptr<Webhooks> webhooks;  ///< null: none are sent
        std::unique_ptr<ComputeSupervisor> computing;
        ListeningSocket listener;
        std::optional<ListeningSocket> metrics_listener;  ///< none: the metrics have no port of their own
    };

    static Result<Parts> start_parts(const Config& config, const Log& log);
    Service(const Config& config, Parts parts, const Log& log);

    Result<std::string> read_shapefile(std::string_view archive, const api::ShapefileReading& reading,
                                       const std::stop_token& stop, api::Timings& timings);
    void record(const Exchange& exchange);
    std::string obstacle() const;
    Metrics::Watched figures() const;

    const Config config_;
    const Log& log_;
    Parts parts_;
    const int port_;
    const int metrics_port_;  ///< 0: none
    MemoryBudget waiting_memory_;
    WorkerPool pool_;
    Metrics metrics_;
    JobService jobs_;
    std::atomic<std::uint64_t> shapefile_deaths_ = 0;  ///< see DecoderClient::deaths()
    Routes routes_;
    HttpServer server_;
    std::optional<HttpServer> metrics_server_;
};

}  // namespace ccdt::server
