// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/base/line_set.h"

namespace ccdt {

/// Returns the transforms that run on every processor of the architecture.
const LineTransforms& common_line_transforms();

/// Returns the fastest transforms that this processor supports.
const LineTransforms& line_transforms();

}  // namespace ccdt
