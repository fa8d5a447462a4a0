#pragma once

#include <string_view>

#include "server/http/connection.h"
#include "server/http/message.h"
#include "server/page/page.h"

namespace ccdt::server {

struct Operation;

/// Things that the path of a request names besides its route.
struct Target {
    std::string_view name;                 ///< for the placeholder of the route's path: a job's id, a picture's name
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
