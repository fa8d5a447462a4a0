// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <stop_token>

#include "api/output/body.h"

namespace ccdt::api {

/// Calls write(i) for each of `count` records. Ends early on a stop, or if the sink of the body fails.
template <class Write>
void write_records(std::size_t count, Body& body, const std::stop_token& stop, Write write) {
    constexpr std::size_t kStopStride = 4'096;  // records between two checks of the stop token
    for (std::size_t i = 0; i < count; ++i) {
        if (i % kStopStride == 0 && (!body.flush() || stop.stop_requested())) break;
        write(i);
    }
}

}  // namespace ccdt::api
