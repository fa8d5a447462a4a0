// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/base/result.h"
#include "server/config/config.h"

namespace ccdt::server {

/// Asks the server on the configured address whether it is alive. The container image uses this as its health check,
/// because it contains no HTTP client. Connecting, sending and receiving each have a time-out of 3 s.
/// Errors (Unusable): there is no answer, or its status is not 200.
Result<void> check_health(const Config& config);

}  // namespace ccdt::server
