// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/compute/compute_process.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <mutex>
#include <new>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include "core/base/thread_executor.h"
#include "server/decoder/decoder_client.h"
#include "server/decoder/decoder_protocol.h"
#include "server/processes/messages.h"
#include "server/processes/process.h"
#include "server/processes/shared_number.h"

namespace ccdt::server {
namespace {

/// Returns free memory to the system if it exceeds a megabyte. Less memory is kept for the next computation. Takes less
/// than a millisecond.
void give_back_memory() {
    constexpr std::size_t kMuch = std::size_t{1} << 20;
    if (mallinfo2().fordblks > kMuch) malloc_trim(0);
}

/// A request that has arrived, and the stop source of its computation.
struct Task {
    Call call;
    ComputeRequest request;
    std::stop_source stop;
};

/// Receives messages from the channel in a separate thread, so that a Stop is noticed during a computation. Ends the
/// process when the channel is closed.
class Inbox {
public:
    explicit Inbox(int channel) : channel_(channel), listener_([this] { listen(); }) {}

    Task wait() {
        std::unique_lock lock(mutex_);
        came_.wait(lock, [this] { return next_.has_value(); });
        Task task = *std::move(next_);
        next_.reset();
        return task;
    }

private:
    [[noreturn]] void listen() {
        while (true) {
            Call call;
            if (!receive_all(channel_, {reinterpret_cast<char*>(&call), sizeof(call)})) _exit(0);
            switch (call.kind) {
                case Call::Kind::Ask:
                    put(call, receive_request(call));
                    break;
                case Call::Kind::Stop:
                    stop(call.number);
                    break;
                case Call::Kind::Yield:
                    yield(call.nice);
            }
        }
    }

    ComputeRequest receive_request(const Call& call) const {
        ComputeRequest request;
        const std::array texts = {&request.path, &request.query, &request.content_type, &request.accept, &request.body};
        for (std::size_t i = 0; i < texts.size(); ++i) {
            texts[i]->resize(call.sizes[i]);
            if (!receive_all(channel_, *texts[i])) _exit(0);
        }
        return request;
    }

    /// Lowers the priority of all threads but the calling one, which ends this process when the server closes the
    /// channel. New threads have the priority of the thread that starts them.
    static void yield(int nice) {
        std::error_code error;
        std::filesystem::directory_iterator thread("/proc/self/task", error);
        for (; !error && thread != end(thread); thread.increment(error))
            if (const auto id = std::stoi(thread->path().filename()); id != gettid())
                setpriority(PRIO_PROCESS, static_cast<id_t>(id), nice);
    }

    void put(const Call& call, ComputeRequest request) {
        const std::lock_guard lock(mutex_);
        last_number_ = call.number;
        last_stop_ = std::stop_source();
        next_ = Task{call, std::move(request), last_stop_};
        came_.notify_one();
    }

    void stop(std::uint64_t number) {
        const std::lock_guard lock(mutex_);
        if (number == last_number_) last_stop_.request_stop();
    }

    const int channel_;

    std::mutex mutex_;  ///< guards the members from here to `last_stop_`
    std::condition_variable came_;
    std::optional<Task> next_;
    std::uint64_t last_number_ = 0;
    std::stop_source last_stop_;

    std::jthread listener_;  ///< last, because it uses all other members
};

/// Runs the tasks of a computation on at most as many threads as the server allows at the moment.
class LentThreads : public Executor {
public:
    /// @param lent  number of threads that the server allows, including the calling one; must outlive this object
    explicit LentThreads(const SharedNumberReader& lent)
        : threads_([this, &lent] { return lent_ = Clock::now() - start_ < kAlone ? 1 : lent.load(1); }) {}

    void run(std::size_t count, const std::function<void(std::size_t)>& task) override {
        threads_.run(count, task);
        max_used_ = std::max(max_used_, std::min(count, lent_));
    }

    /// Returns the maximum number of threads that worked at the same time.
    std::size_t max_used() const { return max_used_; }

private:
    using Clock = std::chrono::steady_clock;

    /// Time for which a computation has only one thread, because starting threads delays short computations: `/sample`
    /// with 1,024 sites takes 3.8 ms with this limit and 4.1 ms without it.
    static constexpr std::chrono::milliseconds kAlone{5};

