#pragma once

#include <string_view>

#include "server/http/connection.h"
#include "server/http/message.h"
#include "server/page/page.h"

namespace ccdt::server {

struct Operation;

/// Things that the path of a request names besides its route.
struct Target {
    std::string_view job;                  ///< the id in the path of a job
    const PageFile* file = nullptr;        ///< of the page
    const Operation* operation = nullptr;  ///< that computes
};

/// A request that is being answered, where it came from, and what log and figures will be told of it.
struct Incoming {
    const Request& request;
    Connection& connection;
    Record& record;
    const Target& target;
};

}  // namespace ccdt::server
