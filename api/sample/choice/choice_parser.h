// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

#include "api/json/json_document.h"
#include "api/run/options.h"
#include "api/sample/choice/choice_request.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Returns the names of the options.
std::vector<std::string_view> choice_options();

/// Whether a body of /sample that is JSON has candidates.
bool asks_for_choice(JsonValue root);
/// Whether options that are given as text say that the body is a file with candidates.
bool asks_for_choice(const std::vector<TextOption>& options);

/// Reads a request whose body has candidates as a member.
/// @param options  options that are given as text; must be empty
/// Errors: Malformed for a value of the wrong type or out of range, and for lists of different lengths; LimitExceeded
/// for more than limits.max_sites candidates; Unusable if there are more sites than candidates; NotAcceptable.
Result<ChoiceRequest> parse_choice(JsonValue root, const std::vector<TextOption>& options, std::string_view accept,
                                   const Limits& limits);

/// Reads a request whose body is a file with candidates (read_point_table()). The options name its columns. Without the
/// option `format`, the format is that of the file, unless the client does not accept it. Errors: as above.
Result<ChoiceRequest> parse_choice(std::string_view file, const std::vector<TextOption>& options,
                                   std::string_view accept, const Limits& limits);

}  // namespace ccdt::api
