// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/routes/compute_routes.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "server/decoder/shapefile_cost.h"
#include "server/fetch/fetch.h"
#include "server/http/compression.h"
#include "server/http/entity_tag.h"
#include "server/http/http_client.h"
#include "server/http/trace.h"
#include "server/pool/body_pipe.h"
#include "server/requests/answer_headers.h"
#include "server/requests/answer_name.h"
#include "server/requests/convergence.h"
#include "server/requests/form.h"
#include "server/routes/job_routes.h"

namespace ccdt::server {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

/// Interval at which the thread of a connection checks whether the client still waits.
constexpr std::chrono::milliseconds kPollInterval{20};

/// Time after the deadline in which a stopped computation may still return a partial answer.
constexpr std::chrono::seconds kGrace{2};

/// Content type of pictures from the folder of pictures. It prevents parsing as JSON or as a form.
constexpr const char* kPicture = "image/*";

/// Maximum number of pictures that are fetched at the same time. Each one needs a process.
constexpr int kMaxFetches = 16;

/// Size of a body, in bytes, above which a request is never a short job.
constexpr std::size_t kLongBody = 65'536;

/// Returns the key of an answer in the cache. Compressed answers have different keys, and are stored compressed.
///
/// @param owner  API key that may get the answer; empty: all
std::string cache_key(const std::string& name, bool compressed, const std::string& owner) {
    return (compressed ? name + "-gzip " : name + ' ') + owner;
}

/// Finds the tag of an answer among the tags in If-None-Match.
std::optional<std::string_view> known_tag(const Incoming& incoming, const std::string& name) {
    return find_tag(incoming.request.header("If-None-Match"), name);
}

/// Whether a header is a Content-Encoding other than `identity`.
bool is_encoding(const Header& header) {
    return equals_ignoring_case(header.name, "Content-Encoding") && !header.value.empty() &&
           !equals_ignoring_case(header.value, "identity");
}

/// Records why a computation was cancelled, and returns the problem for the client.
tl::unexpected<Problem> cancelled(tl::unexpected<Problem> why, std::string_view cause, Record& record) {
    record.cancelled = cause;
    return why;
}

/// Adds the stages of another part of the same request to a record.
void add_stages(const Stages& more, Record& record) {
    auto& [queue, work] = record.stages;
    queue += more.queue;
    work.decode += more.work.decode;
    work.prepare += more.work.prepare;
    work.optimise += more.work.optimise;
    work.encode += more.work.encode;
    work.processor += more.work.processor;
    work.threads = std::max(work.threads, more.work.threads);
}

/// Converts an answer to a response.
/// @param name  name of the answer; becomes its tag, unless the answer is partial
Response response_of(api::Answer answer, const std::string& name, Record& record) {
    Response response;
    response.headers = answer_headers(answer);
    response.media_type = std::move(answer.media_type);
    response.body = std::move(answer.body);
    response.coding = std::move(answer.coding);
    if (answer.partial) {
        response.headers.push_back({"X-Partial", "deadline"});
        record.cancelled = "deadline";
    } else {
        response.tag = (answer.repeats ? "\"" : "W/\"") + name + '"';
    }
    return response;
}

}  // namespace

/// A request with its memory reservation. Shared with the worker, which may need it after the connection has ended.
struct ComputeRoutes::AcceptedRequest {
    const Operation& operation;
    ComputeRequest request;
    std::string name;  ///< name of the answer
    MemoryBudget::Lease lease;
};

/// An answer, and the memory reservation of its computation.
struct ComputeRoutes::ComputedAnswer {
    api::Answer answer;
    MemoryBudget::Lease lease;
    Progress last;                        ///< last progress of the computation
    std::shared_ptr<BodyPipe> pipe = {};  ///< delivers the body if it is still being computed; null: it is complete
};

/// A future result that a worker passes to the thread of a connection. The connection may end before the result
/// arrives.
template <class T>
class ComputeRoutes::PendingResult {
public:
    void begin() {
        const std::lock_guard lock(mutex_);
        stages_.queue = Milliseconds(Clock::now() - submitted_).count();
    }

