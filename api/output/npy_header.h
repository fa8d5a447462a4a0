// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace ccdt::api {

/// Returns the header of a NumPy file with an array in C order. Source: NEP 1, format version 1.0.
/// @param type   type of the elements in NumPy's notation, such as `<f8`
/// @param shape  lengths along two or more axes
std::string npy_header(std::string_view type, std::span<const std::size_t> shape);
inline std::string npy_header(std::string_view type, std::size_t rows, std::size_t columns) {
    return npy_header(type, std::array{rows, columns});
}

}  // namespace ccdt::api
