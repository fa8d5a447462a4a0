#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/options.h"
#include "server/http/http.h"
#include "server/work/question.h"

namespace ccdt::server {

/// A name of the answer to a question, known before it is computed: different questions have different ones, and so
/// have servers of other limits or versions. The same picture and options in a form have one, whatever its boundary.
///
/// @returns  24 characters that may stand in an entity tag
/// O(size of the body).
std::string name_of_answer(const Question& question, const api::Limits& limits);

/// The tag in an If-None-Match header that names an answer, weakly or strongly and in any of its codings (RFC 9110,
/// 13.1.2). A star names none.
/// @returns  the tag as it stands there
std::optional<std::string_view> find_tag(std::string_view if_none_match, std::string_view name);

/// What is answered to those who have the answer of that tag.
Response not_modified(std::string_view tag);

}  // namespace ccdt::server
