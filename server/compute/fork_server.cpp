// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/compute/fork_server.h"

#include <cerrno>
#include <cstddef>
#include <utility>

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "server/compute/compute_protocol.h"
#include "server/processes/forked_children.h"
#include "server/processes/messages.h"
#include "server/processes/signals.h"

namespace ccdt::server {
namespace {

constexpr int kFailed = 1;

/// Makes the kernel kill this process before the server if the machine runs out of memory. Ignores failures.
void volunteer_for_out_of_memory() {
    const UniqueFd file(open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC));
    if (file) static_cast<void>(!write(file.get(), "500", 3));
}

void report_end(const UniqueFd& events, const ChildEnd& end) {
    // The receiver may have ended already.
    static_cast<void>(send_message(events.get(), bytes_of(end)));
}

/// Turns a forked child into a computation process.
[[noreturn]] void become(const ForkOrder& order, ComputeFiles files, const ComputeProcess& compute) {
    setpriority(PRIO_PROCESS, 0, order.nice);
    volunteer_for_out_of_memory();
    compute(std::move(files));
    _exit(kFailed);
}

/// Forks a process for each order until the server ends.
void carry_out(ForkedChildren& children, const ComputeProcess& compute) {
    while (true) {
        ForkOrder order;
        auto received = children.wait_for_order(writable_bytes_of(order));
        if (!received) return;
        ComputeFiles files{std::move((*received)[0]), std::move((*received)[1]), std::move((*received)[2])};
        if (!files.channel || !files.events || !files.threads) continue;
        const pid_t process = children.fork();
        if (process == 0) become(order, std::move(files), compute);
        if (process > 0)
            children.add(process, std::move(files.events));
        else
            report_end(files.events, {errno, 0});
    }
}

}  // namespace

void run_fork_server(UniqueFd orders, const ComputeProcess& compute) {
    leave_signals_to_server();
    ForkedChildren children(std::move(orders), [](const UniqueFd& events, int status, std::chrono::microseconds) {
        report_end(events, {0, status});
    });
    const std::byte ready{};
    if (children && send_message(children.orders(), {&ready, 1})) carry_out(children, compute);
    _exit(0);
}

}  // namespace ccdt::server