    /// Sets the result. Only the first call has an effect, and none after displace().
    /// @returns  whether the call had an effect
    bool finish(Result<T> result, const api::Timings& timings) {
        const std::lock_guard lock(mutex_);
        if (std::exchange(finished_already_, true)) return false;
        stages_.work = timings;
        result_ = std::move(result);
        finished_.notify_all();
        return true;
    }

    /// Ends the wait without a result, unless a result was set: see WorkerPool::Displace.
    bool displace() {
        {
            const std::lock_guard lock(mutex_);
            if (std::exchange(finished_already_, true)) return false;
            displaced_ = true;
            finished_.notify_all();
        }
        abandon();
        return true;
    }

    bool is_displaced() const {
        const std::lock_guard lock(mutex_);
        return displaced_;
    }

    /// Waits for the result; returns whether it has arrived or the task was displaced.
    bool wait_until(Clock::time_point time) {
        std::unique_lock lock(mutex_);
        return finished_.wait_until(lock, time, [this] { return result_.has_value() || displaced_; });
    }

    Result<T> take_result() {
        const std::lock_guard lock(mutex_);
        return std::move(*result_);
    }

    Stages stages() const {
        const std::lock_guard lock(mutex_);
        return stages_;
    }

    /// Tells the computation that the result is no longer needed.
    void abandon() { unwanted_.request_stop(); }
    std::stop_token unwanted() const { return unwanted_.get_token(); }

private:
    const Clock::time_point submitted_ = Clock::now();
    std::stop_source unwanted_;

    mutable std::mutex mutex_;  ///< guards the members below
    std::condition_variable finished_;
    std::optional<Result<T>> result_;
    bool finished_already_ = false;  ///< a result was set, and may have been taken, or the task was displaced
    bool displaced_ = false;
    Stages stages_;
};

/// Passes a large body from its computation to the connection. Copies the body for the cache, unless it is too large.
class ComputeRoutes::TeeWriter : public api::BodySink {
public:
    /// @param last     last progress of the computation, which must not change once the body has begun
    /// @param largest  maximum size of cached bodies, in bytes
    TeeWriter(PendingResult<ComputedAnswer>& pending, const api::Timings& timings, const Progress& last,
              std::size_t largest, MemoryBudget& memory)
        : pending_(pending), timings_(timings), last_(last), largest_(largest), memory_(memory) {}
    ~TeeWriter() override { close(failure(ErrorCode::Internal, "the answer was not written completely")); }
    TeeWriter(const TeeWriter&) = delete;
    TeeWriter& operator=(const TeeWriter&) = delete;

    Result<void> begin(const api::Answer& head) override {
        if (!pending_.finish(ComputedAnswer{head, {}, last_, pipe_}, timings_))
            return failure(ErrorCode::Stopped, "the computation is repeated later");
        copy_ = head;
        return {};
    }

    Result<void> write(std::string_view piece) override {
        if (copy_ && copy_->body.size() + piece.size() <= largest_) {
            copy_->body += piece;
        } else {
            copy_.reset();
        }
        return pipe_->push(piece);
    }

    /// Ends the body. After an error, the body is incomplete.
    void close(Result<void> outcome) { pipe_->close(std::move(outcome), timings_, memory_); }

    /// Returns the source that stops the computation when the connection abandons the body.
    std::stop_source& stop() { return pipe_->stop(); }

    /// Returns the whole answer after the end of the body; null if it is too large for the cache.
    const api::Answer* copy() const { return copy_ ? &*copy_ : nullptr; }

private:
    PendingResult<ComputedAnswer>& pending_;
    const api::Timings& timings_;
    const Progress& last_;
    const std::size_t largest_;
    MemoryBudget& memory_;
    const std::shared_ptr<BodyPipe> pipe_ = std::make_shared<BodyPipe>();
    std::optional<api::Answer> copy_;
};

