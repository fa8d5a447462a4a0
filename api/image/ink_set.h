// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/input/palette.h"
#include "core/halftone/inks/separation.h"

namespace ccdt::api {

/// Returns a colour in linear light.
Light light_of(const Colour& colour);

/// Returns the colours of inks and paper in linear light.
/// @param palette  a palette with the mixing Multiply or Add, not Cover
InkSet ink_set(const Palette& palette);

}  // namespace ccdt::api
