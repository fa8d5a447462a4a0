// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

namespace ccdt::api {

/// Reads a number of a binary file. The bytes need not be aligned.
template <class Number>
Number number_at(const char* bytes, std::endian order = std::endian::little) {
    std::array<char, sizeof(Number)> raw{};
    std::memcpy(raw.data(), bytes, raw.size());
    if (order != std::endian::native) std::ranges::reverse(raw);
    return std::bit_cast<Number>(raw);
}

}  // namespace ccdt::api
