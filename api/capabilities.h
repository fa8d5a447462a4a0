#pragma once

#include <string>

#include "api/run/options.h"

namespace ccdt::api {

/// Writes as JSON what this server offers: the formats and options of each route, the methods with their limits and
/// the time that a site takes by estimate, and the limits.
std::string capabilities_json(const Limits& limits);

}  // namespace ccdt::api
