// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "server/http/connection.h"
#include "server/http/message.h"
#include "server/page/page.h"

namespace ccdt::server {

struct Operation;

/// The variable part of a request's path, and what it refers to.
struct Target {
    std::string_view name;                 ///< the placeholder's value: a job's id, a picture's name
    const PageFile* file = nullptr;        ///< file of the page
    const Operation* operation = nullptr;  ///< the operation to compute
};

/// A request being answered: its connection, its target, and the record for log and metrics.
struct Incoming {
    const Request& request;
    Connection& connection;
    Record& record;
    const Target& target;
};

}  // namespace ccdt::server
