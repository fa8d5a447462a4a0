// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/decoder/decoder_supervisor.h"

#include <mutex>
#include <optional>
#include <utility>

#include "server/decoder/decoder_protocol.h"
#include "server/processes/messages.h"

namespace ccdt::server {

Result<std::unique_ptr<DecoderSupervisor>> DecoderSupervisor::start(SupervisedProgram::Launch launch,
                                                                    SupervisedProgram::Report report) {
    // Helpers that are started later report the same confinement.
    const auto confinement = std::make_shared<Confinement>();
    const auto greet = [confinement, once = std::make_shared<std::once_flag>()](int socket) {
        Hello hello;
        if (receive_message(socket, writable_bytes_of(hello)) != sizeof(hello)) return false;
        std::call_once(*once, [&] { *confinement = hello.confinement; });
        return true;
    };
    auto helper = SupervisedProgram::start("decoder", std::move(launch), greet, std::move(report));
    if (!helper) return tl::unexpected(std::move(helper.error()));
    return std::unique_ptr<DecoderSupervisor>(new DecoderSupervisor(*std::move(helper), confinement));
}

bool DecoderSupervisor::relay(const Order& order, const std::stop_token& stop) {
    const auto until = SupervisedProgram::Clock::now() + std::chrono::milliseconds(order.text.patience_ms);
    for (SupervisedProgram::Socket lost;;) {
        const auto socket = helper_->wait_for_socket(lost, until, stop);
        if (socket == nullptr) {
            const Outcome none{.no_helper = 1};
            send_message(order.outcome.get(), bytes_of(none));
            return false;
        }
        if (send_order(socket->get(), order)) return true;
        lost = socket;
    }
}

}  // namespace ccdt::server
