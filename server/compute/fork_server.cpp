// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/compute/fork_server.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/compute/compute_protocol.h"
#include "server/processes/child_program.h"
#include "server/processes/messages.h"
#include "server/processes/signals.h"

namespace ccdt::server {
namespace {

constexpr int kFailed = 1;

/// Makes the kernel end this process before the server if the machine runs out of memory. Failures are ignored.
void volunteer_for_out_of_memory() {
    const UniqueFd file(open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC));
    if (file) static_cast<void>(!write(file.get(), "500", 3));
}

class ForkServer {
public:
    ForkServer(UniqueFd orders, const ComputeProcess& compute)
        : orders_(std::move(orders)), compute_(compute), deaths_(watch_children()) {}

    /// Forks and reaps children until the server ends.
    void run() {
        const std::byte ready{};
        if (!deaths_ || !send_message(orders_.get(), {&ready, 1})) return;
        while (true) {
            std::array<pollfd, 2> polled = {{{orders_.get(), POLLIN, 0}, {deaths_.get(), POLLIN, 0}}};
            poll(polled.data(), polled.size(), -1);
            reap();
            if (polled[0].revents == 0) continue;
            ForkOrder order;
            std::array<UniqueFd, 3> files;
            const std::size_t size = receive_message(orders_.get(), writable_bytes_of(order), files);
            if (size == 0) return;
            if (size == kProbeSize)
                answer_probe(files[0]);
            else
                start(order, {std::move(files[0]), std::move(files[1]), std::move(files[2])});
        }
    }

private:
    struct Child {
        pid_t process = 0;
        UniqueFd events;
    };

    void start(const ForkOrder& order, ComputeFiles files) {
        if (!files.channel || !files.events || !files.threads) return;
        const pid_t process = fork();
        if (process == 0) become(order, std::move(files));
        if (process < 0) return report_end(files.events, {errno, 0});
        children_.push_back({process, std::move(files.events)});
    }

    /// Turns the child into a process that computes.
    [[noreturn]] void become(const ForkOrder& order, ComputeFiles files) {
        children_.clear();
        orders_.reset();
        sigset_t none;
        sigemptyset(&none);
        sigprocmask(SIG_SETMASK, &none, nullptr);
        setpriority(PRIO_PROCESS, 0, order.nice);
        volunteer_for_out_of_memory();
        compute_(std::move(files));
        _exit(kFailed);
    }

    void reap() {
        signalfd_siginfo read_away;
        while (read(deaths_.get(), &read_away, sizeof(read_away)) > 0) {
        }
        int status = 0;
        for (pid_t process = 0; (process = waitpid(-1, &status, WNOHANG)) > 0;) {
            const auto child = std::ranges::find(children_, process, &Child::process);
            if (child == children_.end()) continue;
            report_end(child->events, {0, status});
            children_.erase(child);
        }
    }

    static void report_end(const UniqueFd& events, const ChildEnd& death) {
        // The receiver may have ended already.
        static_cast<void>(send_message(events.get(), bytes_of(death)));
    }

    UniqueFd orders_;
    const ComputeProcess& compute_;
    const UniqueFd deaths_;
    std::vector<Child> children_;
};

}  // namespace

void run_fork_server(UniqueFd orders, const ComputeProcess& compute) {
    leave_signals_to_server();
    ForkServer(std::move(orders), compute).run();
    _exit(0);
}

}  // namespace ccdt::server
