#include "server/routes/computing.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "server/http/compression.h"
#include "server/http/entity_tag.h"
#include "server/http/trace.h"
#include "server/routes/job_routes.h"
#include "server/work/answer_headers.h"
#include "server/work/answer_name.h"
#include "server/work/form.h"
#include "server/work/passage.h"

namespace ccdt::server {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

/// Time after which a connection looks whether its client still waits.
constexpr std::chrono::milliseconds kPeek{20};

/// Time after the deadline that a computation may take to stop and to write a partial answer.
constexpr std::chrono::seconds kGrace{2};

/// Content type of a picture in a folder: whatever the file holds, it is neither JSON nor a form.
constexpr const char* kPicture = "image/*";

/// Bytes of a body: longer ones are never for short jobs.
constexpr std::size_t kLongBody = 65'536;

/// Clients that take answers compressed have them kept so: compressing is work, too.
///
/// @param owner  the API key that they are kept for; empty: for all
std::string cache_key(const std::string& name, bool compressed, const std::string& owner) {
    return (compressed ? name + "-gzip " : name + ' ') + owner;
}

/// Finds the tag of an answer among those that the client sent.
std::optional<std::string_view> known_tag(const Incoming& incoming, const std::string& name) {
    return find_tag(incoming.request.header("If-None-Match"), name);
}

/// Whether a header says that the body is encoded.
bool is_encoding(const Header& header) {
    return equals_ignoring_case(header.name, "Content-Encoding") && !header.value.empty() &&
           !equals_ignoring_case(header.value, "identity");
}

/// Tells figures why a computation was given up.
tl::unexpected<Problem> give_up(tl::unexpected<Problem> why, std::string_view cause, Record& record) {
    record.cancelled = cause;
    return why;
}

/// @param name  of the answer, unless it is only a part of it
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

/// A request, and its part of the memory for those that wait. Shared with the worker, which may still read it when the
/// connection has left.
struct Computing::AcceptedRequest {
    const Operation& operation;
    ComputeRequest request;
    std::string name;  ///< of the answer
    MemoryBudget::Lease lease;
};

/// An answer, and its part of the memory that computing it had.
struct Computing::ComputedAnswer {
    api::Answer answer;
    MemoryBudget::Lease lease;
    std::shared_ptr<Passage> passage = {};  ///< of a large body, which is on its way still
};

/// A result on its way from a worker to the connection that waits for it, which may leave before it comes.
template <class T>
class Computing::PendingResult {
public:
    void begin() {
        const std::lock_guard lock(mutex_);
        stages_.queue = Milliseconds(Clock::now() - submitted_).count();
    }

    /// Takes a result, unless there is one.
    void finish(Result<T> result, const api::Timings& timings) {
        const std::lock_guard lock(mutex_);
        if (finished_already_) return;
        finished_already_ = true;
        stages_.work = timings;
        result_ = std::move(result);
        finished_.notify_all();
    }

    /// @returns  whether there is a result
    bool wait_until(Clock::time_point time) {
        std::unique_lock lock(mutex_);
        return finished_.wait_until(lock, time, [this] { return result_.has_value(); });
    }

    Result<T> take_result() {
        const std::lock_guard lock(mutex_);
        return std::move(*result_);
    }

    Stages stages() const {
        const std::lock_guard lock(mutex_);
        return stages_;
    }

    /// Tells whatever makes the result that nobody wants it any more.
    void abandon() { unwanted_.request_stop(); }
    std::stop_token unwanted() const { return unwanted_.get_token(); }

private:
    const Clock::time_point submitted_ = Clock::now();
    std::stop_source unwanted_;

    mutable std::mutex mutex_;  ///< guards the rest
    std::condition_variable finished_;
    std::optional<Result<T>> result_;
    bool finished_already_ = false;  ///< the result may have been taken since
    Stages stages_;
};

/// Takes a large body from its computation, hands it on, and keeps a copy if it is not too large for that.
class Computing::Outlet : public api::BodyTaker {
public:
    /// @param largest  bytes of a body that is kept
    Outlet(PendingResult<ComputedAnswer>& pending, const api::Timings& timings, std::size_t largest,
           MemoryBudget& memory)
        : pending_(pending), timings_(timings), largest_(largest), memory_(memory) {}
    ~Outlet() override { close(failure(ErrorCode::Internal, "the answer was not written to its end")); }
    Outlet(const Outlet&) = delete;
    Outlet& operator=(const Outlet&) = delete;

