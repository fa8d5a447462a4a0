// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace ccdt::api {

/// Appends the shortest decimal number that reads back to the same double. NaN and infinity are written as "nan" and
/// "inf".
void append_shortest(std::string& out, double value);

/// Appends the shortest decimal number that reads back to the same float.
void append_shortest(std::string& out, float value);

/// Appends a number rounded to the given number of decimals, without trailing zeros.
/// @param value  finite, also after multiplication by 10^decimals
void append_rounded(std::string& out, double value, int decimals);

/// Appends a number like append_rounded(), but never with an exponent. Plotters, among others, cannot read exponents.
void append_fixed(std::string& out, double value, int decimals);

}  // namespace ccdt::api
