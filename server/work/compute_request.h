#pragma once

#include <string>

namespace ccdt::server {

/// Parts of an HTTP request that a computed answer depends on: all of them.
struct ComputeRequest {
    std::string path;
    std::string query;         ///< as sent, but for what a form adds to it
    std::string content_type;  ///< as sent, like the next; empty once a form was taken apart
    std::string accept;
    std::string body;
};

}  // namespace ccdt::server
