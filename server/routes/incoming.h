#pragma once

#include "server/http/connection.h"
#include "server/http/message.h"

namespace ccdt::server {

/// A request that is being answered, where it came from, and what log and figures will be told of it.
struct Incoming {
    const Request& request;
    Connection& connection;
    Record& record;
};

}  // namespace ccdt::server
