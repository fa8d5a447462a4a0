// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/decoding.h"

#include <limits>
#include <utility>

#include "server/decoder/decoder_protocol.h"
#include "server/decoder/shapefile_cost.h"
#include "server/processes/child_program.h"

namespace ccdt::server {

Result<void> Decoding::start() {
    if (supervisor_) return {};
    // No message reports a restart of the decoder, because the file that ended the decoder fails with an error.
    auto supervisor =
        DecoderSupervisor::start([](UniqueFd orders) { return spawn_sibling("ccdt-decoder", std::move(orders)); },
                                 [](const std::string& /*report*/) {});
    if (!supervisor) {
        supervisor.error().message += "; the program is in the package ccdt";
        return tl::unexpected(std::move(supervisor.error()));
    }
    supervisor_ = *std::move(supervisor);
    client_ = std::make_unique<DecoderClient>(
        [this](const Order& order, const std::stop_token& stop) { return supervisor_->relay(order, stop); });
    return {};
}

api::Decode Decoding::functions() {
    return {[this](std::string_view bytes, const api::Reading& reading, const std::stop_token& stop) {
                return start().and_then([&] { return client_->decode(bytes, reading, stop); });
            },
            [this](std::string_view bytes, const api::Reading& reading, const std::stop_token& stop) {
                return start().and_then([&] { return client_->decode_colour(bytes, reading, stop); });
            },
            [this](std::string_view bytes, const api::SurfaceHeader& header, const std::stop_token& stop) {
                return start().and_then([&] { return client_->read_surface(bytes, header, stop); });
            }};
}

Result<std::string> Decoding::read_shapefile(const std::string& archive, const std::string& object,
                                             std::size_t memory) {
    const std::size_t max_bytes = max_shapefile_bytes(std::numeric_limits<std::size_t>::max(), memory);
    return start().and_then([&] { return client_->read_shapefile(archive, {object, max_bytes}, {}); });
}

}  // namespace ccdt::server
