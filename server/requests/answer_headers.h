// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "api/run/options.h"
#include "server/http/message.h"

namespace ccdt::server {

/// Returns the headers for facts that the body does not contain, such as X-Radius. They are the same for a direct
/// answer and for the result of a job. The caller adds the header that marks a partial
/// answer.
std::vector<Header> answer_headers(const api::Answer& answer);

}  // namespace ccdt::server