ComputeRoutes::ComputeRoutes(const Config& config, WorkerPool& pool, MemoryBudget& waiting_memory, Compute compute,
                             ReadShapefile read_shapefile, JobService& jobs, RedisClient* answers)
    : config_(config),
      pool_(pool),
      waiting_memory_(waiting_memory),
      compute_(std::move(compute)),
      read_shapefile_(std::move(read_shapefile)),
      jobs_(jobs),
      cache_(config.cache, answers) {}

HttpResult<Response> ComputeRoutes::answer(const Operation& operation, const Presets& presets,
                                           const Incoming& incoming) {
    const Request& request = incoming.request;
    ComputeRequest to_compute{request.path,
                              request.query,
                              std::string(request.header("Content-Type")),
                              std::string(request.header("Accept")),
                              {}};
    const auto url =
        operation.form_part == "image" ? take_parameter(to_compute.query, "image_url") : std::optional<std::string>();
    if (url) to_compute.content_type = kPicture;
    if (auto checked = check(operation, to_compute); !checked) return problem(std::move(checked.error()));
    const bool deferred = prefers(request, "respond-async");
    const auto callback = find_callback(request);
    if (!callback) return tl::unexpected(callback.error());
    auto body = read_body(incoming, url, deferred);
    if (!body) return tl::unexpected(std::move(body.error()));
    to_compute.body = *std::move(body);
    auto lease = reserve_memory(to_compute.body.size());
    if (!lease) return tl::unexpected(lease.error());
    auto fields = find_fields(to_compute);
    if (!fields) return problem(std::move(fields.error()));
    if (auto expanded = presets.expand(to_compute, *fields, config_.presets_only); !expanded)
        return problem(std::move(expanded.error()));
    const auto accepted = prepare(operation, std::move(to_compute), *fields, *std::move(lease));
    if (!accepted) return tl::unexpected(accepted.error());
    if (!deferred) return respond(*accepted, incoming);
    if (const auto tag = known_tag(incoming, (*accepted)->name)) return not_modified(*tag);
    return defer(*accepted, *callback, incoming);
}

HttpResult<Response> ComputeRoutes::answer(const Operation& operation, const Presets& presets, OpenFile picture,
                                           std::string options, const Incoming& incoming) {
    if (auto checked = check_drain(incoming); !checked) return tl::unexpected(checked.error());
    auto lease = reserve_memory(picture.size());
    if (!lease) return tl::unexpected(lease.error());
    ComputeRequest request{std::string(operation.path), std::move(options), kPicture, {}, {}};
    std::vector<FormPart> no_fields;
    if (auto expanded = presets.expand(request, no_fields, config_.presets_only); !expanded)
        return problem(std::move(expanded.error()));
    auto bytes = picture.read();
    if (!bytes) return tl::unexpected(bytes.error());
    request.body = *std::move(bytes);
    // If the query names the format, ignores Accept, so that all browsers share the cached answer.
    const bool has_format = std::ranges::any_of(parse_query(request.query),
                                                [](const api::TextOption& option) { return option.name == "format"; });
    if (!has_format) request.accept = incoming.request.header("Accept");
    const auto accepted = prepare(operation, std::move(request), no_fields, *std::move(lease));
    if (!accepted) return tl::unexpected(accepted.error());
    return respond(*accepted, incoming);
}

/// Answers with a 304 if the client has the answer, with a cached answer, or with a new one.
HttpResult<Response> ComputeRoutes::respond(const AcceptedPointer& accepted, const Incoming& incoming) {
    if (const auto tag = known_tag(incoming, accepted->name)) return not_modified(*tag);
    const bool compressed = accepts_gzip(incoming.request.header("Accept-Encoding"));
    if (auto response = find_cached(accepted->name, compressed, incoming)) return *std::move(response);
    return compute(accepted, compressed, incoming);
}

