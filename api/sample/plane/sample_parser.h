// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

#include "api/json/json_document.h"
#include "api/run/options.h"
#include "api/sample/plane/sample_request.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Returns the names of the options.
std::vector<std::string_view> sample_options();

/// Reads a request: a JSON object, or a GeoJSON or TopoJSON document whose options are given as text.
///
/// @param root     the parsed body
/// @param options  options that are given as text, in the order of the request; must be empty if the body is a JSON
///                 object, because its members are then the options
/// @param accept   the Accept header, empty if there is none; the option `format` takes precedence
/// Errors: Malformed for an unknown or repeated option, for a value of the wrong type or out of range, and unless
/// exactly one of `polygon`, `geometry` and `domain` is given; Unsupported for a density image in a format that the
/// server does not read; LimitExceeded for too many sites, corners or density cells; NotAcceptable if the client
/// accepts none of the formats. Error::field is a JSON Pointer or an option's name. Does no expensive work:
/// run_sample() validates polygons and decodes images.
Result<SampleRequest> parse_sample(JsonValue root, const std::vector<TextOption>& options, std::string_view accept,
                                   const Limits& limits);

/// Parses the body and reads it. Errors: those of JsonDocument::parse(), too.
Result<SampleRequest> parse_sample(std::string_view body, const std::vector<TextOption>& options,
                                   std::string_view accept, const Limits& limits);

}  // namespace ccdt::api
