// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "api/input/option_reader.h"
#include "core/base/result.h"
#include "core/picture/crop.h"
#include "core/picture/levels.h"
#include "core/picture/picture.h"

namespace ccdt::api {

/// Ways to fit a picture into a drawing whose width and height are both given.
enum class Fit {
    Contain,  ///< the whole picture is drawn, as large as the width and the height allow
    Cover,    ///< a part of the picture, by default the middle, is drawn and fills the drawing
};

/// Reads `contain` or `cover`. Errors: Malformed.
Result<Fit> read_fit(const Input& input);

/// Reads a list of two numbers from 0 to 1. Errors: Malformed.
Result<Focus> read_gravity(const Input& input);

/// Checks that `gravity` is given with fit=cover only. Errors: Malformed.
Result<void> check_gravity(std::span<const Input> options, Fit fit);

/// Reads `display` or `linear`. Errors: Malformed.
Result<AlphaMixing> read_alpha(const Input& input);

/// Reads the length of a side of a drawing, 1 to 65,535 pixels. Errors: Malformed.
Result<int> read_side(const Input& input);

/// Reads a list of two or three numbers: black point, white point, and optionally gamma. Errors: Malformed.
Result<Levels> read_levels(const Input& input);

}  // namespace ccdt::api
