// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include <pybind11/numpy.h>

namespace ccdt::python {

/// Reads the pixels of a PNG file that this project wrote.
/// @returns  [height, width] or [height, width, 2 to 4], uint8, or uint16 for files with 16 bits per channel
/// Throws std::runtime_error for a broken file.
pybind11::array png_pixels(std::string_view file);

}  // namespace ccdt::python