    Result<void> begin(const api::Answer& head) override {
        copy_ = head;
        pending_.finish(ComputedAnswer{head, {}, passage_}, timings_);
        return {};
    }

    Result<void> take(std::string_view piece) override {
        if (copy_ && copy_->body.size() + piece.size() <= largest_) {
            copy_->body += piece;
        } else {
            copy_.reset();
        }
        return passage_->push(piece);
    }

    /// Ends the body; an error: it is not whole.
    void close(Result<void> outcome) { passage_->close(std::move(outcome), timings_, memory_); }

    /// Stops what computes once nobody takes the body any more.
    std::stop_source& stop() { return passage_->stop(); }

    /// The whole answer, once the body has ended; null if it is too large to be kept.
    const api::Answer* copy() const { return copy_ ? &*copy_ : nullptr; }

private:
    PendingResult<ComputedAnswer>& pending_;
    const api::Timings& timings_;
    const std::size_t largest_;
    MemoryBudget& memory_;
    const std::shared_ptr<Passage> passage_ = std::make_shared<Passage>();
    std::optional<api::Answer> copy_;
};

Computing::Computing(const Config& config, WorkerPool& pool, MemoryBudget& waiting_memory, Compute compute,
                     ReadShapefile read_shapefile, Jobs& jobs, RedisClient* answers)
    : config_(config),
      pool_(pool),
      waiting_memory_(waiting_memory),
      compute_(std::move(compute)),
      read_shapefile_(std::move(read_shapefile)),
      jobs_(jobs),
      cache_(config.cache, answers) {}

HttpResult<Response> Computing::answer(const Operation& operation, const Incoming& incoming) {
    const Request& request = incoming.request;
    ComputeRequest to_compute{request.path,
                              request.query,
                              std::string(request.header("Content-Type")),
                              std::string(request.header("Accept")),
                              {}};
    if (auto checked = check(operation, to_compute); !checked) return problem(std::move(checked.error()));
    const bool deferred = prefers(request, "respond-async");
    auto body = read_body(incoming, deferred);
    if (!body) return tl::unexpected(std::move(body.error()));
    to_compute.body = *std::move(body);
    auto lease = take_memory(to_compute.body.size());
    if (!lease) return tl::unexpected(lease.error());
    const auto asked = take_in(operation, std::move(to_compute), *std::move(lease));
    if (!asked) return tl::unexpected(asked.error());
    if (!deferred) return give(*asked, incoming);
    if (const auto tag = known_tag(incoming, (*asked)->name)) return not_modified(*tag);
    return defer(*asked, incoming);
}

HttpResult<Response> Computing::answer(const Operation& operation, PictureFile picture, std::string options,
                                       const Incoming& incoming) {
    if (auto checked = check_drain(incoming); !checked) return tl::unexpected(checked.error());
    auto lease = take_memory(picture.size());
    if (!lease) return tl::unexpected(lease.error());
    auto bytes = picture.read();
    if (!bytes) return tl::unexpected(bytes.error());
    // All browsers then share an answer whose format is asked for, whatever else they accept.
    const bool has_format = std::ranges::any_of(parse_query(options),
                                                [](const api::TextOption& option) { return option.name == "format"; });
    ComputeRequest request{std::string(operation.path), std::move(options), kPicture,
                           has_format ? "" : std::string(incoming.request.header("Accept")), *std::move(bytes)};
    const auto asked = take_in(operation, std::move(request), *std::move(lease));
    if (!asked) return tl::unexpected(asked.error());
    return give(*asked, incoming);
}

/// Gives an answer that the client has already, that is kept, or that is computed while the client waits.
HttpResult<Response> Computing::give(const AcceptedPointer& asked, const Incoming& incoming) {
    if (const auto tag = known_tag(incoming, asked->name)) return not_modified(*tag);
    const bool compressed = accepts_gzip(incoming.request.header("Accept-Encoding"));
    if (auto response = recall(asked->name, compressed, incoming)) return *std::move(response);
    return compute(asked, compressed, incoming);
}

HttpResult<Response> Computing::compute(const AcceptedPointer& given, bool compressed, const Incoming& incoming) {
    const auto deadline = Clock::now() + config_.timeout;
    const auto read = with_map_read(given, incoming, deadline);
    if (!read) return tl::unexpected(read.error());
    const AcceptedPointer& asked = *read;
    const auto forecast = this->forecast(asked, incoming, deadline);
    if (!forecast) return tl::unexpected(forecast.error());
    const TimeLimit limit{deadline, forecast->accepts_partial ? kGrace : Clock::duration()};
    auto product = run(asked, forecast->cost, compressed, incoming, limit);
    if (!product) return tl::unexpected(std::move(product.error()));
    api::Answer& answer = product->answer;
    if (!product->passage && !answer.partial)
        cache_.keep(cache_key(asked->name, compressed, cache_owner(incoming.connection)), answer);
    incoming.record.computed = Computed{answer.sites, answer.pixels};
    Response response = response_of(std::move(answer), asked->name, incoming.record);
    if (product->passage) response.stream = stream_of(*product, incoming, deadline + kGrace + Passage::kPatience);
    response.lease = std::make_shared<MemoryBudget::Lease>(std::move(product->lease));
    return response;
}

/// Makes what sends a large body while it is written.
/// @param latest  when what computes has to be done
Stream Computing::stream_of(const ComputedAnswer& computed, const Incoming& incoming, Clock::time_point latest) const {
    return [this, passage = computed.passage, &connection = incoming.connection, latest](const Send& send,
                                                                                         Record& record) {
        while (!passage->is_over()) {
            const auto piece = passage->pop(Clock::now() + kPeek);
            if (piece ? !send(*piece) : connection.client_gone()) {
                record.cancelled = "client_gone";
            } else if (abandoned_) {
                record.cancelled = "shutdown";
            } else if (!piece && Clock::now() > latest) {
                record.cancelled = "deadline";
            } else {
                continue;
            }
            passage->abandon();
            if (record.cancelled != "client_gone") record.cause = "the answer was not written to its end";
            return false;
        }
        record.stages.work = passage->timings();
        const auto outcome = passage->outcome();
        if (!outcome) record.cause = outcome.error().message;
        return outcome.has_value();
    };
}

/// Finds whose an answer in the cache is: by the time it takes one key could tell what another asked.
std::string Computing::cache_owner(const Connection& connection) const {
    return config_.cache_shared ? "" : connection.key();
}

/// Finds the answer of that name if it was computed before, and there is memory to send it.
std::optional<Response> Computing::recall(const std::string& name, bool compressed, const Incoming& incoming) {
    const auto answer = cache_.find(cache_key(name, compressed, cache_owner(incoming.connection)));
    if (answer == nullptr) return std::nullopt;
    auto lease = pool_.memory().take(answer->body.size());
    if (!lease) return std::nullopt;
    incoming.record.cached = true;
    Response response = response_of(*answer, name, incoming.record);
    response.lease = std::make_shared<MemoryBudget::Lease>(*std::move(lease));
    return response;
}

/// Refuses to compute while the server shuts down. Whoever connected before that began is served; by a connection that
/// was kept, others know to ask once more.
HttpResult<void> Computing::check_drain(const Incoming& incoming) const {
    if (draining_ && !incoming.connection.is_on_first_request()) return busy(503, "the server is shutting down");
    return {};
}

/// Reads the body of a request that is to be computed, unless it is clear already that it will not be.
HttpResult<std::string> Computing::read_body(const Incoming& incoming, bool deferred) const {
    const Request& request = incoming.request;
    Connection& connection = incoming.connection;
    if (std::ranges::any_of(request.headers, is_encoding))
        return problem(415, "a Content-Encoding is not understood; send the body as it is");
    if (auto checked = check_drain(incoming); !checked) return tl::unexpected(checked.error());
    const bool may_be_short = request.content_length.value_or(kLongBody) < kLongBody;
    const auto& client = connection.client_name();
    if (deferred && jobs_.is_full(client)) return busy(429, "too many jobs are waiting (job-queue)");
    if (!deferred && pool_.is_full(client, may_be_short)) return busy(429, "too many requests are waiting");
    return connection.read_body(request, config_.max_body);
}

/// Counts the memory of a request from here on until nobody needs it any more.
HttpResult<MemoryBudget::Lease> Computing::take_memory(std::size_t size) {
    if (size > waiting_memory_.total()) return too_large(size);
    auto lease = waiting_memory_.take(size);
    if (!lease) return busy(429, "too many large requests are waiting");
    return *std::move(lease);
}

/// Takes apart what was asked.
HttpResult<Computing::AcceptedPointer> Computing::take_in(const Operation& operation, ComputeRequest request,
                                                          MemoryBudget::Lease lease) {
    auto fields = find_fields(request);
    if (!fields) return problem(std::move(fields.error()));
    std::string name = name_of_answer(request, *fields, config_.limits);
    if (auto apart = take_apart(request, *fields, operation.form_part); !apart)
        return problem(std::move(apart.error()));
    return std::make_shared<const AcceptedRequest>(
        AcceptedRequest{operation, std::move(request), std::move(name), std::move(lease)});
}

/// Makes a job of what is parsed now and computed when its turn comes.
HttpResult<Response> Computing::defer(const AcceptedPointer& given, const Incoming& incoming) {
    const auto deadline = Clock::now() + config_.timeout;
    const auto read = with_map_read(given, incoming, deadline);
    if (!read) return tl::unexpected(read.error());
    const AcceptedPointer& asked = *read;
    const auto forecast = this->forecast(asked, incoming, deadline);
    if (!forecast) return tl::unexpected(forecast.error());
    incoming.record.stages = {};  // the job has its own
    Job job;
    job.owner = incoming.connection.key();
    job.client = incoming.connection.client_name();
    job.traceparent = whole_traceparent(incoming.request.header("traceparent"));
    job.cost = forecast->cost;
    job.cost.memory += asked->request.body.size();  // its run takes it from the store
    if (job.cost.memory > pool_.memory().total()) return too_large(job.cost.memory);
    return jobs_.accept(std::move(job), asked->request).map(accepted);
}

/// Makes GeoJSON of a zipped shapefile, which is admitted as what is computed; any other request stays as it is.
HttpResult<Computing::AcceptedPointer> Computing::with_map_read(const AcceptedPointer& asked, const Incoming& incoming,
                                                                Clock::time_point deadline) {
    if (!holds_shapefile(asked->operation, asked->request)) return asked;
    const std::size_t max_bytes = max_shapefile_bytes(config_.max_body, pool_.memory().total());
    Task<ComputeRequest> task = [this, asked, max_bytes](const Control& control, api::Timings&, auto&) {
        return with_geojson(asked->request, max_bytes, read_shapefile_, control.stop);
    };
    auto request =
        have_worker_do(std::move(task), cost_of_shapefile(asked->request.body, max_bytes), incoming, {deadline});
    if (!request) return tl::unexpected(std::move(request.error()));
    auto lease = take_memory(request->body.size());
    if (!lease) return tl::unexpected(std::move(lease.error()));
    return std::make_shared<const AcceptedRequest>(
        AcceptedRequest{asked->operation, *std::move(request), asked->name, *std::move(lease)});
}

/// Parses a request, in a worker unless that is quick, and estimates its cost.
HttpResult<Computing::Forecast> Computing::forecast(const AcceptedPointer& asked, const Incoming& incoming,
                                                    Clock::time_point deadline) {
    const auto find = [asked, &limits = config_.limits] {
        return asked->operation.parse(asked->request, limits).map([&](const ParsedPointer& parsed) {
            return Forecast{cost_of_answering(asked->operation, asked->request, *parsed), parsed->accepts_partial()};
        });
    };
    if (!is_quickly_parsed(asked->operation, asked->request))
        return have_worker_do<Forecast>([find](const Control&, api::Timings&, auto&) { return find(); },
                                        cost_of_parsing(asked->operation, asked->request), incoming, {deadline});
    auto found = find();
    if (!found) return problem(std::move(found.error()));
    return *found;
}

/// Has a worker do a task, and waits for the result. The record tells how far it came, and how long this and earlier
/// tasks have waited in the queue.
template <class T>
HttpResult<T> Computing::have_worker_do(Task<T> task, const api::Cost& cost, const Incoming& incoming,
                                        const TimeLimit& limit) {
    if (cost.memory > pool_.memory().total()) return too_large(cost.memory);
    const auto pending = std::make_shared<PendingResult<T>>();
    const auto job = pool_.submit(
        incoming.connection.client_name(),
        [pending, task = std::move(task)](std::stop_token stop) {
            pending->begin();
            api::Timings timings;
            try {
                pending->finish(task(Control{std::move(stop), {}}, timings, *pending), timings);
            } catch (const std::exception& exception) {
                pending->finish(failure(ErrorCode::Internal, exception.what()), timings);
            }
        },
        cost);
    if (!job) return busy(429, "too many requests are waiting");
    const double waited_before = incoming.record.stages.queue;
    const auto waited = wait_for(*pending, *job, incoming, limit);
    incoming.record.stages = pending->stages();
    incoming.record.stages.queue += waited_before;
    if (!waited) return tl::unexpected(waited.error());
    auto result = pending->take_result();
    if (!result && result.error().code == ErrorCode::Stopped) return too_slow(incoming.record);
    if (!result) return problem(std::move(result.error()));
    return *std::move(result);
}

/// Waits for a result until the client leaves, the server shuts down, or the deadline and the grace have passed. A
/// computation that is still running then ends in the background.
template <class T>
HttpResult<void> Computing::wait_for(PendingResult<T>& pending, WorkerPool::JobId job, const Incoming& incoming,
                                     const TimeLimit& limit) {
    while (!pending.wait_until(std::min(Clock::now() + kPeek, limit.deadline))) {
        if (incoming.connection.client_gone()) {
            pending.abandon();
            pool_.cancel(job);
            return give_up(problem(kClientGone, "the client went away"), "client_gone", incoming.record);
        }
        if (abandoned_) {
            pending.abandon();
            pool_.cancel(job);
            return give_up(busy(503, "the server is shutting down"), "shutdown", incoming.record);
        }
        if (Clock::now() < limit.deadline) continue;
        if (pool_.cancel(job) == WorkerPool::Cancelled::Queued)
            return give_up(busy(503, "no worker was free in time"), "deadline", incoming.record);
        if (!pending.wait_until(limit.deadline + limit.grace)) return too_slow(incoming.record);
    }
    return {};
}

HttpResult<Computing::ComputedAnswer> Computing::run(const AcceptedPointer& asked, const api::Cost& cost,
                                                     bool compressed, const Incoming& incoming,
                                                     const TimeLimit& limit) {
    const std::string key = cache_key(asked->name, compressed, cache_owner(incoming.connection));
    const bool in_pieces = incoming.request.method != "HEAD";
    Task<ComputedAnswer> task = [this, asked, compressed, key, in_pieces](const Control& control, api::Timings& timings,
                                                                          PendingResult<ComputedAnswer>& pending) {
        Outlet outlet(pending, timings, cache_.largest(), pool_.memory());
        const std::stop_callback pass_on(control.stop, [&outlet] { outlet.stop().request_stop(); });
        Control own = control;
        own.stop = outlet.stop().get_token();
        auto answer =
            compute_(asked->request, {compressed, in_pieces ? &outlet : nullptr, pending.unwanted()}, own, timings);
        if (answer && answer->streamed && outlet.copy() != nullptr && !answer->partial)
            cache_.keep(key, *outlet.copy());
        outlet.close(answer.map([](const api::Answer&) {}));
        return std::move(answer).map([this](api::Answer&& whole) {
            const std::size_t size = whole.body.size();
            return ComputedAnswer{std::move(whole), pool_.memory().hold(size)};
        });
    };
    return have_worker_do(std::move(task), cost, incoming, limit);
}

tl::unexpected<Problem> Computing::busy(int status, std::string message) const {
    return server::busy(status, std::move(message), pool_.backlog());
}

tl::unexpected<Problem> Computing::too_large(std::size_t bytes) const {
    const auto mebibytes = [](std::size_t size) { return std::to_string((size >> 20) + 1) + " MiB"; };
    return problem(413, "this would take about " + mebibytes(bytes) + " of memory; of this server's limit (memory) " +
                            mebibytes(pool_.memory().total()) + " are for computing and " +
                            mebibytes(waiting_memory_.total()) + " for requests");
}

tl::unexpected<Problem> Computing::too_slow(Record& record) const {
    return give_up(problem(504, "the computation took longer than the timeout of " +
                                    std::to_string(config_.timeout.count()) + " ms (timeout)"),
                   "deadline", record);
}

}  // namespace ccdt::server
