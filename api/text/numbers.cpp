// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/text/numbers.h"

#include <charconv>
#include <cmath>

#include "core/base/elementary.h"

namespace ccdt::api {

namespace {

template <class Number>
void append_as_text(std::string& out, Number value) {
    char digits[24];
    out.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

}  // namespace

void append_shortest(std::string& out, double value) {
    append_as_text(out, value);
}

void append_shortest(std::string& out, float value) {
    append_as_text(out, value);
}

void append_rounded(std::string& out, double value, int decimals) {
    const double unit = elementary::pow(10.0, decimals);
    append_shortest(out, std::round(value * unit) / unit + 0.0);  // no -0
}

void append_fixed(std::string& out, double value, int decimals) {
    const double unit = elementary::pow(10.0, decimals);
    char digits[400];                                              // enough for the digits of the largest double
    const double rounded = std::round(value * unit) / unit + 0.0;  // no -0
    out.append(digits, std::to_chars(digits, digits + sizeof digits, rounded, std::chars_format::fixed).ptr);
}

}  // namespace ccdt::api
