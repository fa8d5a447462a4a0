// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace ccdt::api {

/// Returns the header of a NumPy file with an array of rows. Source: NEP 1, format version 1.0.
/// @param type  type of the elements in NumPy's notation, such as `<f8`
std::string npy_header(std::string_view type, std::size_t rows, std::size_t columns);

}  // namespace ccdt::api
