// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/fourier/line_transforms.h"

namespace ccdt {

/// Returns transforms of twice as many lines at once, to be used only if has_two_lanes(); null if they could not be
/// compiled.
const LineTransforms* wide_line_transforms();

}  // namespace ccdt