HttpResult<Response> ComputeRoutes::compute(const AcceptedPointer& given, bool compressed, const Incoming& incoming) {
    const auto deadline = Clock::now() + config_.timeout;
    const auto converted = convert_shapefile(given, incoming, deadline);
    if (!converted) return tl::unexpected(converted.error());
    const AcceptedPointer& accepted = *converted;
    const auto forecast = this->forecast(accepted, incoming, deadline);
    if (!forecast) return tl::unexpected(forecast.error());
    const TimeLimit limit{deadline, forecast->accepts_partial ? kGrace : Clock::duration()};
    auto product = run(accepted, forecast->cost, compressed, incoming, limit);
    if (!product) return tl::unexpected(std::move(product.error()));
    api::Answer& answer = product->answer;
    if (!product->pipe && !answer.partial)
        cache_.store(cache_key(accepted->name, compressed, cache_owner(incoming.connection)), answer);
    incoming.record.computed = Computed{answer.sites, answer.pixels};
    std::string doubt =
        doubt_about(answer, accepted->request.path, product->last.iteration, product->last.variation.value_or(0));
    Response response = response_of(std::move(answer), accepted->name, incoming.record);
    if (product->pipe) {
        response.stream = stream_of(*product, std::move(doubt), incoming, deadline + kGrace + BodyPipe::kPatience);
    } else {
        incoming.record.cause = std::move(doubt);
    }
    response.lease = std::make_shared<MemoryBudget::Lease>(std::move(product->lease));
    return response;
}

/// Returns the function that sends a large body while it is computed.
/// @param doubt   becomes the cause in the log if the body is complete
/// @param latest  time by which the computation must end
Stream ComputeRoutes::stream_of(const ComputedAnswer& computed, std::string doubt, const Incoming& incoming,
                                Clock::time_point latest) const {
    return [this, pipe = computed.pipe, doubt = std::move(doubt), &connection = incoming.connection, latest](
               const Send& send, Record& record) {
        while (!pipe->is_over()) {
            const auto piece = pipe->pop(Clock::now() + kPollInterval);
            if (piece ? !send(*piece) : connection.client_gone()) {
                record.cancelled = "client_gone";
            } else if (abandoned_) {
                record.cancelled = "shutdown";
            } else if (!piece && Clock::now() > latest) {
                record.cancelled = "deadline";
            } else {
                continue;
            }
            pipe->abandon();
            if (record.cancelled != "client_gone") record.cause = "the answer was not written completely";
            return false;
        }
        record.stages.work = pipe->timings();
        const auto outcome = pipe->outcome();
        record.cause = outcome ? doubt : outcome.error().message;
        return outcome.has_value();
    };
}

/// Returns the owner in cache_key(): the API key or, with --cache-shared, none. Separate answers prevent that response
/// times reveal the requests of other keys.
std::string ComputeRoutes::cache_owner(const Connection& connection) const {
    return config_.cache_shared ? "" : connection.key();
}

/// Returns the cached answer with a name; none if it is not cached or there is no memory to send it.
std::optional<Response> ComputeRoutes::find_cached(const std::string& name, bool compressed, const Incoming& incoming) {
    const auto answer = cache_.find(cache_key(name, compressed, cache_owner(incoming.connection)));
    if (answer == nullptr) return std::nullopt;
    auto lease = pool_.memory().reserve(answer->body.size());
    if (!lease) return std::nullopt;
    incoming.record.cached = true;
    Response response = response_of(*answer, name, incoming.record);
    response.lease = std::make_shared<MemoryBudget::Lease>(*std::move(lease));
    return response;
}

/// Refuses a computation during a shutdown, unless it is for the first request of its connection. The client can retry
/// on a new connection.
HttpResult<void> ComputeRoutes::check_drain(const Incoming& incoming) const {
    if (draining_ && !incoming.connection.is_on_first_request()) return busy(503, "the server is shutting down");
    return {};
}

