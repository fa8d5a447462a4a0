// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <stop_token>
#include <string>
#include <string_view>

#include "api/map/shapefile_parts.h"
#include "api/run/options.h"
#include "core/result.h"
#include "server/work/compute_request.h"

namespace ccdt::server {

/// Reads a zipped shapefile to GeoJSON, in the decoder: see DecoderClient.
using ReadShapefile = std::function<Result<std::string>(std::string_view archive, const api::ShapefileReading& reading,
                                                        const std::stop_token& stop)>;

/// Finds the most bytes that a shapefile may have, inflated or as GeoJSON.
/// @param max_body  bytes of the largest body
/// @param memory    bytes for all that is computed, which reading a shapefile must fit into
std::size_t max_shapefile_bytes(std::size_t max_body, std::size_t memory);

/// Estimates the cost of reading a shapefile, its text included.
api::Cost cost_of_shapefile(std::string_view archive, std::size_t max_bytes);

/// Makes of a request whose body is a zipped shapefile the same request with GeoJSON as the body. The option `object`
/// of its query chooses a shapefile, and is not passed on.
/// Errors: those of `read`; Malformed for two such options.
Result<ComputeRequest> with_geojson(const ComputeRequest& request, std::size_t max_bytes, const ReadShapefile& read,
                                    const std::stop_token& stop);

}  // namespace ccdt::server
