#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/analyze.h"
#include "api/halftone.h"
#include "api/image/image_codec.h"
#include "api/options.h"
#include "api/sample.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"
#include "server/config.h"
#include "server/http/connection.h"
#include "server/http/http.h"
#include "server/metrics.h"
#include "server/work/memory_budget.h"
#include "server/work/worker_pool.h"

namespace ccdt::server {

/// Status that an error of the libraries below is answered with.
int http_status(ErrorCode code);

/// Maps paths and methods to what answers them. May be used from any thread.
class Routes {
public:
    /// The pool and the metrics must outlive the routes, and so must what `decode` refers to. Requests may take a third
    /// of the memory that the pool has for jobs, besides that.
    Routes(const Config& config, WorkerPool& pool, const Metrics& metrics, api::Decode decode);

    /// Answers anything that came over a connection; a fault is answered as what it says.
    Response answer(const Request& request, const std::optional<Fault>& fault, Connection& connection);

    /// That requests hold until they are done, besides what the pool's jobs take.
    const MemoryBudget& waiting_memory() const { return waiting_memory_; }

    /// From now on nothing new is computed.
    void drain() { draining_ = true; }

    /// From now on nothing is waited for: whoever waits for a result is told that the server shuts down.
    void abandon() { abandoned_ = true; }

private:
    /// Why a request is not answered as it wished.
    struct Problem {
        int status = 500;
        Error error;
        std::vector<Header> headers;
        Stages stages;
        bool deliver = true;
        std::string_view cancelled = {};
    };
    using Outcome = tl::expected<Response, Problem>;
    using Handler = Outcome (Routes::*)(const Request&, Connection&);

    struct Route {
        std::string_view path;
        std::string_view method;
        std::string_view allow;
        Handler handler;
    };
    static const Route kRoutes[];

    using Clock = std::chrono::steady_clock;

    /// What a worker does.
    template <class T>
    using Job = std::function<Result<T>(const Control&, api::Timings&)>;
    using Work = Job<api::Answer>;

    /// A request that is understood.
    struct Plan {
        api::Cost cost;
        std::size_t size = 0;  ///< bytes that it holds
        Work work;
    };

    /// Understands a JSON body, for a client that accepts certain types.
    using Parse = std::function<Result<Plan>(std::string_view body, std::string_view accept)>;

    struct Product;

    static tl::unexpected<Problem> problem(int status, std::string message, std::string field = {});
    static tl::unexpected<Problem> problem(Error error);
    static tl::unexpected<Problem> problem(Fault fault);

    static const Route* find_route(std::string_view path);
    Outcome dispatch(const Route* route, const Request& request, Connection& connection);
    Outcome halftone(const Request& request, Connection& connection);
    Outcome sample(const Request& request, Connection& connection);
    Outcome analyze(const Request& request, Connection& connection);
    Outcome page(const Request& request, Connection& connection);
    Outcome live(const Request& request, Connection& connection);
    Outcome ready(const Request& request, Connection& connection);
    Outcome metrics(const Request& request, Connection& connection);

    Response preflight(std::string_view allow, const Request& request) const;
    tl::unexpected<Problem> busy(int status, std::string message) const;
    tl::unexpected<Problem> too_slow() const;
    tl::unexpected<Problem> too_large(std::size_t bytes) const;
    tl::expected<std::string, Problem> read_body(const Request& request, Connection& connection) const;
    static tl::expected<std::string, Problem> read_form(std::string body, std::string_view content_type,
                                                        std::vector<api::TextOption>& options);
    template <class Parsed, class Run>
    static Plan plan_for(Parsed request, const api::Cost& cost, Run run);
    Plan plan(api::HalftoneRequest request) const;
    Plan plan(api::SampleRequest request) const;
    static Plan plan(api::AnalyzeRequest request);
    static Work compressing(Work work);
    template <class T>
    tl::expected<T, Problem> have_done(const api::Cost& cost, std::size_t held, Job<T> work, Connection& connection,
                                       Clock::time_point deadline, Stages& stages);
    Outcome compute(Plan plan, const Request& request, Connection& connection, Clock::time_point deadline,
                    double waited = 0);
    Outcome compute_json(const Parse& parse, const Request& request, Connection& connection);
    Outcome compute_json(const Parse& parse, std::string body, const Request& request, Connection& connection);

    std::string request_id(const Request& request);
    Response describe(Problem problem, const std::string& id) const;
    static void negotiate_coding(const Request& request, Response& response);
    void add_common_headers(const Request& request, Response& response) const;

    const Config config_;
    WorkerPool& pool_;
    const Metrics& metrics_;
    const api::Decode decode_;
    MemoryBudget waiting_memory_;  ///< of requests; apart, lest those that wait leave nothing to those that run
    std::atomic<bool> draining_ = false;
    std::atomic<bool> abandoned_ = false;
    std::atomic<std::uint64_t> requests_ = 0;
    const std::string id_prefix_;  ///< differs between processes
};

}  // namespace ccdt::server
