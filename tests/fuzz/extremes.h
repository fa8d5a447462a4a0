// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "api/text/numbers.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {

/// Numbers from the smallest to the largest double, including those that overflow or lose precision when squared or
/// converted to float or an integer.
inline constexpr std::array<double, 32> kExtremes = {0,
                                                     5e-324,
                                                     2.2250738585072014e-308,
                                                     1e-300,
                                                     1e-200,
                                                     1e-154,
                                                     1e-140,
                                                     1e-100,
                                                     1e-76,
                                                     1e-45,
                                                     1e-38,
                                                     1e-30,
                                                     1e-16,
                                                     1e-12,
                                                     1e-9,
                                                     1e-3,
                                                     0.1,
                                                     0.5,
                                                     1,
                                                     2,
                                                     3,
                                                     10,
                                                     255,
                                                     1000,
                                                     65535,
                                                     1e6,
                                                     1e9,
                                                     1e16,
                                                     1e100,
                                                     1e140,
                                                     1e154,
                                                     1.7976931348623157e308};

/// Takes a finite number >= 0 from an input, mostly an element of kExtremes or its neighbour.
inline double take_number(Bytes& input) {
    const auto pick = input.take<std::uint8_t>();
    const double extreme = kExtremes[pick % kExtremes.size()];
    switch (pick / kExtremes.size()) {
        case 4:
            return std::nextafter(extreme, std::numeric_limits<double>::max());
        case 5:
            return std::nextafter(extreme, 0);
        case 6:
            return input.take<std::uint8_t>() / 16.0;
        case 7: {
            const double any = std::abs(input.take<double>());
            return std::isfinite(any) ? any : 1;
        }
        default:
            return extreme;
    }
}

/// Takes an element of a list, chosen by the next byte of an input.
template <class All>
const auto& take_one(const All& all, Bytes& input) {
    return all[input.take<std::uint8_t>() % all.size()];
}

/// Formats a number for a request.
inline std::string written(double number) {
    std::string text;
    api::append_shortest(text, number);
    return text;
}

}  // namespace ccdt::fuzz
