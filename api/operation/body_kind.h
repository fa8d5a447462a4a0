// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "api/json/json_document.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Returns the kind of a body for messages: a noun phrase such as "a picture (PNG)".
std::string kind_of_body(std::string_view body);

/// Returns whether a body is binary data without any line end or zero byte. Valid files of binary formats contain such
/// bytes.
bool is_stripped(std::string_view body);

/// Returns the kind of a JSON body that is not a list of options: GeoJSON, TopoJSON or a glTF; otherwise empty.
std::string_view kind_of_json(JsonValue root);

/// Returns an error that names the kind of a body and the kinds that are accepted instead.
/// @param accepted  the end of the message
tl::unexpected<Error> wrong_body(std::string_view kind, std::string_view accepted);

/// Returns the error of a body that could not be parsed as JSON: `error` if the body begins like JSON, and otherwise
/// wrong_body().
tl::unexpected<Error> not_json(std::string_view body, const Error& error, std::string_view accepted);

/// Parses a body of /sample that is JSON: options, a map, or a sequence of features (JsonDocument::parse_features()).
/// Errors: those of JsonDocument; Unsupported or Malformed for another kind of body, with the kind in the message.
Result<JsonDocument> parse_sample_document(std::string_view body);

}  // namespace ccdt::api