/// Reads the body of a request. Does not read it if there is a Content-Encoding, a shutdown or a full queue.
/// @param url  URL of the picture that replaces the body; none: the request has a body
HttpResult<std::string> ComputeRoutes::read_body(const Incoming& incoming, const std::optional<std::string>& url,
                                                 bool deferred) {
    const Request& request = incoming.request;
    Connection& connection = incoming.connection;
    if (std::ranges::any_of(request.headers, is_encoding))
        return problem(415, "Content-Encoding is not supported; send the body without encoding");
    if (auto checked = check_drain(incoming); !checked) return tl::unexpected(checked.error());
    const bool may_be_short = request.content_length.value_or(kLongBody) < kLongBody;
    const auto& client = connection.client_name();
    if (deferred && jobs_.is_full(client)) return busy(429, "too many jobs are waiting (job-queue)");
    if (!deferred && pool_.is_full(client, may_be_short)) return busy(429, "too many requests are waiting");
    if (!url) return connection.read_body(request, config_.max_body);
    if (request.chunked || request.content_length.value_or(0) > 0)
        return problem(400, "image_url replaces the body, which must be empty");
    return fetch_picture(*url, incoming);
}

/// Fetches a picture from one of the permitted origins.
HttpResult<std::string> ComputeRoutes::fetch_picture(const std::string& url, const Incoming& incoming) {
    const std::shared_ptr<void> slot(nullptr, [fetches = fetches_](void*) { --*fetches; });
    if (++*fetches_ > kMaxFetches) return busy(503, "too many pictures are being fetched");
    MemoryBudget::Lease lease;
    const auto reserve = [&](std::size_t bytes) {
        return reserve_memory(bytes).map([&](MemoryBudget::Lease&& reserved) { lease = std::move(reserved); });
    };
    return fetch(
        url, config_.origins, {.max_bytes = config_.max_body, .timeout = config_.patience.body}, reserve,
        [&] { return abandoned_ || incoming.connection.client_gone(); }, slot);
}

/// Reserves memory for a request until it is answered.
HttpResult<MemoryBudget::Lease> ComputeRoutes::reserve_memory(std::size_t size) {
    if (size > waiting_memory_.total()) return too_large(size);
    auto lease = waiting_memory_.reserve(size);
    if (!lease) return busy(429, "too many large requests are waiting");
    return *std::move(lease);
}

/// Computes the name of the answer, and converts a form to a plain body.
HttpResult<ComputeRoutes::AcceptedPointer> ComputeRoutes::prepare(const Operation& operation, ComputeRequest request,
                                                                  const std::vector<FormPart>& fields,
                                                                  MemoryBudget::Lease lease) {
    std::string name = name_of_answer(request, fields, config_.limits);
    if (auto apart = take_apart(request, fields, operation.form_part); !apart) return problem(std::move(apart.error()));
    if (config_.presets_only && (fields.size() > 1 || may_hold_options(operation, request)))
        return problem(400, "this server accepts no options besides a preset in the query (presets-only)");
    return std::make_shared<const AcceptedRequest>(
        AcceptedRequest{operation, std::move(request), std::move(name), std::move(lease)});
}

/// Returns the URL of the webhook for the end of a job; empty: none. A URL that is not permitted is an error, although
/// RFC 7240 lets servers ignore preferences, because the client would wait in vain.
HttpResult<std::string> ComputeRoutes::find_callback(const Request& request) const {
    const auto callback = find_preference(request, "callback");
    if (!callback) return std::string();
    if (!prefers(request, "respond-async")) return problem(400, "Prefer: callback needs respond-async");
    std::string url = header_parameter(*callback, "url");
    if (const auto checked = check_target(url, config_.webhook_hosts); !checked)
        return problem(400, "Prefer: callback: " + checked.error().message + " (webhook-host)");
    return url;
}

/// Turns a request into a job: parses the request now, and stores it to be computed later.
HttpResult<Response> ComputeRoutes::defer(const AcceptedPointer& given, const std::string& callback,
                                          const Incoming& incoming) {
    const auto deadline = Clock::now() + config_.timeout;
    const auto converted = convert_shapefile(given, incoming, deadline);
    if (!converted) return tl::unexpected(converted.error());
    const AcceptedPointer& accepted = *converted;
    const auto forecast = this->forecast(accepted, incoming, deadline);
    if (!forecast) return tl::unexpected(forecast.error());
    incoming.record.stages = {};  // the job records separate stages
    Job job;
    job.owner = incoming.connection.key();
    job.client = incoming.connection.client_name();
    job.traceparent = whole_traceparent(incoming.request.header("traceparent"));
    job.callback = callback;
    job.cost = forecast->cost;
    job.expected = forecast->largest_answer;
    job.cost.memory += accepted->request.body.size();  // the run loads the body from the store
    if (job.cost.memory > pool_.memory().total()) return too_large(job.cost.memory);
    return jobs_.accept(std::move(job), accepted->request).map(accepted_response);
}

