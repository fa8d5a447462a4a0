#pragma once

#include <string>

#include "api/run/options.h"

namespace ccdt::api {

/// Pictures of its own that a server makes dots of: none, or those that any URL names, or a signed one.
enum class OfferedPictures { None, Unsigned, Signed };

/// Writes as JSON what this server offers: the formats and options of each route, the methods with their limits and
/// the time that a site takes by estimate, the limits, and whether it has pictures of its own.
std::string capabilities_json(const Limits& limits, OfferedPictures pictures = OfferedPictures::None);

}  // namespace ccdt::api
