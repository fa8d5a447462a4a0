// SPDX-License-Identifier: GPL-3.0-or-later
#include "ccdt/exception.h"

#include <utility>

#include "ccdt/ccdt.h"

namespace ccdt::v2 {

Exception::Exception(FailureCode code, const std::string& message, std::string field)
    : std::runtime_error(message), code_(code), field_(std::move(field)) {}

Exception::~Exception() = default;

const char* version() noexcept {
    return CCDT_VERSION;
}

}  // namespace ccdt::v2
