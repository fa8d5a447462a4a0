// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdio>

#include <fcntl.h>

#include "server/compute/compute_process.h"
#include "server/compute/fork_server.h"
#include "server/processes/child_program.h"
#include "server/processes/process.h"

/// The main function of ccdt-worker, which the server starts.
int main() {
    using namespace ccdt::server;
    UniqueFd orders(ChildProgram::kSocket);
    if (fcntl(orders.get(), F_GETFD) < 0) {
        std::fputs("ccdt-worker: ccdt-server starts this program\n", stderr);
        return 2;
    }
    // Planes of pictures are allocated and freed many times in a computation, and new pages cost more than reused ones:
    // a drawing of 16,000 dots in colour takes an eighth less processor time than with a megabyte. After a computation,
    // all free memory is given back.
    constexpr int kGivenBack = 32 << 20;
    give_back_freed_memory(kGivenBack);
    share_heap_among_threads();
    run_fork_server(std::move(orders), [](ComputeFiles files) { run_compute_process(std::move(files), compute_here); });
}
