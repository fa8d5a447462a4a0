// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/compute/compute_supervisor.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>

#include "server/compute/compute_process.h"
#include "server/compute/fork_server.h"
#include "server/decoder/decoder_protocol.h"
#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

using std::chrono::seconds;

/// Waits for a stop request.
void wait_for_stop(const std::stop_token& stop) {
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any never;
    never.wait(lock, stop, [] { return false; });
}

/// Whether `count` threads run tasks at the same time. Each task waits up to 10 ms for the others.
bool can_meet(Executor& executor, std::size_t count) {
    constexpr std::chrono::milliseconds kLittle{10};
    std::set<std::thread::id> threads;
    std::mutex mutex;
    std::condition_variable came;
    executor.run(count, [&](std::size_t) {
        std::unique_lock lock(mutex);
        threads.insert(std::this_thread::get_id());
        came.notify_all();
        came.wait_for(lock, kLittle, [&] { return threads.size() == count; });
    });
    return threads.size() == count;
}

/// Replaces the computation: performs the action that the path of the request names, in the computation process.
Result<api::Answer> obey(const ComputeRequest& request, const Delivery& delivery, const api::Limits& limits,
                         const api::Decode&, const Control& control, api::Timings& timings) {
    timings = {1, 2, 3, 4};
    if (request.path == "abort") std::abort();
    if (request.path == "die" && !std::filesystem::exists(request.query)) {
        std::ofstream(request.query) << getpid();
        raise(SIGKILL);
    }
    if (request.path == "die again") raise(SIGKILL);
    if (request.path == "throw") throw std::runtime_error("thrown");
    if (request.path == "refuse") return failure(ErrorCode::Unusable, "no", "/a field");
    if (request.path == "meet") {
        control.progress({.iteration = 1});
        const auto deadline = std::chrono::steady_clock::now() + test::kPatience;
        while (!can_meet(*control.executor, std::stoul(request.query))) {
            if (std::chrono::steady_clock::now() > deadline)
                return failure(ErrorCode::Internal, "waited for " + request.query + " threads at the same time");
        }
    }
    if (request.path == "endless") wait_for_stop({});
    if (request.path == "yield") {
        const int wanted = std::stoi(request.query);
        const auto deadline = std::chrono::steady_clock::now() + test::kPatience;
        while (getpriority(PRIO_PROCESS, 0) != wanted) {
            if (std::chrono::steady_clock::now() > deadline)
                return failure(ErrorCode::Internal, "waited for the nice value " + request.query);
        }
    }
    if (request.path == "wait") {
        control.progress({.iteration = 1});
        wait_for_stop(control.stop);
        return failure(ErrorCode::Stopped, "stopped");
    }
    for (int i = 1; i <= 3; ++i) control.progress({.iteration = i, .iterations = 3, .variation = 0.5});
    api::Answer answer;
    if (request.path.starts_with("stream")) {
        answer.media_type = "pieces";
        if (!delivery.sink->begin(answer)) return failure(ErrorCode::Stopped, "not begun");
        for (int i = 0; i < 100; ++i) {
            if (auto taken = delivery.sink->write(request.body); !taken) return tl::unexpected(taken.error());
            if (i == 50 && request.path == "stream and die") raise(SIGKILL);
            if (i == 50 && request.path == "stream and fail") return failure(ErrorCode::Internal, "broken");
        }
        answer.streamed = true;
        return answer;
    }
    answer.media_type = request.content_type + (delivery.compressed ? " compressed" : "");
    answer.coding = request.accept;
    answer.body = request.body;
    answer.sites = limits.max_sites;
    answer.pixels = static_cast<std::size_t>(getpid());
    answer.partial = true;
    answer.repeats = false;
    return answer;
}

/// Forks a process that becomes a fork server, instead of starting ccdt-worker.
Result<ChildProgram> launch(UniqueFd orders) {
    const pid_t process = fork();
    if (process != 0) return ChildProgram(process);
    dup2(orders.get(), ChildProgram::kSocket);
    close_range(ChildProgram::kSocket + 1, ~0U, 0);
    static_cast<void>(orders.release());
    run_fork_server(UniqueFd(ChildProgram::kSocket),
                    [](ComputeFiles files) { run_compute_process(std::move(files), obey); });
}

