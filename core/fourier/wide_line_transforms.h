#pragma once

#include "core/fourier/line_transforms.h"

namespace ccdt {

/// Twice as many lines at once; only where has_two_lanes(). Null if they could not be compiled.
const LineTransforms* wide_line_transforms();

}  // namespace ccdt
