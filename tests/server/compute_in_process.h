// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/decode/decode.h"
#include "api/run/options.h"
#include "server/requests/compute.h"

namespace ccdt::server::test {

/// Returns a Compute function that computes in the calling thread instead of a separate process.
inline Compute compute_in_process(const api::Limits& limits = {}) {
    return [limits](const ComputeRequest& request, const Delivery& delivery, const Control& control,
                    api::Timings& timings) {
        return compute_here(request, delivery, limits, api::decode_inline(), control, timings);
    };
}

}  // namespace ccdt::server::test
