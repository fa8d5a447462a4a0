#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/run/options.h"
#include "server/http/message.h"

namespace ccdt::server {

/// Lists the headers of an answer that tell what its body may not, the same at once and from a job.
/// @param repaired  as api::Answer has it
/// @param partial   it is what there was by the deadline
std::vector<Header> answer_headers(const std::optional<api::DotSize>& dots, std::string repaired, bool partial);

}  // namespace ccdt::server
