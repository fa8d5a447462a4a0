// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <stop_token>
#include <string>
#include <string_view>

#include "api/map/shapefile_parts.h"
#include "api/run/options.h"
#include "core/base/result.h"
#include "server/requests/compute_request.h"

namespace ccdt::server {

/// Converts a zipped shapefile to GeoJSON, in the decoder process (DecoderClient). `timings` receives the processor
/// time.
using ReadShapefile = std::function<Result<std::string>(std::string_view archive, const api::ShapefileReading& reading,
                                                        const std::stop_token& stop, api::Timings& timings)>;

/// Converts a request whose body is a zipped shapefile to one with GeoJSON as the body. The query's option `object`
/// selects a shapefile of the archive and is removed.
/// Errors: those of `read`; Malformed if `object` is given twice.
Result<ComputeRequest> with_geojson(const ComputeRequest& request, std::size_t max_bytes, const ReadShapefile& read,
                                    const std::stop_token& stop, api::Timings& timings);

}  // namespace ccdt::server
