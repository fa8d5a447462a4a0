// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"

namespace ccdt::api {

/// Returns the error of a file that its reader cannot decode, whatever its format.
inline tl::unexpected<Error> broken_image() {
    return failure(ErrorCode::Unusable, "the image is broken or cut short");
}

}  // namespace ccdt::api
