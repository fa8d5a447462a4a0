// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "core/result.h"

namespace ccdt::api {

/// Returns the error of a mesh file that cannot be read.
/// @param format  name of its format
inline tl::unexpected<Error> unusable_surface(std::string_view format, std::string_view reason) {
    constexpr std::size_t kLongest = 300;
    return failure(ErrorCode::Unusable,
                   std::string(format) + " file cannot be read: " + std::string(reason.substr(0, kLongest)));
}

}  // namespace ccdt::api
