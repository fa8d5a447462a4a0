// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "api/run/options.h"

namespace ccdt::api {

/// Access of clients to the server's own pictures, which `GET /halftone/{name}` draws. None: there are no pictures.
/// Unsigned: URLs need no signature. Signed: each URL must be signed.
enum class OfferedPictures { None, Unsigned, Signed };

/// Named options that the server offers.
struct OfferedPresets {
    std::vector<std::string> names;
    bool required = false;  ///< whether each request must name one, and give no other options
};

/// Describes in JSON what this server offers: the formats and options of each endpoint, the methods with their limits
/// and estimated time per site, the limits of the server, the access to its pictures, whether it offers its
/// documentation, and its presets.
std::string capabilities_json(const Limits& limits, OfferedPictures pictures = OfferedPictures::None,
                              bool documentation = false, const OfferedPresets& presets = {});

}  // namespace ccdt::api
