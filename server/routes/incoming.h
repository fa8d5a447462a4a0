// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "server/http/connection.h"
#include "server/http/message.h"
#include "server/page/page.h"

namespace ccdt::server {

struct Operation;

/// The variable part of a request's path, and the file or operation that the path refers to.
struct Target {
    std::string_view name;           ///< value of the placeholder: a job id, a picture name or the path of a document
    const PageFile* file = nullptr;  ///< file of the page
    const Operation* operation = nullptr;  ///< the operation to compute
};

/// A request that is being answered.
struct Incoming {
    const Request& request;
    Connection& connection;
    Record& record;
    const Target& target;
};

}  // namespace ccdt::server
