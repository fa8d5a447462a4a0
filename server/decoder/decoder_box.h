// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <utility>

#include "core/result.h"
#include "server/decoder/decoder_confinement.h"
#include "server/processes/supervised_program.h"

namespace ccdt::server {

struct Order;

/// Decodes pictures of strangers in processes that may crash, hang or eat memory: each costs its own picture only.
///
/// A helper forks a child for each picture. Should the helper end it is started again. See decoder_client.h for who
/// gives orders, decoder_helper.h for how the processes end, decoder_confinement.h and decoder_sandbox.h for what they
/// may do. Members may be called from any thread.
class DecoderBox {
public:
    /// Starts the helper; ends it, and with it what it still does, in the end. Errors: Internal.
    /// @param launch  starts a process that becomes the helper, by run_decoder_helper
    static Result<std::unique_ptr<DecoderBox>> start(SupervisedProgram::Launch launch, SupervisedProgram::Tell tell);

    /// Waits until the helper is ready for the first time. Errors: Internal; it is then not started again.
    Result<void> wait_until_ready() { return helper_->wait_until_ready(); }

    /// Hands an order on to the helper, waiting for one that is being started again. If there is none for as long as
    /// the order may wait, its outcome tells that.
    /// @returns  false if there was none, or none until the stop
    bool relay(const Order& order, const std::stop_token& stop);

    /// Times that the helper ended, and was or is being started again.
    std::uint64_t restarts() const { return helper_->restarts(); }

    /// Whether the helper has answered lately, and times that it stopped answering.
    bool is_responsive() const { return helper_->is_responsive(); }
    std::uint64_t silences() const { return helper_->silences(); }

    /// Whether there is a helper now, or about to be for the first time.
    bool is_ready() const { return helper_->is_ready(); }

    /// Confinement that the first helper found in force; to be asked once it is ready.
    const Confinement& confinement() const { return *confinement_; }

private:
    DecoderBox(std::unique_ptr<SupervisedProgram> helper, std::shared_ptr<const Confinement> confinement)
        : helper_(std::move(helper)), confinement_(std::move(confinement)) {}

    const std::unique_ptr<SupervisedProgram> helper_;
    const std::shared_ptr<const Confinement> confinement_;
};

}  // namespace ccdt::server