/// Receives a body in pieces. Fails after a maximum number of pieces.
class Sink : public api::BodySink {
public:
    explicit Sink(int most = 1'000) : most_(most) {}

    Result<void> begin(const api::Answer& head) override {
        media_types += head.media_type;
        return {};
    }

    Result<void> write(std::string_view piece) override {
        if (pieces == most_) return failure(ErrorCode::Stopped, "enough");
        ++pieces;
        body += piece;
        return {};
    }

    std::string media_types;
    std::string body;
    int pieces = 0;

private:
    int most_;
};

std::string repeated(const std::string& text, int times) {
    std::string all;
    for (int i = 0; i < times; ++i) all += text;
    return all;
}

class ComputeSupervisorTest : public testing::Test {
protected:
    Result<api::Answer> ask(const ComputeRequest& request, const Control& control = {}) {
        return supervisor_->compute(request, {}, control, timings_);
    }

    pid_t process_of_next() { return static_cast<pid_t>(ask({"/", "", "", "", ""})->pixels); }

    static bool is_there(pid_t process) {
        std::ifstream file("/proc/" + std::to_string(process) + "/stat");
        std::string id, name, state;
        return file >> id >> name >> state && state != "Z";
    }

    static testing::AssertionResult wait_for_end(pid_t process) {
        return test::wait_until("the end of a process", [process] { return !is_there(process); });
    }

    /// Runs a computation that ends when `count` threads run at the same time.
    void meet(int count, const Control& control = {}) {
        const auto met = ask({"meet", std::to_string(count), "", "", ""}, control);
        EXPECT_TRUE(met) << met.error().message;
    }

    static std::unique_ptr<ComputeSupervisor> start(seconds to_stop) {
        return *ComputeSupervisor::start(
            launch, {.limits = {.max_sites = 7, .max_pixels = 8}, .to_stop = to_stop, .nice_of_long = 10},
            [](const Order&, const std::stop_token&) {}, [](const std::string&) {});
    }

