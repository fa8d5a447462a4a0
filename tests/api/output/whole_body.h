// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <utility>

#include "api/output/body.h"

namespace ccdt::api::test {

/// What write(body) writes to a body that is held whole.
template <class Write>
std::string whole_body(Write&& write) {
    Body body;
    write(body);
    return std::move(body.text());
}

}  // namespace ccdt::api::test
