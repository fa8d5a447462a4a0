// SPDX-License-Identifier: GPL-3.0-or-later
#include <csignal>
#include <string_view>
#include <utility>

#include "server/compute/compute_process.h"
#include "server/compute/fork_server.h"
#include "server/processes/child_program.h"

namespace ccdt::server {
namespace {

bool asks_for(const ComputeRequest& request, std::string_view seed) {
    return request.body.find(seed) != std::string::npos || request.query.find(seed) != std::string::npos;
}

/// Computes like ccdt-worker, but crashes or hangs for certain seeds.
Result<api::Answer> compute(const ComputeRequest& request, const Delivery& delivery, const api::Limits& limits,
                            const api::Decode& decode, const Control& control, api::Timings& timings) {
    if (asks_for(request, "1300000001")) raise(SIGSEGV);
    volatile bool endless = asks_for(request, "1300000002");
    while (endless) {
    }
    return compute_here(request, delivery, limits, decode, control, timings);
}

}  // namespace
}  // namespace ccdt::server

int main() {
    using namespace ccdt::server;
    run_fork_server(UniqueFd(ChildProgram::kSocket),
                    [](ComputeFiles files) { run_compute_process(std::move(files), compute); });
}
