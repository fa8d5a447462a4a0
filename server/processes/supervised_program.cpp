// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/supervised_program.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <initializer_list>
#include <utility>
#include <vector>

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include "server/processes/messages.h"

namespace ccdt::server {
namespace {

using Clock = SupervisedProgram::Clock;

/// Pause between two probes.
constexpr std::chrono::seconds kPause{1};

/// Time-out of the reply to a probe. It suffices on a busy machine.
constexpr std::chrono::seconds kLongestSilence{4};

/// Maximum time until a program is ready.
constexpr std::chrono::seconds kLongestStart{30};

tl::unexpected<Error> cannot_start(const std::string& name, const std::string& why,
                                   ErrorCode code = ErrorCode::Internal) {
    return failure(code, "cannot start the " + name + ": " + why);
}

/// Waits until a descriptor is readable, and returns the descriptor; -1 after the deadline.
int wait_for_any(std::initializer_list<int> descriptors, std::optional<Clock::time_point> until = {}) {
    std::vector<pollfd> polled;
    for (const int descriptor : descriptors) polled.push_back({descriptor, POLLIN, 0});
    int ready = 0;
    do ready = poll(polled.data(), polled.size(), milliseconds_until(until));
    while (ready < 0 && errno == EINTR);
    const auto news = std::ranges::find_if(polled, [](const pollfd& each) { return each.revents != 0; });
    return news == polled.end() ? -1 : news->fd;
}

}  // namespace

Result<std::unique_ptr<SupervisedProgram>> SupervisedProgram::start(std::string name, Launch launch, Greet greet,
                                                                    Report report) {
    UniqueFd closing(eventfd(0, EFD_CLOEXEC));
    if (!closing) return cannot_start(name, std::strerror(errno));
    std::unique_ptr<SupervisedProgram> kept(new SupervisedProgram(std::move(name), std::move(launch), std::move(greet),
                                                                  std::move(report), std::move(closing)));
    auto running = kept->launch();
    if (!running) return tl::unexpected(std::move(running.error()));
    kept->watcher_ = std::jthread(&SupervisedProgram::watch, kept.get(), *std::move(running));
    return kept;
}

SupervisedProgram::SupervisedProgram(std::string name, Launch launch, Greet greet, Report report, UniqueFd closing)
    : name_(std::move(name)),
      launch_(std::move(launch)),
      greet_(std::move(greet)),
      report_(std::move(report)),
      closing_(std::move(closing)) {}

SupervisedProgram::~SupervisedProgram() {
    eventfd_write(closing_.get(), 1);
}

Result<SupervisedProgram::Running> SupervisedProgram::launch() const {
    auto sockets = make_sockets(SOCK_SEQPACKET);
    if (!sockets) return cannot_start(name_, std::strerror(errno));
    const auto started = Clock::now();
    auto program = launch_(std::move(sockets->theirs));
    if (!program) return tl::unexpected(std::move(program.error()));
    return Running{*std::move(program), std::make_shared<const UniqueFd>(std::move(sockets->ours)), started};
}

/// Waits until the program reports that it is ready. Kills the program if it does not report in time.
/// Errors: Unavailable if the program was killed from outside; otherwise Internal.
Result<void> SupervisedProgram::await(Running& running) {
    const int ours = running.socket->get();
    int ready = -1;
    for (const auto longest : {kPause + kLongestSilence, kLongestStart}) {
        ready = wait_for_any({ours, running.program.ended(), closing_.get()}, running.started + longest);
        if (ready >= 0) break;
        set_responsive(false);
    }
    if (ready == ours && greet_(ours)) {
        set_responsive(true);
        return {};
    }
    // If the socket was closed, the program has ended or is about to end.
    const bool ends_itself = ready == ours || ready == running.program.ended();
    if (!ends_itself) running.program.kill();
    const auto status = running.program.wait();
    return cannot_start(name_, "it " + describe_end(status),
                        ends_itself && is_killed_from_outside(status) ? ErrorCode::Unavailable : ErrorCode::Internal);
}

/// Waits until the program is ready for the first time. Restarts it while it is killed from outside, within the time
/// for a start.
Result<void> SupervisedProgram::await_first_start(Running& running) {
    const auto until = running.started + kLongestStart;
    Backoff backoff;
    auto ready = await(running);
    while (!ready && ready.error().code == ErrorCode::Unavailable && Clock::now() < until) {
        ++restarts_;
        report_(ready.error().message + "; it is started again");
        if (wait_for_any({closing_.get()}, Clock::now() + backoff.after({})) >= 0) break;
        ready = launch().and_then([&](Running&& next) {
            running = std::move(next);
            return await(running);
        });
    }
    return ready;
}

/// Restarts the program, after pauses, until it is ready.
/// @returns  none if the program must not be restarted any more
std::optional<SupervisedProgram::Running> SupervisedProgram::launch_again(Backoff& backoff, Clock::duration lived) {
    while (true) {
        if (wait_for_any({closing_.get()}, Clock::now() + backoff.after(lived)) >= 0) return std::nullopt;
        auto running = launch();
        const auto ready = running.and_then([this](Running& started) { return await(started); });
        if (ready) return *std::move(running);
        report_(ready.error().message);
        lived = {};
    }
}

void SupervisedProgram::watch(Running running) {
    constexpr std::chrono::seconds kToEnd{1};
    auto ready = await_first_start(running);
    if (ready) set_socket(running.socket);
    const bool is_there = ready.has_value();
    end_start(std::move(ready));
    if (!is_there) return;
    Backoff backoff;
    while (attend(running)) {
        set_socket(nullptr);
        responsive_ = true;
        ++restarts_;
        report_("the " + name_ + " " + describe_end(running.program.wait()) + ", and is started again");
        auto next = launch_again(backoff, Clock::now() - running.started);
        if (!next) return;
        running = *std::move(next);
        set_socket(running.socket);
    }
    set_socket(nullptr);
    running.socket.reset();
    wait_for_any({running.program.ended()}, Clock::now() + kToEnd);  // it ends because its socket is closed
}

/// Probes the program until its end.
/// @returns  false if the program must not be restarted any more
bool SupervisedProgram::attend(const Running& running) {
    UniqueFd answer;
    auto unresponsive_at = Clock::time_point::max();
    while (true) {
        const int news = wait_for_any({running.program.ended(), closing_.get(), answer.get()}, Clock::now() + kPause);
        if (news >= 0 && news != answer.get()) return news != closing_.get();
        if (news < 0) {
            unresponsive_at = std::min(unresponsive_at, Clock::now() + kLongestSilence);
            if (!answer) answer = send_probe(running.socket->get());
            if (Clock::now() >= unresponsive_at) set_responsive(false);
            continue;
        }
        if (is_answered(answer)) {
            unresponsive_at = Clock::time_point::max();
            set_responsive(true);
        }
        answer.reset();
    }
}

void SupervisedProgram::set_responsive(bool responsive) {
    if (responsive_.exchange(responsive) == responsive) return;
    if (!responsive) ++silences_;
    report_("the " + name_ + (responsive ? " answers again" : " does not answer"));
}

void SupervisedProgram::set_socket(Socket socket) {
    const std::lock_guard lock(mutex_);
    socket_ = std::move(socket);
    changed_.notify_all();
}

void SupervisedProgram::end_start(Result<void> started) {
    const std::lock_guard lock(mutex_);
    started_ = std::move(started);
    changed_.notify_all();
}

Result<void> SupervisedProgram::wait_until_ready(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    if (!changed_.wait(lock, stop, [this] { return started_.has_value(); }))
        return failure(ErrorCode::Stopped, "stopped before the program was ready");
    return *started_;
}

SupervisedProgram::Socket SupervisedProgram::wait_for_socket(const Socket& lost, Clock::time_point deadline,
                                                             const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [this] { return started_.has_value(); });
    changed_.wait_until(lock, stop, deadline, [&] { return socket_ != nullptr && socket_ != lost; });
    return socket_ == lost ? nullptr : socket_;
}

bool SupervisedProgram::is_ready() const {
    const std::lock_guard lock(mutex_);
    return socket_ != nullptr || !started_;
}

}  // namespace ccdt::server
