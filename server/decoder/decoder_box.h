#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <stop_token>

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
    /// Starts the helper and waits until it is ready; ends it, and with it what it still does, in the end.
    /// Errors: Internal.
    /// @param launch  starts a process that becomes the helper, by run_decoder_helper
    static Result<std::unique_ptr<DecoderBox>> start(SupervisedProgram::Launch launch, SupervisedProgram::Tell tell);

    /// Hands an order on to the helper, waiting for one that is being started again.
    /// @returns  false if there was none for `kPatience`, or until the stop
    bool relay(const Order& order, const std::stop_token& stop);

    /// Times that the helper ended, and was or is being started again.
    std::uint64_t restarts() const { return helper_->restarts(); }

    /// Whether there is a helper now.
    bool is_ready() const { return helper_->is_ready(); }

    /// Confinement that the first helper found in force.
    const Confinement& confinement() const { return confinement_; }

    static constexpr std::chrono::seconds kPatience{5};

private:
    DecoderBox(std::unique_ptr<SupervisedProgram> helper, const Confinement& confinement)
        : helper_(std::move(helper)), confinement_(confinement) {}

    const std::unique_ptr<SupervisedProgram> helper_;
    const Confinement confinement_;
};

}  // namespace ccdt::server
