// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "api/run/options.h"

namespace ccdt::api {

/// Access to the pictures that the server itself offers as sources of halftones: no pictures, unsigned URLs, or signed
/// URLs only.
enum class OfferedPictures { None, Unsigned, Signed };

/// Describes in JSON what this server offers: the formats and options of each route, the methods with their limits and
/// estimated time per site, the limits, and whether the server has pictures of its own.
std::string capabilities_json(const Limits& limits, OfferedPictures pictures = OfferedPictures::None);

}  // namespace ccdt::api
