// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "server/config/config.h"

namespace ccdt::server {

/// Asks the server on the configured address whether it is alive. The container image uses this as its health check,
/// because it contains no other program for that. Waits for at most 3 s for each of connecting, sending and receiving.
/// Errors (Unusable): there is no answer, or its status is not 200.
Result<void> check_health(const Config& config);

}  // namespace ccdt::server
