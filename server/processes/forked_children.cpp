// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/forked_children.h"

#include <algorithm>
#include <csignal>
#include <utility>

#include <poll.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/processes/messages.h"

namespace ccdt::server {
namespace {

/// Blocks SIGCHLD. Returns a nonblocking descriptor that becomes readable when a child has ended.
UniqueFd watch_children() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGCHLD);
    sigprocmask(SIG_BLOCK, &signals, nullptr);
    return UniqueFd(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
}

std::chrono::microseconds time_of(const timeval& time) {
    return std::chrono::seconds(time.tv_sec) + std::chrono::microseconds(time.tv_usec);
}

}  // namespace

ForkedChildren::ForkedChildren(UniqueFd orders, ReportEnd report_end)
    : orders_(std::move(orders)), ends_(watch_children()), report_end_(report_end) {}

std::optional<ForkedChildren::Files> ForkedChildren::wait_for_order(std::span<std::byte> order,
                                                                    const std::function<void()>& prepare) {
    constexpr int kQuiet = 5;  // in milliseconds; after such a pause, probably no process waits for a child
    bool prepared = !prepare;
    while (true) {
        std::vector<pollfd> polled{{orders_.get(), POLLIN, 0}, {ends_.get(), POLLIN, 0}};
        for (const Child& child : children_) polled.push_back({child.socket.get(), POLLIN, 0});
        const bool quiet = poll(polled.data(), polled.size(), prepared ? -1 : kQuiet) == 0;
        for (std::size_t i = 0; i < children_.size(); ++i)
            if (polled[i + 2].revents != 0) kill(children_[i]);
        reap();
        if (!prepared && (quiet || children_.empty())) {
            prepare();
            prepared = true;
        }
        if (polled[0].revents == 0) continue;
        Files files;
        const std::size_t size = receive_message(orders_.get(), order, files);
        if (size == 0) return std::nullopt;
        if (size != kProbeSize) return files;
        answer_probe(files[0]);
    }
}

pid_t ForkedChildren::fork() {
    const pid_t process = ::fork();
    if (process != 0) return process;
    children_.clear();
    orders_.reset();
    ends_.reset();
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    return process;
}

/// Kills a child for which no process waits any more. The child has not been reaped, so no other process has its id.
void ForkedChildren::kill(Child& child) {
    ::kill(child.process, SIGKILL);
    child.socket.reset();
}

void ForkedChildren::reap() {
    signalfd_siginfo discarded;
    while (read(ends_.get(), &discarded, sizeof(discarded)) > 0) {
    }
    int status = 0;
    rusage usage{};
    for (pid_t process = 0; (process = wait4(-1, &status, WNOHANG, &usage)) > 0;) {
        const auto child = std::ranges::find(children_, process, &Child::process);
        if (child == children_.end()) continue;
        if (child->socket) report_end_(child->socket, status, time_of(usage.ru_utime) + time_of(usage.ru_stime));
        children_.erase(child);
    }
}

}  // namespace ccdt::server
