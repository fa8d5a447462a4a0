#pragma once

#include <vector>

#include "api/run/options.h"
#include "server/http/message.h"

namespace ccdt::server {

/// Lists the headers that tell what the body of an answer may not, the same at once and from a job. That it is partial
/// is not among them.
std::vector<Header> answer_headers(const api::Answer& answer);

}  // namespace ccdt::server
