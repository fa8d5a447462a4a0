// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace ccdt::api {

/// Writes the shortest decimal number that reads back to the same double; "nan" and "inf" for what is no number.
void append_shortest(std::string& out, double value);

/// Writes the shortest decimal number that reads back to the same float.
void append_shortest(std::string& out, float value);

/// Writes a number rounded to so many decimals, without trailing zeros.
/// @param value  finite, also times 10^decimals
void append_rounded(std::string& out, double value, int decimals);

/// Writes as append_rounded() does, but never with an exponent, which the languages of machines do not have.
void append_fixed(std::string& out, double value, int decimals);

}  // namespace ccdt::api
