#pragma once

#include "core/result.h"

namespace ccdt::api {

/// Error of a file that its reader cannot make sense of, whichever format it is of.
inline tl::unexpected<Error> broken_image() {
    return failure(ErrorCode::Unusable, "the image is broken or cut short");
}

}  // namespace ccdt::api
