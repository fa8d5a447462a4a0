#pragma once

#include <vector>

#include "core/result.h"
#include "server/http/multipart.h"
#include "server/work/question.h"

namespace ccdt::server {

/// Finds the fields of the form that a question's body is, by its content type.
/// @returns  none if it is no form
/// Errors (Malformed): those of parse_multipart.
Result<std::vector<FormPart>> find_fields(const Question& question);

/// Makes of a question with a form the same question with a picture: the part `image` or `file` becomes the body, the
/// other fields are added to the query. What is no form stays as it is.
///
/// @param fields  of that question
/// Errors (Malformed): no picture, or several.
Result<void> take_apart(Question& question, const std::vector<FormPart>& fields);

}  // namespace ccdt::server
