// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <utility>

#include "core/base/result.h"
#include "server/decoder/decoder_confinement.h"
#include "server/processes/supervised_program.h"

namespace ccdt::server {

struct Order;

/// Decodes untrusted pictures, shapefiles and mesh files in separate processes. A process that crashes, hangs or
/// exceeds its memory affects only its own file.
///
/// A helper process forks a child for each file. If the helper ends, it is restarted. DecoderClient creates the orders.
/// decoder_helper.h describes the processes; decoder_confinement.h and decoder_sandbox.h describe their confinement.
/// Thread-safe.
class DecoderSupervisor {
public:
    /// Starts the helper. The destructor ends the helper and all its children. Error: Internal.
    /// @param launch  starts a process that calls run_decoder_helper
    static Result<std::unique_ptr<DecoderSupervisor>> start(SupervisedProgram::Launch launch,
                                                            SupervisedProgram::Report report);

    /// Waits until the helper is ready for the first time. Errors: as SupervisedProgram::wait_until_ready.
    Result<void> wait_until_ready(const std::stop_token& stop = {}) { return helper_->wait_until_ready(stop); }

    /// Passes an order to the helper, and waits if the helper is being restarted. If no helper runs by the time limit
    /// of the order, reports this as the outcome of the order.
    /// @returns  false if no helper ran by the time limit, or if a stop was requested
    bool relay(const Order& order, const std::stop_token& stop);

    /// Returns the number of restarts of the helper, including one in progress.
    std::uint64_t restarts() const { return helper_->restarts(); }

    /// Whether the helper has replied recently.
    bool is_responsive() const { return helper_->is_responsive(); }

    /// Returns the number of times that the helper stopped replying.
    std::uint64_t silences() const { return helper_->silences(); }

    /// Whether the helper is ready now, or starting for the first time.
    bool is_ready() const { return helper_->is_ready(); }

    /// Returns the confinement that the first helper reported. Must not be called before wait_until_ready() has
    /// succeeded.
    const Confinement& confinement() const { return *confinement_; }

private:
    DecoderSupervisor(std::unique_ptr<SupervisedProgram> helper, std::shared_ptr<const Confinement> confinement)
        : helper_(std::move(helper)), confinement_(std::move(confinement)) {}

    const std::unique_ptr<SupervisedProgram> helper_;
    const std::shared_ptr<const Confinement> confinement_;
};

}  // namespace ccdt::server
