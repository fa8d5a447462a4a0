// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Elementary functions that give the same bits on every processor, with every compiler and C library. Those of the C
// library do not: glibc, for example, chooses between variants with and without fused multiply-adds when a program
// starts. All code whose results reach an answer calls these functions instead; std::sqrt, std::fmod, std::remainder,
// std::ldexp and the functions that round to integers are exact everywhere.
//
// Why not a library: Debian 12 has no package of CORE-MATH, crlibm or openlibm, and SLEEF's deterministic functions
// depend on the instruction set for which they are compiled.
//
// All functions are pure, and need constant time. Errors are given in ulp, the unit in the last place of the result;
// tests/core/base/elementary_test.cpp measures them. Without an error, the result is wrong by at most 1 ulp. Functions
// of float are wrong by at most 0.51 ulp. Arguments outside the domain give NaN, as do NaNs.

namespace ccdt::elementary {

double exp(double x);
double exp2(double x);
float exp(float x);

double log(double x);
double log2(double x);
double log10(double x);
float log2(float x);

/// Returns log(1 + x) for x > -1. Error: 2.5 ulp.
double log1p(double x);
float log1p(float x);

/// Returns x to the power of y for x >= 0. pow(0, 0) is 1.
double pow(double x, double y);
float pow(float x, float y);

double cbrt(double x);
float cbrt(float x);

/// Returns the length of the vector (x, y), without intermediate overflow.
double hypot(double x, double y);

// Functions of angles in radians. Errors hold for |x| <= 1e6. Larger angles are first reduced by multiples of the
// double that is nearest to 2 pi.

double sin(double x);
double cos(double x);

/// Error: 2.5 ulp.
double tan(double x);

double atan(double x);

/// Returns the angle of the vector (x, y) in [-pi, pi]. The angle of (0, 0) is 0 or, if x is negative zero, pi, with
/// the sign of y.
double atan2(double y, double x);

double acos(double x);

}  // namespace ccdt::elementary
