// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace ccdt::api {

/// First bytes of a NumPy file of format version 1.0.
inline constexpr std::string_view kNpyMagic("\x93NUMPY\x01\x00", 8);

/// The array of a NumPy file.
struct NpyArray {
    std::string_view type;           ///< type of the elements in NumPy's notation, such as `<f8`
    std::vector<std::size_t> shape;  ///< lengths of the axes
    std::string_view data;           ///< elements, not aligned
    bool is_fortran = false;         ///< whether the first axis varies fastest in `data`, instead of the last one

    /// Whether the elements are numbers that value() can read: booleans, integers, or floats of 2, 4 or 8 bytes.
    bool has_numbers() const;

    /// Reads an element. Requires has_numbers().
    /// @param i  index of the element in C order, in which the last axis varies fastest
    double value(std::size_t i) const;
};

/// Whether a file is a NumPy file of any version.
inline bool is_npy(std::string_view file) {
    return file.starts_with(kNpyMagic.substr(0, kNpyMagic.size() - 2));
}

/// Reads the header of a NumPy file. Source: NEP 1, format version 1.0.
/// @returns  the array; the file must outlive it
/// Errors: Malformed for any other file, and if the number of bytes does not match the shape. Error::field is empty.
Result<NpyArray> read_npy(std::string_view file);

}  // namespace ccdt::api
