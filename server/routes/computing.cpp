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
#include "server/routes/job_routes.h"
#include "server/work/answer_name.h"

namespace ccdt::server {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

/// How often a connection looks whether its client still waits.
constexpr std::chrono::milliseconds kPeek{20};

/// How long after its deadline a job may take to stop, and to write down what it has.
constexpr std::chrono::seconds kGrace{2};

/// Longer bodies are never for short jobs.
constexpr std::size_t kLongBody = 65'536;

/// A result on its way from a worker to the connection that waits for it, which may leave before it comes.
template <class T>
class Ticket {
public:
    void begin() {
        const std::lock_guard lock(mutex_);
        stages_.queue = Milliseconds(Clock::now() - submitted_).count();
    }

    void finish(Result<T> result, const api::Timings& timings) {
        const std::lock_guard lock(mutex_);
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

private:
    const Clock::time_point submitted_ = Clock::now();

    mutable std::mutex mutex_;  ///< guards the rest
    std::condition_variable finished_;
    std::optional<Result<T>> result_;
    Stages stages_;
};

/// Clients that take answers compressed have them kept so: compressing is work, too.
///
/// @param owner  the API key that they are kept for; empty: for all
std::string cache_key(const std::string& name, bool compressed, const std::string& owner) {
    return (compressed ? name + "-gzip " : name + ' ') + owner;
}

/// @param name  of the answer, unless it is only a part of it
Response response_of(api::Answer answer, const std::string& name) {
    Response response;
    response.media_type = std::move(answer.media_type);
    response.body = std::move(answer.body);
    response.coding = std::move(answer.coding);
    if (answer.partial) {
        response.headers.push_back({"X-Partial", "deadline"});
        response.cancelled = "deadline";
    } else {
        response.tag = (answer.repeats ? "\"" : "W/\"") + name + '"';
    }
    return response;
}

}  // namespace

/// A question, and its part of the memory for those that wait. Shared with the worker, which may still read it when the
/// connection has left.
struct Computing::Asked {
    Question question;
    MemoryBudget::Lease lease;
};

/// An answer, and its part of the memory that computing it had.
struct Computing::Product {
    api::Answer answer;
    MemoryBudget::Lease lease;
};

Computing::Computing(const Config& config, WorkerPool& pool, Compute compute, Jobs& jobs)
    : config_(config),
      pool_(pool),
      compute_(std::move(compute)),
      jobs_(jobs),
      waiting_memory_(pool.memory().total() / 3),  // a quarter of both
      cache_(config.cache) {}

Outcome Computing::answer(const Request& request, Connection& connection) {
    Question question{request.path,
                      request.query,
                      std::string(request.header("Content-Type")),
                      std::string(request.header("Accept")),
                      {}};
    if (auto checked = check(question); !checked) return problem(std::move(checked.error()));
    const bool deferred = prefers(request, "respond-async");
    auto body = read_body(request, connection, deferred);
    if (!body) return tl::unexpected(std::move(body.error()));
    question.body = *std::move(body);
    const auto asked = take_in(std::move(question));
    if (!asked) return tl::unexpected(asked.error());
    const std::string name = name_of_answer((*asked)->question, config_.limits);
    if (const auto tag = find_tag(request.header("If-None-Match"), name)) return not_modified(*tag);
    if (deferred) return defer(*asked, connection);
    const bool compressed = accepts_gzip(request.header("Accept-Encoding"));
    if (auto response = recall(name, compressed, cache_owner(connection))) return *std::move(response);
    return compute(*asked, name, compressed, connection);
}

Outcome Computing::compute(const AskedPointer& asked, const std::string& name, bool compressed,
                           Connection& connection) {
    const auto deadline = Clock::now() + config_.timeout;
    Stages stages;
    const auto cost = find_cost(asked, connection, deadline, stages);
    if (!cost) return tl::unexpected(cost.error());
    auto product = run(asked, *cost, compressed, connection, deadline, stages);
    if (!product) return tl::unexpected(std::move(product.error()));
    if (!product->answer.partial) cache_.keep(cache_key(name, compressed, cache_owner(connection)), product->answer);
    const Computed computed{product->answer.sites, product->answer.pixels};
    Response response = response_of(std::move(product->answer), name);
    response.stages = stages;
    response.computed = computed;
    response.lease = std::make_shared<MemoryBudget::Lease>(std::move(product->lease));
    return response;
}

/// What one key asked is no other's to find out, which the time of an answer would tell.
std::string Computing::cache_owner(const Connection& connection) const {
    return config_.cache_shared ? "" : connection.key();
}

/// The answer of that name if it was computed before, and there is memory to send it.
std::optional<Response> Computing::recall(const std::string& name, bool compressed, const std::string& owner) {
    const auto answer = cache_.find(cache_key(name, compressed, owner));
    if (answer == nullptr) return std::nullopt;
    auto lease = pool_.memory().take(answer->body.size());
    if (!lease) return std::nullopt;
    Response response = response_of(*answer, name);
    response.cached = true;
    response.lease = std::make_shared<MemoryBudget::Lease>(*std::move(lease));
    return response;
}

/// The body of a request that is to be computed, unless it is clear already that it will not be.
tl::expected<std::string, Problem> Computing::read_body(const Request& request, Connection& connection,
                                                        bool deferred) const {
    const auto encoding = request.header("Content-Encoding");
    if (!encoding.empty() && !equals_ignoring_case(encoding, "identity"))
        return problem(415, "a Content-Encoding is not understood; send the body as it is");
    if (draining_) return busy(503, "the server is shutting down");
    const bool may_be_short = request.content_length.value_or(kLongBody) < kLongBody;
    const auto& client = connection.client_name();
    if (deferred && jobs_.is_full(client)) return busy(429, "too many jobs are waiting (job-queue)");
    if (!deferred && pool_.is_full(client, may_be_short)) return busy(429, "too many requests are waiting");
    auto body = connection.read_body(request, config_.max_body);
    if (!body) return problem(std::move(body.error()));
    return std::move(*body);
}

/// Has the question counted from here on until nobody needs it any more.
tl::expected<Computing::AskedPointer, Problem> Computing::take_in(Question question) {
    const std::size_t size = question.body.size();
    if (size > waiting_memory_.total()) return too_large(size);
    auto lease = waiting_memory_.take(size);
    if (!lease) return busy(429, "too many large requests are waiting");
    return std::make_shared<const Asked>(Asked{std::move(question), *std::move(lease)});
}

/// Makes a job of what is understood now and computed when its turn comes.
Outcome Computing::defer(const AskedPointer& asked, Connection& connection) {
    Stages stages;
    const auto cost = find_cost(asked, connection, Clock::now() + config_.timeout, stages);
    if (!cost) return tl::unexpected(cost.error());
    Job job;
    job.owner = connection.key();
    job.client = connection.client_name();
    job.cost = *cost;
    job.cost.memory += asked->question.body.size();  // its run takes it from the store
    if (job.cost.memory > pool_.memory().total()) return too_large(job.cost.memory);
    return jobs_.accept(std::move(job), asked->question).map(accepted);
}

/// What a request costs is known once it is understood, which a worker does unless that is quick.
tl::expected<api::Cost, Problem> Computing::find_cost(const AskedPointer& asked, Connection& connection,
                                                      Clock::time_point deadline, Stages& stages) {
    Task<api::Cost> find = [asked, &limits = config_.limits](const Control&, api::Timings&) {
        return understand(asked->question, limits).map([&](const Understood& understood) {
            return cost_of_answering(asked->question, understood, limits);
        });
    };
    if (!is_quickly_understood(asked->question))
        return have_done(cost_of_understanding(asked->question), std::move(find), connection, deadline, stages);
    auto cost = find({}, stages.work);
    if (!cost) return problem(std::move(cost.error()));
    return *cost;
}

/// Has a worker do it, and waits: for the result, the deadline or the client's leaving.
///
/// @param stages  filled as far as it came
template <class T>
tl::expected<T, Problem> Computing::have_done(const api::Cost& cost, Task<T> work, Connection& connection,
                                              Clock::time_point deadline, Stages& stages) {
    if (cost.memory > pool_.memory().total()) return too_large(cost.memory);
    const auto ticket = std::make_shared<Ticket<T>>();
    const auto job = pool_.submit(
        connection.client_name(),
        [ticket, work = std::move(work)](std::stop_token stop) {
            ticket->begin();
            api::Timings timings;
            try {
                ticket->finish(work(Control{std::move(stop), {}}, timings), timings);
            } catch (const std::exception& exception) {
                ticket->finish(failure(ErrorCode::Internal, exception.what()), timings);
            }
        },
        cost);
    if (!job) return busy(429, "too many requests are waiting");

    const auto give_up = [&](tl::unexpected<Problem> reason) {
        reason.value().stages = ticket->stages();
        return reason;
    };
    while (!ticket->wait_until(std::min(Clock::now() + kPeek, deadline))) {
        if (connection.client_gone()) {
            pool_.cancel(*job);
            auto gone = problem(499, "the client went away");
            gone.value().deliver = false;
            gone.value().cancelled = "client_gone";
            return give_up(std::move(gone));
        }
        if (abandoned_) {
            pool_.cancel(*job);
            auto refused = busy(503, "the server is shutting down");
            refused.value().cancelled = "shutdown";
            return give_up(std::move(refused));
        }
        if (Clock::now() < deadline) continue;
        if (pool_.cancel(*job) == WorkerPool::Cancelled::Queued) {
            auto refused = busy(503, "no worker was free in time");
            refused.value().cancelled = "deadline";
            return give_up(std::move(refused));
        }
        if (ticket->wait_until(deadline + kGrace)) break;
        return give_up(too_slow());
    }
    auto result = ticket->take_result();
    if (!result && result.error().code == ErrorCode::Stopped) return give_up(too_slow());
    if (!result) return give_up(problem(std::move(result.error())));
    stages = ticket->stages();
    return *std::move(result);
}

/// @param stages  with the wait so far
tl::expected<Computing::Product, Problem> Computing::run(const AskedPointer& asked, const api::Cost& cost,
                                                         bool compressed, Connection& connection,
                                                         Clock::time_point deadline, Stages& stages) {
    const Manner manner{compressed};
    Task<Product> job = [this, asked, manner](const Control& control, api::Timings& timings) {
        return compute_(asked->question, manner, control, timings).map([this](api::Answer answer) {
            const std::size_t size = answer.body.size();
            return Product{std::move(answer), pool_.memory().hold(size)};
        });
    };
    const double waited = stages.queue;
    auto product = have_done(cost, std::move(job), connection, deadline, stages);
    stages.queue += waited;
    return product;
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

tl::unexpected<Problem> Computing::too_slow() const {
    auto late = problem(504, "the computation took longer than the timeout of " +
                                 std::to_string(config_.timeout.count()) + " ms (timeout)");
    late.value().cancelled = "deadline";
    return late;
}

}  // namespace ccdt::server
