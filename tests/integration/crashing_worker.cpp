// SPDX-License-Identifier: GPL-3.0-or-later
#include <chrono>
#include <csignal>
#include <string_view>
#include <utility>

#include "server/compute/compute_process.h"
#include "server/compute/fork_server.h"
#include "server/processes/child_program.h"
#include "server/processes/process.h"

namespace ccdt::server {
namespace {

bool asks_for(const ComputeRequest& request, std::string_view seed) {
    return request.body.find(seed) != std::string::npos || request.query.find(seed) != std::string::npos;
}

void spin_for_seconds(int seconds) {
    const auto end = processor_time() + std::chrono::seconds(seconds);
    while (processor_time() < end) {
    }
}

/// Computes like ccdt-worker, but crashes, hangs or takes much longer than estimated for certain seeds.
Result<api::Answer> compute(const ComputeRequest& request, const Delivery& delivery, const api::Limits& limits,
                            const api::Decode& decode, const Control& control, api::Timings& timings) {
    if (asks_for(request, "1300000001")) raise(SIGSEGV);
    volatile bool endless = asks_for(request, "1300000002");
    while (endless) {
    }
    if (asks_for(request, "1300000003")) spin_for_seconds(1);
    return compute_here(request, delivery, limits, decode, control, timings);
}

}  // namespace
}  // namespace ccdt::server

int main() {
    using namespace ccdt::server;
    run_fork_server(UniqueFd(ChildProgram::kSocket),
                    [](ComputeFiles files) { run_compute_process(std::move(files), compute); });
}