/// Converts a zipped shapefile to GeoJSON in a worker. Returns other requests unchanged.
HttpResult<ComputeRoutes::AcceptedPointer> ComputeRoutes::convert_shapefile(const AcceptedPointer& accepted,
                                                                            const Incoming& incoming,
                                                                            Clock::time_point deadline) {
    if (!holds_shapefile(accepted->operation, accepted->request)) return accepted;
    const std::size_t max_bytes = max_shapefile_bytes(config_.max_body, pool_.memory().total());
    Task<ComputeRequest> task = [this, accepted, max_bytes](const Control& control, api::Timings& timings, auto&) {
        return with_geojson(accepted->request, max_bytes, read_shapefile_, control.stop, timings);
    };
    auto request =
        run_in_worker(std::move(task), cost_of_shapefile(accepted->request.body, max_bytes), incoming, {deadline});
    if (!request) return tl::unexpected(std::move(request.error()));
    auto lease = reserve_memory(request->body.size());
    if (!lease) return tl::unexpected(std::move(lease.error()));
    return std::make_shared<const AcceptedRequest>(
        AcceptedRequest{accepted->operation, *std::move(request), accepted->name, *std::move(lease)});
}

/// Parses a request and estimates its cost. Long requests are parsed in a worker.
HttpResult<ComputeRoutes::Forecast> ComputeRoutes::forecast(const AcceptedPointer& accepted, const Incoming& incoming,
                                                            Clock::time_point deadline) {
    const auto find = [accepted, &limits = config_.limits] {
        return accepted->operation.parse(accepted->request, limits).map([&](const api::ParsedPointer& parsed) {
            return Forecast{cost_of_answering(accepted->operation, accepted->request, *parsed),
                            parsed->largest_answer(), parsed->accepts_partial()};
        });
    };
    if (!is_quickly_parsed(accepted->operation, accepted->request))
        return run_in_worker<Forecast>([find](const Control&, api::Timings&, auto&) { return find(); },
                                       cost_of_parsing(accepted->operation, accepted->request), incoming, {deadline},
                                       Stoppable::No);
    auto found = find();
    if (!found) return problem(std::move(found.error()));
    return *found;
}

/// Runs a task in a worker, and waits for the result. Adds the stages of the task to the record. If the pool displaces
/// the task, runs it again as a long one.
template <class T>
HttpResult<T> ComputeRoutes::run_in_worker(Task<T> task, api::Cost cost, const Incoming& incoming,
                                           const TimeLimit& limit, Stoppable stoppable) {
    if (cost.memory > pool_.memory().total()) return too_large(cost.memory);
    while (true) {
        const auto pending = std::make_shared<PendingResult<T>>();
        const auto run = [pending, task](WorkerPool::Turn& turn) {
            pending->begin();
            api::Timings timings;
            try {
                pending->finish(task(Control{turn.stop, {}}, timings, *pending), timings);
            } catch (const std::exception& exception) {
                pending->finish(failure(ErrorCode::Internal, exception.what()), timings);
            }
            turn.used = timings.processor * 1e-3;
        };
        const auto displace = [task_of = std::weak_ptr(pending), stoppable] {
            const auto running = task_of.lock();
            return stoppable == Stoppable::Yes && running && running->displace();
        };
        const auto job = pool_.submit(incoming.connection.client_name(), run, cost, displace);
        if (!job) return busy(429, "too many requests are waiting");
        const auto waited = wait_for(*pending, *job, incoming, limit);
        add_stages(pending->stages(), incoming.record);
        if (!waited) return tl::unexpected(waited.error());
        if (pending->is_displaced()) {
            cost.seconds = std::max(cost.seconds, 2 * WorkerPool::kShort);
            continue;
        }
        auto result = pending->take_result();
        if (!result && result.error().code == ErrorCode::Stopped) return too_slow(incoming.record);
        if (!result) return problem(std::move(result.error()));
        return *std::move(result);
    }
}

