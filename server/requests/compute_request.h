// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace ccdt::server {

/// The parts of an HTTP request that a computed answer depends on.
struct ComputeRequest {
    std::string path;
    std::string query;         ///< query as sent, plus the fields of a form
    std::string content_type;  ///< Content-Type as sent; empty once a form was parsed
    std::string accept;
    std::string body;
};

}  // namespace ccdt::server
