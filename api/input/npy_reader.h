// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace ccdt::api {

/// First bytes of a NumPy file of format version 1.0.
inline constexpr std::string_view kNpyMagic("\x93NUMPY\x01\x00", 8);

/// The array of a NumPy file, in C order.
struct NpyArray {
    std::string_view type;           ///< type of the elements in NumPy's notation, such as `<f8`
    std::vector<std::size_t> shape;  ///< the last axis varies fastest
    std::string_view data;           ///< elements, not aligned
};

/// Whether a file is a NumPy file of any version.
inline bool is_npy(std::string_view file) {
    return file.starts_with(kNpyMagic.substr(0, kNpyMagic.size() - 2));
}

/// Reads the header of a NumPy file. Source: NEP 1, format version 1.0.
/// @returns  the array; the file must outlive it
/// Errors: Malformed for any other file, for an array in Fortran order, and if the number of bytes does not match the
/// shape. Error::field is empty.
Result<NpyArray> read_npy(std::string_view file);

}  // namespace ccdt::api
