#pragma once

#include <string>

namespace ccdt::server {

/// All of a request that its answer depends on.
struct Question {
    std::string path;
    std::string query;         ///< as sent, but for what a form adds to it
    std::string content_type;  ///< as sent, like the next; empty once a form was taken apart
    std::string accept;
    std::string body;
};

}  // namespace ccdt::server
