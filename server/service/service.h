#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "core/result.h"
#include "server/access/gate.h"
#include "server/compute/compute_box.h"
#include "server/config/config.h"
#include "server/config/memory_plan.h"
#include "server/decoder/decoder_box.h"
#include "server/decoder/decoder_client.h"
#include "server/http/http_server.h"
#include "server/http/sockets.h"
#include "server/jobs/job_store.h"
#include "server/jobs/jobs.h"
#include "server/monitoring/log.h"
#include "server/monitoring/metrics.h"
#include "server/redis/redis_client.h"
#include "server/routes/routes.h"
#include "server/work/memory_budget.h"
#include "server/work/worker_pool.h"

namespace ccdt::server {

/// All parts of the server, which are there from its start to its end.
class Service {
public:
    /// Starts the parts in the order in which they need each other: the process that starts decoders, that which starts
    /// those that compute, the keys, memory, the store of jobs, the port, and the jobs that the store has from before.
    /// The two processes get ready meanwhile, and longer. Clients that connect wait until `serve` is called.
    ///
    /// @param log  outlives the service
    /// Errors: those of the parts, of which those before have ended then.
    static Result<std::unique_ptr<Service>> start(const Config& config, const Log& log);

    Service(const Service&) = delete;
    Service& operator=(const Service&) = delete;

    /// Waits until the programs that decode and compute are ready, for which requests wait meanwhile, and logs how the
    /// former is confined. Errors: Internal; nothing will be decoded or computed.
    Result<void> wait_until_ready() const;

    /// The place where it listens: a URL, or `unix:` and a path.
    std::string address() const;

    /// Reads the files of keys again. After an error they are what they were.
    Result<void> read_keys() { return parts_.gate->read_keys(); }

    /// Serves until `drain`; returns once all that was accepted is answered.
    /// @returns  false if accepting failed for any other reason
    bool serve() { return server_.serve(); }

    /// Has nothing new accepted or computed. From any thread.
    void drain();

    /// Has nothing waited for any more: whoever waits for a result is told that the server shuts down.
    void abandon() { routes_.abandon(); }

    /// Returns once nothing is computed any more. To be called after `serve` has returned.
    void finish() { pool_.drain(); }

private:
    /// What Redis is used for, each by choice; null: it is not.
    struct RedisClients {
        std::unique_ptr<RedisClient> jobs;
        std::unique_ptr<RedisClient> answers;
        std::unique_ptr<RedisClient> rates;
    };

    /// Parts that may fail to start; Redis, which others use, first.
    struct Parts {
        RedisClients redis;
        std::unique_ptr<DecoderBox> decoder;
        std::unique_ptr<Gate> gate;
        ComputeMemory memory;
        std::unique_ptr<JobStore> store;
        std::unique_ptr<ComputeBox> computing;
        ListeningSocket listener;
    };

    static Result<Parts> start_parts(const Config& config, const Log& log);
    Service(const Config& config, Parts parts, const Log& log);

    std::string missing() const;
    Metrics::Watched figures() const;

    const Config config_;
    const Log& log_;
    Parts parts_;
    const int port_;
    MemoryBudget waiting_memory_;
    WorkerPool pool_;
    Metrics metrics_;
    Jobs jobs_;
    DecoderClient decoding_;  ///< of shapefiles, which the server itself has decoded
    Routes routes_;
    HttpServer server_;
};

}  // namespace ccdt::server
