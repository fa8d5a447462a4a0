// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/decode/decode.h"

namespace ccdt::api {

/// Returns the same decoders, which add the milliseconds that they take to a sum. `decode` and `spent` must outlive
/// them. Not thread-safe.
Decode timed(const Decode& decode, double& spent);

}  // namespace ccdt::api