    const Clock::time_point start_ = Clock::now();
    std::size_t lent_ = 1;
    std::size_t max_used_ = 1;
    ThreadExecutor threads_;
};

/// Sends a reply with its texts.
/// @returns  false if the channel is closed; Inbox then ends the process
bool send_reply(int channel, Reply reply, const std::array<std::string_view, Reply::kTexts>& texts) {
    for (std::size_t i = 0; i < texts.size(); ++i) reply.sizes[i] = texts[i].size();
    return send_texts(channel, {text_of(reply), texts[0], texts[1], texts[2], texts[3], texts[4]});
}

/// Sends a whole answer, or the head of an answer whose body is sent in pieces.
bool send_answer(int channel, Reply reply, const api::Answer& answer) {
    reply.sites = answer.sites;
    reply.pixels = answer.pixels;
    reply.partial = answer.partial ? 1 : 0;
    reply.repeats = answer.repeats ? 1 : 0;
    reply.streamed = answer.streamed ? 1 : 0;
    if (answer.dots) {
        reply.radius = answer.dots->radius;
        reply.tone = answer.dots->tone;
    }
    reply.plot_seconds = answer.plot ? answer.plot->seconds : -1;
    return send_reply(channel, reply,
                      {answer.media_type, answer.coding, answer.body, answer.repaired, answer.warnings});
}

/// Sends a large body to the server in pieces.
class PieceSender : public api::BodySink {
public:
    /// @param timings  timings of the current computation, sent with the head
    PieceSender(int channel, const api::Timings& timings) : channel_(channel), timings_(timings) {}

    /// Sends the head. Also returns the free memory of the computation, because a slow client may receive the body for
    /// a long time.
    Result<void> begin(const api::Answer& head) override {
        give_back_memory();
        Reply reply;
        reply.kind = Reply::Kind::Head;
        reply.timings = timings_;
        return check(send_answer(channel_, reply, head));
    }

    Result<void> write(std::string_view piece) override {
        Reply reply;
        reply.kind = Reply::Kind::Piece;
        std::array<std::string_view, Reply::kTexts> texts;
        texts[2] = piece;
        return check(send_reply(channel_, reply, texts));
    }

private:
    static Result<void> check(bool sent) {
        if (!sent) return failure(ErrorCode::Stopped, "the server no longer receives the answer");
        return {};
    }

    const int channel_;
    const api::Timings& timings_;
};

/// Computes an answer. Exceptions become errors (Internal).
Result<api::Answer> answer(const Task& task, const ComputeFunction& compute, const api::Decode& decode,
                           const Control& control, api::Timings& timings, int channel) {
    PieceSender sender(channel, timings);
    const Delivery delivery{task.call.compressed != 0, &sender};
    try {
        return compute(task.request, delivery, task.call.limits, decode, control, timings);
    } catch (const std::exception& exception) {
        return failure(ErrorCode::Internal, exception.what());
    }
}

void reply_to(const Task& task, const ComputeFunction& compute, DecoderClient& decoder, const SharedNumberReader& lent,
              int channel) {
    const auto deaths = decoder.deaths();
    const auto before = processor_time() + decoder.processor_time();
    LentThreads threads(lent);
    Reply reply;
    const Control control{task.stop.get_token(),
                          [&](const Progress& progress) {
                              Reply step;
                              step.progress = progress;
                              send_reply(channel, step, {});
                          },
                          &threads};
    const auto result = answer(task, compute, decoder.functions(), control, reply.timings, channel);
    const std::chrono::duration<double, std::milli> used = processor_time() + decoder.processor_time() - before;
    reply.timings.processor = used.count();
    reply.timings.threads = static_cast<std::uint32_t>(threads.max_used());
    reply.decoder_deaths = decoder.deaths() - deaths;
    if (!result) {
        reply.kind = Reply::Kind::Failure;
        reply.code = static_cast<std::uint32_t>(result.error().code);
        send_reply(channel, reply, {result.error().message, result.error().field, {}, {}, {}});
        return;
    }
    reply.kind = Reply::Kind::Answer;
    send_answer(channel, reply, *result);
}

}  // namespace

void run_compute_process(ComputeFiles files, const ComputeFunction& compute) {
    const SharedNumberReader lent(files.threads);
    Inbox inbox(files.channel.get());
    DecoderClient decoder(
        [&files](const Order& order, const std::stop_token&) { return send_order(files.events.get(), order); });
    while (true) {
        const Task task = inbox.wait();
        reply_to(task, compute, decoder, lent, files.channel.get());
        give_back_memory();
    }
}

}  // namespace ccdt::server