/// Waits for a result until the client closes the connection, the server shuts down (ComputeRoutes::abandon), or the
/// deadline and the grace period have passed. A computation that still runs is told to stop, and ends later.
template <class T>
HttpResult<void> ComputeRoutes::wait_for(PendingResult<T>& pending, WorkerPool::JobId job, const Incoming& incoming,
                                         const TimeLimit& limit) {
    while (!pending.wait_until(std::min(Clock::now() + kPollInterval, limit.deadline))) {
        if (incoming.connection.client_gone()) {
            pending.abandon();
            pool_.cancel(job);
            return cancelled(problem(kClientGone, "the client closed the connection"), "client_gone", incoming.record);
        }
        if (abandoned_) {
            pending.abandon();
            pool_.cancel(job);
            return cancelled(busy(503, "the server is shutting down"), "shutdown", incoming.record);
        }
        if (Clock::now() < limit.deadline) continue;
        if (pool_.cancel(job) == WorkerPool::Cancelled::Queued)
            return cancelled(busy(503, "no worker was free in time"), "deadline", incoming.record);
        if (!pending.wait_until(limit.deadline + limit.grace)) return too_slow(incoming.record);
    }
    return {};
}

HttpResult<ComputeRoutes::ComputedAnswer> ComputeRoutes::run(const AcceptedPointer& accepted, const api::Cost& cost,
                                                             bool compressed, const Incoming& incoming,
                                                             const TimeLimit& limit) {
    const std::string key = cache_key(accepted->name, compressed, cache_owner(incoming.connection));
    const bool in_pieces = incoming.request.method != "HEAD";
    Task<ComputedAnswer> task = [this, accepted, compressed, key, in_pieces](const Control& control,
                                                                             api::Timings& timings,
                                                                             PendingResult<ComputedAnswer>& pending) {
        Progress last;
        TeeWriter tee(pending, timings, last, cache_.largest(), pool_.memory());
        const std::stop_callback pass_on(control.stop, [&tee] { tee.stop().request_stop(); });
        Control own = control;
        own.stop = tee.stop().get_token();
        own.progress = [&last](const Progress& progress) { last = progress; };
        auto answer =
            compute_(accepted->request, {compressed, in_pieces ? &tee : nullptr, pending.unwanted()}, own, timings);
        if (answer && answer->streamed && tee.copy() != nullptr && !answer->partial) cache_.store(key, *tee.copy());
        tee.close(answer.map([](const api::Answer&) {}));
        return std::move(answer).map([&](api::Answer&& whole) {
            const std::size_t size = whole.body.size();
            return ComputedAnswer{std::move(whole), pool_.memory().reserve_unconditionally(size), last};
        });
    };
    return run_in_worker(std::move(task), cost, incoming, limit);
}

tl::unexpected<Problem> ComputeRoutes::busy(int status, std::string message) const {
    return server::busy(status, std::move(message), pool_.backlog());
}

tl::unexpected<Problem> ComputeRoutes::too_large(std::size_t bytes) const {
    const auto mebibytes = [](std::size_t size) { return std::to_string((size >> 20) + 1) + " MiB"; };
    return problem(413, "this needs about " + mebibytes(bytes) + " of memory; this server's limit (memory) leaves " +
                            mebibytes(pool_.memory().total()) + " for computing and " +
                            mebibytes(waiting_memory_.total()) + " for requests");
}

tl::unexpected<Problem> ComputeRoutes::too_slow(Record& record) const {
    return cancelled(problem(504, "the computation took longer than the timeout of " +
                                      std::to_string(config_.timeout.count()) + " ms (timeout)"),
                     "deadline", record);
}

}  // namespace ccdt::server
