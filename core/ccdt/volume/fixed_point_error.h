// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/ccdt/volume/point_text.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Returns the error about a fixed point outside its domain: "the fixed point 3, (9, 9, 9), is not in the domain".
/// @param index   index of the point, also in Error::field
/// @param domain  such as "in the domain"
inline Error fixed_point_error(std::size_t index, Point3 p, std::string_view domain) {
    const std::string number = std::to_string(index);
    return {ErrorCode::Malformed, "the fixed point " + number + ", " + text(p) + ", is not " + std::string(domain),
            "fixed/" + number};
}

}  // namespace ccdt
