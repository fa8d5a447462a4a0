// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "api/run/options.h"

namespace ccdt::api {

/// Access of clients to the server's own pictures, which `GET /halftone/{name}` draws. None: there are no pictures.
/// Unsigned: URLs need no signature. Signed: each URL must be signed.
enum class OfferedPictures { None, Unsigned, Signed };

/// Describes in JSON what this server offers: the formats and options of each endpoint, the methods with their limits
/// and estimated time per site, the limits of the server, the access to its pictures, and whether it offers its
/// documentation.
std::string capabilities_json(const Limits& limits, OfferedPictures pictures = OfferedPictures::None,
                              bool documentation = false);

}  // namespace ccdt::api
