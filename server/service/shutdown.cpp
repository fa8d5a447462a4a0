// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/shutdown.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include <unistd.h>

#include "server/processes/signals.h"

namespace ccdt::server {
namespace {

/// Time between the call of `abandon` and the exit, in which waiting clients are answered.
constexpr std::chrono::milliseconds kTimeToAnswer{1'000};

/// Waits for a stop request, for at most `time`.
/// @returns  whether a stop was requested
bool ended_within(std::chrono::milliseconds time, const std::stop_token& ended) {
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any never;
    never.wait_for(lock, ended, time, [] { return false; });
    return ended.stop_requested();
}

}  // namespace

ServerSignals::ServerSignals() : signals_{} {
    ignore_signals(kSignalsWithoutMeaning);
    sigemptyset(&signals_);
    for (const int number : kEndSignals) sigaddset(&signals_, number);
    sigaddset(&signals_, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
}

void ServerSignals::wait_for_end(const std::function<void()>& reload) const {
    int number = 0;
    while (sigwait(&signals_, &number) == 0 && number == SIGHUP) reload();
    std::signal(SIGHUP, SIG_IGN);
    // Sets handlers, because the default action does not end the first process of a container.
    for (const int other : kEndSignals) std::signal(other, [](int again) { _exit(128 + again); });
    pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);
}

ShutdownDeadline::ShutdownDeadline(std::chrono::milliseconds timeout, std::function<void()> abandon, const Log& log)
    : timeout_(timeout), abandon_(std::move(abandon)), log_(log), thread_([this](const std::stop_token& ended) {
          if (wait_for_start(ended)) enforce(ended);
      }) {}

void ShutdownDeadline::start() {
    const std::lock_guard lock(mutex_);
    started_ = true;
    changed_.notify_all();
}

bool ShutdownDeadline::wait_for_start(const std::stop_token& ended) {
    std::unique_lock lock(mutex_);
    return changed_.wait(lock, ended, [this] { return started_; });
}

void ShutdownDeadline::enforce(const std::stop_token& ended) {
    const auto time_to_answer = std::min(kTimeToAnswer, timeout_ / 2);
    if (ended_within(timeout_ - time_to_answer, ended)) return;
    log_.info("the time for shutdown is nearly over: unfinished requests are cancelled");
    abandon_();
    if (ended_within(time_to_answer, ended)) return;
    log_.error("the time for shutdown is over: unsent answers are dropped");
    std::_Exit(EXIT_SUCCESS);
}

}  // namespace ccdt::server
