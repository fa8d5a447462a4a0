#pragma once

#include "core/result.h"
#include "server/config/config.h"

namespace ccdt::server {

/// Asks the server that listens where this configuration says whether it lives, as a health check of a container that
/// has no other program to ask with. Waits for 3 s at most for each of connecting, asking and being told.
/// Errors (Unusable): nobody answers there, or with anything but 200.
Result<void> ask_health(const Config& config);

}  // namespace ccdt::server
