// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/input/option_reader.h"
#include "core/base/result.h"
#include "core/picture/levels.h"
#include "core/picture/picture.h"

namespace ccdt::api {

/// Ways to fit a picture into a drawing whose width and height are both given.
enum class Fit {
    Contain,  ///< the whole picture is drawn, as large as the width and the height allow
    Cover,    ///< the middle of the picture is drawn and fills the drawing
};

/// Reads `contain` or `cover`. Errors: Malformed.
Result<Fit> read_fit(const Input& input);

/// Reads `display` or `linear`. Errors: Malformed.
Result<AlphaMixing> read_alpha(const Input& input);

/// Reads the length of a side of a drawing, 1 to 65,535 pixels. Errors: Malformed.
Result<int> read_side(const Input& input);

/// Reads a list of two or three numbers: black point, white point, and optionally gamma. Errors: Malformed.
Result<Levels> read_levels(const Input& input);

}  // namespace ccdt::api
