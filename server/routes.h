#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/image_codec.h"
#include "api/options.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"
#include "server/config.h"
#include "server/connection.h"
#include "server/http.h"
#include "server/metrics.h"
#include "server/worker_pool.h"

namespace ccdt::server {

/// Status that an error of the libraries below is answered with.
int http_status(ErrorCode code);

/// Maps paths and methods to what answers them. May be used from any thread.
class Routes {
public:
    /// The pool and the metrics must outlive the routes, and so must what `decode` refers to.
    Routes(const Config& config, WorkerPool& pool, const Metrics& metrics, api::Decode decode);

    /// Answers anything that came over a connection; a fault is answered as what it says.
    Response answer(const Request& request, const std::optional<Fault>& fault, Connection& connection);

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

    /// What a worker does for a request.
    using Work = std::function<Result<api::Answer>(const Control&, api::Timings&)>;

    /// The same, from a JSON body and what the client accepts.
    using JsonWork =
        std::function<Result<api::Answer>(const std::string&, std::string_view, const Control&, api::Timings&)>;

    static tl::unexpected<Problem> problem(int status, std::string message, std::string field = {});
    static tl::unexpected<Problem> problem(Error error);
    static tl::unexpected<Problem> problem(Fault fault);

    static std::string_view route_of(const Request& request);
    Outcome dispatch(const Request& request, Connection& connection);
    Outcome halftone(const Request& request, Connection& connection);
    Outcome sample(const Request& request, Connection& connection);
    Outcome analyze(const Request& request, Connection& connection);
    Outcome live(const Request& request, Connection& connection);
    Outcome ready(const Request& request, Connection& connection);
    Outcome metrics(const Request& request, Connection& connection);

    Response preflight(std::string_view allow, const Request& request) const;
    tl::unexpected<Problem> busy(int status, std::string message) const;
    tl::unexpected<Problem> too_slow() const;
    tl::expected<std::string, Problem> read_body(const Request& request, Connection& connection) const;
    static tl::expected<std::string, Problem> read_form(std::string body, std::string_view content_type,
                                                        std::vector<api::TextOption>& options);
    Outcome compute(Work work, Connection& connection);
    Outcome compute_json(JsonWork work, const Request& request, Connection& connection);

    std::string request_id(const Request& request);
    Response describe(Problem problem, const std::string& id) const;
    static void negotiate_coding(const Request& request, Response& response);
    void add_common_headers(const Request& request, Response& response) const;

    const Config config_;
    WorkerPool& pool_;
    const Metrics& metrics_;
    const api::Decode decode_;
    std::atomic<bool> draining_ = false;
    std::atomic<bool> abandoned_ = false;
    std::atomic<std::uint64_t> requests_ = 0;
    const std::string id_prefix_;  ///< differs between processes
};

}  // namespace ccdt::server
