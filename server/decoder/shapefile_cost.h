// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string_view>

#include "api/run/options.h"

namespace ccdt::server {

/// Returns the maximum size of a shapefile, both inflated and as GeoJSON, in bytes.
/// @param max_body  maximum size of a body, in bytes
/// @param memory    memory limit of all computations together, in bytes, which the conversion must not exceed
std::size_t max_shapefile_bytes(std::size_t max_body, std::size_t memory);

/// Estimates the cost of converting a shapefile, including the memory of the GeoJSON.
api::Cost cost_of_shapefile(std::string_view archive, std::size_t max_bytes);

}  // namespace ccdt::server
