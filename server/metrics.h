#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "server/capacity.h"
#include "server/http_server.h"
#include "server/worker_pool.h"

namespace ccdt::server {

/// Figures about the service for Prometheus. May be used from any thread.
class Metrics {
public:
    explicit Metrics(std::string_view version);
    ~Metrics();

    Metrics(const Metrics&) = delete;
    Metrics& operator=(const Metrics&) = delete;

    /// Has figures of connections taken from there. To be called before any thread asks for figures.
    void watch(std::function<Capacity::Counts()> connections);

    /// A request that was answered, or whose client left.
    void add(const Exchange& exchange);

    /// All figures in Prometheus' text format, the pool's as they are now.
    std::string text(const WorkerPool::Load& load) const;

private:
    struct Families;
    const std::unique_ptr<Families> families_;
    std::function<Capacity::Counts()> connections_ = [] { return Capacity::Counts{}; };
};

}  // namespace ccdt::server
