// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "api/run/options.h"
#include "server/http/message.h"

namespace ccdt::server {

/// Returns the headers with information that the body of an answer lacks. They are the same for a direct answer and for
/// the result of a job. They do not say whether the answer is partial.
std::vector<Header> answer_headers(const api::Answer& answer);

}  // namespace ccdt::server
