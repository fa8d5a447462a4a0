#include "server/computing.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "server/cache/entity_tag.h"
#include "server/http/compression.h"
#include "server/jobs/job_routes.h"

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

/// The same work, whose answer is compressed in the end if no stop has come: what there is by a deadline goes out as it
/// is.
Task<api::Answer> compressing(Task<api::Answer> work) {
    return [work = std::move(work)](const Control& control, api::Timings& timings) -> Result<api::Answer> {
        auto answer = work(control, timings);
        if (!answer || !is_worth_compressing(answer->media_type, answer->body)) return answer;
        const auto start = Clock::now();
        if (auto compressed = gzip(answer->body, control.stop)) {
            answer->body = std::move(*compressed);
            answer->coding = "gzip";
        }
        timings.encode += Milliseconds(Clock::now() - start).count();
        return answer;
    };
}

/// Clients that take answers compressed have them kept so: compressing is work, too.
std::string cache_key(const std::string& name, bool compressed) {
    return compressed ? name + "-gzip" : name;
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

/// An answer, and its part of the memory that computing it had.
struct Computing::Product {
    api::Answer answer;
    MemoryBudget::Lease lease;
};

Computing::Computing(const Config& config, WorkerPool& pool, const Planner& planner, Jobs& jobs)
    : config_(config),
      pool_(pool),
      planner_(planner),
      jobs_(jobs),
      waiting_memory_(pool.memory().total() / 3),  // a quarter of both
      cache_(config.cache) {}

Outcome Computing::answer(const Request& request, Connection& connection) {
    Question question{request.path,
                      request.query,
                      std::string(request.header("Content-Type")),
                      std::string(request.header("Accept")),
                      {}};
    if (auto checked = Planner::check(question); !checked) return problem(std::move(checked.error()));
    const bool deferred = prefers(request, "respond-async");
    auto body = read_body(request, connection, deferred);
    if (!body) return tl::unexpected(std::move(body.error()));
    question.body = *std::move(body);
    const std::string name = name_of_answer(question, config_.limits);
    if (const auto tag = find_tag(request.header("If-None-Match"), name)) return not_modified(*tag);
    if (deferred) return defer(question, connection);
    const bool compressed = accepts_gzip(request.header("Accept-Encoding"));
    if (auto response = recall(name, compressed)) return *std::move(response);
    return compute(std::move(question), name, compressed, connection);
}

Outcome Computing::compute(Question question, const std::string& name, bool compressed, Connection& connection) {
    const auto deadline = Clock::now() + config_.timeout;
    Stages stages;
    auto plan = understand(std::move(question), connection, deadline, stages);
    if (!plan) return tl::unexpected(std::move(plan.error()));
    if (compressed) plan->work = compressing(std::move(plan->work));
    auto product = run(*std::move(plan), connection, deadline, stages);
    if (!product) return tl::unexpected(std::move(product.error()));
    if (!product->answer.partial) cache_.keep(cache_key(name, compressed), product->answer);
    const Computed computed{product->answer.sites, product->answer.pixels};
    Response response = response_of(std::move(product->answer), name);
    response.stages = stages;
    response.computed = computed;
    response.lease = std::make_shared<MemoryBudget::Lease>(std::move(product->lease));
    return response;
}

/// The answer of that name if it was computed before, and there is memory to send it.
std::optional<Response> Computing::recall(const std::string& name, bool compressed) {
    const auto answer = cache_.find(cache_key(name, compressed));
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

/// Makes a job of what is understood now and computed when its turn comes.
Outcome Computing::defer(const Question& question, Connection& connection) {
    const std::size_t size = question.body.size();
    const std::size_t held = 2 * size;  // it is copied, to be understood
    if (held > waiting_memory_.total()) return too_large(held);
    const auto lease = waiting_memory_.take(held);
    if (!lease) return busy(429, "too many large requests are waiting");
    Stages stages;
    const auto plan = understand(question, connection, Clock::now() + config_.timeout, stages);
    if (!plan) return tl::unexpected(plan.error());
    Job job;
    job.owner = connection.key();
    job.client = connection.client_name();
    job.cost = plan->cost;
    // Its run understands it again, from the store.
    const bool quick = Planner::is_quick(question);
    const std::size_t reading = quick ? size : Planner::cost_of_planning(question).memory + size;
    job.cost.memory = std::max(plan->cost.memory + plan->size, reading);
    if (job.cost.memory > pool_.memory().total()) return too_large(job.cost.memory);
    return jobs_.accept(std::move(job), question).map(accepted);
}

/// What a request costs is known once its body is read, which a worker does unless it is quick.
tl::expected<Plan, Problem> Computing::understand(Question question, Connection& connection, Clock::time_point deadline,
                                                  Stages& stages) {
    if (Planner::is_quick(question)) {
        auto plan = planner_.plan(std::move(question));
        if (!plan) return problem(std::move(plan.error()));
        return *std::move(plan);
    }
    const std::size_t size = question.body.size();
    const auto cost = Planner::cost_of_planning(question);
    // All of it is the worker's own: the connection may leave before it is done.
    Task<Plan> read = [this, shared = std::make_shared<Question>(std::move(question))](const Control&, api::Timings&) {
        return planner_.plan(std::move(*shared));
    };
    return have_done(cost, size, std::move(read), connection, deadline, stages);
}

/// Has a worker do it, and waits: for the result, the deadline or the client's leaving.
///
/// @param held    bytes that the request holds until it is done
/// @param stages  filled as far as it came
template <class T>
tl::expected<T, Problem> Computing::have_done(const api::Cost& cost, std::size_t held, Task<T> work,
                                              Connection& connection, Clock::time_point deadline, Stages& stages) {
    if (cost.memory > pool_.memory().total() || held > waiting_memory_.total()) return too_large(cost.memory + held);
    auto lease = waiting_memory_.take(held);
    if (!lease) return busy(429, "too many large requests are waiting");
    const auto ticket = std::make_shared<Ticket<T>>();
    const auto job = pool_.submit(
        connection.client_name(),
        [ticket, work = std::move(work),
         lease = std::make_shared<MemoryBudget::Lease>(*std::move(lease))](std::stop_token stop) {
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
tl::expected<Computing::Product, Problem> Computing::run(Plan plan, Connection& connection, Clock::time_point deadline,
                                                         Stages& stages) {
    Task<Product> job = [this, work = std::move(plan.work)](const Control& control, api::Timings& timings) {
        return work(control, timings).map([this](api::Answer answer) {
            const std::size_t size = answer.body.size();
            return Product{std::move(answer), pool_.memory().hold(size)};
        });
    };
    const double waited = stages.queue;
    auto product = have_done(plan.cost, plan.size, std::move(job), connection, deadline, stages);
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
