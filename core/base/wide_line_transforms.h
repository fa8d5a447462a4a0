// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/base/line_set.h"

namespace ccdt {

/// Returns transforms that process twice as many lines at once. Must be used only if has_two_lanes() is true. Null if
/// the compiler or the architecture does not support them.
const LineTransforms* wide_line_transforms();

}  // namespace ccdt
