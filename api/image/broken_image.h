// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/base/result.h"

namespace ccdt::api {

/// Returns the error for an image file of any format that cannot be decoded.
inline tl::unexpected<Error> broken_image() {
    return failure(ErrorCode::Unusable, "the image is broken or truncated");
}

}  // namespace ccdt::api