    api::Timings timings_;
    std::unique_ptr<ComputeSupervisor> supervisor_ = start(seconds(1));
};

TEST_F(ComputeSupervisorTest, TransfersTheWholeAnswer) {
    const auto answer = supervisor_->compute({"/", "", "type", "coding", "body"}, {.compressed = true}, {}, timings_);
    ASSERT_TRUE(answer) << answer.error().message;
    EXPECT_EQ(answer->media_type, "type compressed");
    EXPECT_EQ(answer->coding, "coding");
    EXPECT_EQ(answer->body, "body");
    EXPECT_EQ(answer->sites, 7U);
    EXPECT_TRUE(answer->partial);
    EXPECT_FALSE(answer->repeats);
    EXPECT_EQ(timings_.decode + 10 * timings_.prepare + 100 * timings_.optimise + 1000 * timings_.encode, 4321);
}

TEST_F(ComputeSupervisorTest, StreamsPiecesToTheTaker) {
    const std::string piece(200'000, 'x');
    Sink sink;
    const auto answer = supervisor_->compute({"stream", "", "", "", piece}, {.sink = &sink}, {}, timings_);
    ASSERT_TRUE(answer) << answer.error().message;
    EXPECT_TRUE(answer->streamed);
    EXPECT_TRUE(answer->body.empty());
    EXPECT_EQ(sink.media_types, "pieces");
    EXPECT_EQ(sink.pieces, 100);
    EXPECT_EQ(sink.body, repeated(piece, 100));
}

TEST_F(ComputeSupervisorTest, JoinsPiecesWithoutATaker) {
    const auto answer = ask({"stream", "", "", "", "piece"});
    ASSERT_TRUE(answer) << answer.error().message;
    EXPECT_FALSE(answer->streamed);
    EXPECT_EQ(answer->media_type, "pieces");
    EXPECT_EQ(answer->body, repeated("piece", 100));
}

TEST_F(ComputeSupervisorTest, DoesNotRetryAfterStreamingHasBegun) {
    Sink sink;
    const auto died = supervisor_->compute({"stream and die", "", "", "", "piece"}, {.sink = &sink}, {}, timings_);
    ASSERT_FALSE(died);
    EXPECT_EQ(died.error().code, ErrorCode::Unavailable);
    EXPECT_EQ(sink.media_types, "pieces");
    EXPECT_LE(sink.pieces, 51);
    const auto failed = supervisor_->compute({"stream and fail", "", "", "", "piece"}, {.sink = &sink}, {}, timings_);
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().message, "broken");
    EXPECT_TRUE(ask({"/", "", "", "", ""}));
}

TEST_F(ComputeSupervisorTest, KillsTheProcessOfAnAbandonedAnswer) {
    const pid_t process = process_of_next();
    Sink sink(3);
    const auto remaining =
        supervisor_->compute({"stream", "", "", "", std::string(200'000, 'x')}, {.sink = &sink}, {}, timings_);
    ASSERT_FALSE(remaining);
    EXPECT_EQ(remaining.error().code, ErrorCode::Stopped);
    EXPECT_EQ(supervisor_->counts().crashes, 0U);
    EXPECT_TRUE(wait_for_end(process));
    EXPECT_NE(process_of_next(), process);
}

TEST_F(ComputeSupervisorTest, TransfersBodiesOfAnySize) {
    for (const std::size_t size : {0, 1, 16'384, 16'385, 30'000'000}) {
        const auto answer = ask({"/", "", "type", "", std::string(size, 'x')});
        ASSERT_TRUE(answer);
        EXPECT_EQ(answer->body, std::string(size, 'x'));
    }
}

TEST_F(ComputeSupervisorTest, TransfersErrors) {
    const auto refused = ask({"refuse", "", "", "", ""});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::Unusable);
    EXPECT_EQ(refused.error().message, "no");
    EXPECT_EQ(refused.error().field, "/a field");
    const auto thrown = ask({"throw", "", "", "", ""});
    EXPECT_EQ(thrown.error().code, ErrorCode::Internal);
    EXPECT_EQ(thrown.error().message, "thrown");
    EXPECT_EQ(supervisor_->counts().crashes, 0U);
}

TEST_F(ComputeSupervisorTest, ReportsEveryProgressStep) {
    std::vector<int> steps;
    const Control control{{}, [&](const Progress& progress) { steps.push_back(progress.iteration); }};
    EXPECT_TRUE(ask({"/", "", "", "", ""}, control));
    EXPECT_EQ(steps, (std::vector<int>{1, 2, 3}));
}

TEST_F(ComputeSupervisorTest, LendsThreads) {
#ifdef __SANITIZE_THREAD__
    GTEST_SKIP() << "the thread sanitizer ends forked processes that create a thread after another one has ended";
#endif
    supervisor_->lend(3);
    meet(3);
    EXPECT_EQ(timings_.threads, 3U);
    EXPECT_GT(timings_.processor, 0);
    meet(2);
    EXPECT_EQ(timings_.threads, 2U) << "there were only two tasks";
    supervisor_->lend(1);
    meet(1);
    EXPECT_EQ(timings_.threads, 1U) << "an idle process must use fewer threads from now on";
    supervisor_->lend(2);
    meet(2);
    EXPECT_EQ(timings_.threads, 2U);
}

TEST_F(ComputeSupervisorTest, LendsThreadsToARunningComputation) {
    const Control control{{}, [&](const Progress&) { supervisor_->lend(2); }};
    meet(2, control);
    EXPECT_EQ(timings_.threads, 2U);
}

TEST_F(ComputeSupervisorTest, ReusesProcesses) {
    const pid_t first = process_of_next();
    EXPECT_EQ(process_of_next(), first);
    std::jthread([&] {
        constexpr int kNice = 5;
        setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
        const pid_t other = process_of_next();
        EXPECT_NE(other, first);
        EXPECT_EQ(getpriority(PRIO_PROCESS, static_cast<id_t>(other)), kNice) << "the nice value of the calling thread";
    }).join();
    EXPECT_EQ(process_of_next(), first);
}

TEST_F(ComputeSupervisorTest, LowersThePriorityOfALongComputation) {
    const pid_t first = process_of_next();
    const auto answer = ask({"yield", "10", "", "", ""});
    ASSERT_TRUE(answer) << answer.error().message;
    EXPECT_EQ(static_cast<pid_t>(answer->pixels), first);
    EXPECT_TRUE(wait_for_end(first)) << "its priority cannot be raised again";
    EXPECT_NE(process_of_next(), first);
    EXPECT_EQ(supervisor_->counts().crashes, 0U);
}

TEST_F(ComputeSupervisorTest, FailsOnlyTheComputationThatCrashes) {
    std::stop_source stop;
    std::jthread other([&] {
        const auto answer = ask({"wait", "", "", "", ""}, {stop.get_token(), [](const Progress&) {}});
        EXPECT_EQ(answer.error().code, ErrorCode::Stopped);
        EXPECT_EQ(answer.error().message, "stopped") << "it must stop by itself, not be killed";
    });
    api::Timings timings;
    for (int i = 1; i <= 3; ++i) {
        const auto crashed = supervisor_->compute({"abort", "", "", "", ""}, {}, {}, timings);
        ASSERT_FALSE(crashed);
        EXPECT_EQ(crashed.error().code, ErrorCode::Internal);
        EXPECT_EQ(crashed.error().message, "the process that computed it was killed by signal 6 (Aborted)");
        EXPECT_EQ(supervisor_->counts().crashes, static_cast<std::uint64_t>(i));
        EXPECT_TRUE(supervisor_->compute({"/", "", "", "", ""}, {}, {}, timings));
    }
    stop.request_stop();
}

TEST_F(ComputeSupervisorTest, RetriesAComputationWhoseProcessWasKilled) {
    std::string file = (std::filesystem::path(testing::TempDir()) / "killed-XXXXXX").string();
    ASSERT_NE(mkdtemp(file.data()), nullptr);
    const auto answer = ask({"die", file + "/once", "", "", "body"});
    ASSERT_TRUE(answer) << answer.error().message;
    EXPECT_EQ(answer->body, "body");
    EXPECT_EQ(supervisor_->counts().crashes, 1U);
    std::filesystem::remove_all(file);
    const auto twice = ask({"die again", "", "", "", ""});
    EXPECT_EQ(twice.error().code, ErrorCode::Unavailable);
    EXPECT_EQ(twice.error().message, "the process that computed it was killed by signal 9 (Killed)");
    EXPECT_EQ(supervisor_->counts().crashes, 3U);
}

TEST_F(ComputeSupervisorTest, ReplacesIdleProcessesThatDied) {
    const pid_t process = process_of_next();
    kill(process, SIGKILL);
    ASSERT_TRUE(test::wait_until("a killed process to be reaped", [&] { return kill(process, 0) != 0; }));
    EXPECT_NE(process_of_next(), process);
    EXPECT_EQ(supervisor_->counts().crashes, 0U);
}

TEST_F(ComputeSupervisorTest, KillsProcessesThatDoNotStop) {
    std::stop_source stop;
    const Control control{stop.get_token(), {}};
    const pid_t process = process_of_next();
    std::jthread impatient([&] { stop.request_stop(); });
    const auto answer = ask({"endless", "", "", "", ""}, control);
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error().code, ErrorCode::Stopped);
    EXPECT_TRUE(wait_for_end(process));
    EXPECT_EQ(supervisor_->counts().crashes, 0U);
    EXPECT_EQ(supervisor_->counts().overdue, 1U);
}

TEST_F(ComputeSupervisorTest, KillsUnwantedComputationsSoon) {
    supervisor_ = start(std::chrono::hours(1));
    const pid_t process = process_of_next();
    std::stop_source stop, unwanted;
    std::jthread leaving([&] {
        stop.request_stop();
        unwanted.request_stop();
    });
    const auto answer = supervisor_->compute({"endless", "", "", "", ""}, {.unwanted = unwanted.get_token()},
                                             {stop.get_token(), {}}, timings_);
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error().code, ErrorCode::Stopped);
    EXPECT_FALSE(is_there(process)) << "its memory must have been released";
    EXPECT_EQ(supervisor_->counts().crashes, 0U);
}

TEST_F(ComputeSupervisorTest, DoesNotStopTheNextComputationByALateStop) {
    for (int i = 0; i < 200; ++i) {
        std::stop_source stop;
        std::jthread late([&] { stop.request_stop(); });
        ask({"/", "", "", "", ""}, {stop.get_token(), {}});
        late.join();
        EXPECT_TRUE(ask({"/", "", "", "", ""}));
    }
}

TEST_F(ComputeSupervisorTest, KillsItsProcessesOnDestruction) {
    const pid_t process = process_of_next();
    supervisor_.reset();
    EXPECT_TRUE(wait_for_end(process));
}

}  // namespace
}  // namespace ccdt::server
