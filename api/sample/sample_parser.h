// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

#include "api/run/options.h"
#include "api/sample/sample_request.h"
#include "core/result.h"

namespace ccdt::api {

/// Returns the names of the options.
std::vector<std::string_view> sample_options();

/// Reads a request: a JSON object, or a GeoJSON or TopoJSON document whose options are given as text.
///
/// @param options  in the order of the request, without repetition; empty if the body is a JSON object, whose members
///                 are the options
/// @param accept   the Accept header, empty if there is none; the option `format` takes precedence
/// Errors: Malformed for invalid JSON, for an unknown or repeated member, for a value of the wrong type or out of
/// range, and unless exactly one domain is given; Unsupported for a density image in a format that the server does not
/// read; LimitExceeded for too many sites, corners or density cells; NotAcceptable. Error::field is a JSON Pointer or
/// an option's name.
/// Does no expensive work: polygons are validated and images decoded by run_sample().
Result<SampleRequest> parse_sample(std::string_view body, const std::vector<TextOption>& options,
                                   std::string_view accept, const Limits& limits);

}  // namespace ccdt::api
