// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "api/run/options.h"

namespace ccdt::api {

/// Access to the server's own pictures, as sources of halftones: none, by any URL, or by signed URLs only.
enum class OfferedPictures { None, Unsigned, Signed };

/// Describes in JSON what this server offers: the formats and options of each route, the methods with their limits and
/// estimated time per site, the limits, and whether the server has pictures of its own.
std::string capabilities_json(const Limits& limits, OfferedPictures pictures = OfferedPictures::None);

}  // namespace ccdt::api
