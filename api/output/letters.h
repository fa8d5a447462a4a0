// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

#include "core/geometry/polygon.h"

namespace ccdt::api {

/// Whether letters() is available. Otherwise, it returns no rings.
bool can_letter();

/// Returns the outlines of a text, in the font DejaVu Sans, as rings for the nonzero rule. The baseline begins at the
/// origin; y points down. No rings: the text is empty, or its font cannot be read.
/// @param text  UTF-8
/// @param size  of the font
std::vector<Ring> letters(std::string_view text, double size);

}  // namespace ccdt::api
