// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <utility>

#include "api/output/body.h"

namespace ccdt::api::test {

/// Returns the text that write(body) writes to a body without a sink.
template <class Write>
std::string whole_body(Write&& write) {
    Body body;
    write(body);
    return std::move(body.text());
}

}  // namespace ccdt::api::test
