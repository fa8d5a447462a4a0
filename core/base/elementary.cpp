// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/elementary.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

namespace ccdt::elementary {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The unevaluated sum of two numbers. |low| is at most half an ulp of high.
struct Sum {
    double high = 0;
    double low = 0;
};

// Constants. In kLn2Exact and kHalfPi, all parts but the last have so few bits that products with whole numbers below
// 2^15 and 2^20, respectively, are exact.
constexpr Sum kLn2 = {0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56};
constexpr Sum kLn2Exact = {0x1.62e42fefa0000p-1, 0x1.cf79abc9e3b3ap-40};
constexpr Sum kLog2E = {0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56};
constexpr Sum kLog10E = {0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57};
constexpr Sum kTwoThirds = {0x1.5555555555555p-1, 0x1.5555555555555p-55};
constexpr std::array<double, 3> kHalfPi = {0x1.921fb54400000p+0, 0x1.0b4611a600000p-34, 0x1.3198a2e037073p-69};
constexpr Sum kRightAngle = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};

/// Arc tangents of k / 8.
constexpr std::array<Sum, 9> kArcTangents = {{{0, 0},
                                              {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
                                              {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
                                              {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
                                              {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
                                              {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
                                              {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
                                              {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
                                              {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55}}};

// Coefficients of power series. Their number makes the remainder less than 2^-58 of the result.

/// exp(x) = 1 + x + x^2 times the series in x; |x| <= log(2) / 32.
constexpr auto kExp = [] {
    std::array<double, 6> series{};
    double factorial = 1;
    for (std::size_t i = 0; i < series.size(); ++i) series[i] = 1 / (factorial *= static_cast<double>(i + 2));
    return series;
}();

/// sin(x) = x + x^3 times the series in x^2, and cos(x) = 1 - x^2 / 2 + x^4 times the series in x^2; |x| <= pi / 4.
template <std::size_t kSize>
constexpr std::array<double, kSize> alternating(double factorial, std::size_t next, double sign) {
    std::array<double, kSize> series{};
    for (std::size_t i = 0; i < kSize; ++i, next += 2, sign = -sign) {
        factorial *= static_cast<double>(next * (next + 1));
        series[i] = sign / factorial;
    }
    return series;
}
constexpr auto kSine = alternating<8>(1, 2, -1);
constexpr auto kCosine = alternating<7>(2, 3, 1);

/// atanh(x) = x + x^3 times the series in x^2; |x| <= 0.172 = 3 - sqrt(8).
constexpr auto kArtanh = [] {
    std::array<double, 10> series{};
    for (std::size_t i = 0; i < series.size(); ++i) series[i] = 1 / static_cast<double>(2 * i + 3);
    return series;
}();

/// atan(x) = x + x^3 times the series in x^2; |x| <= 1/16.
constexpr auto kArctan = [] {
    std::array<double, 7> series{};
    for (std::size_t i = 0; i < series.size(); ++i) series[i] = (i % 2 == 0 ? -1 : 1) / static_cast<double>(2 * i + 3);
    return series;
}();

/// Evaluates a power series from `kFrom` on; even and odd terms can be computed at the same time.
template <std::size_t kFrom = 0, std::size_t kSize>
double evaluate(const std::array<double, kSize>& series, double x) {
    const double square = x * x;
    double even = 0, odd = 0;
    for (std::size_t i = kSize; i-- > kFrom;) {
        double& each = (i - kFrom) % 2 == 0 ? even : odd;
        each = each * square + series[i];
    }
    return even + x * odd;
}

/// Returns a + b exactly if |a| >= |b| or a is 0.
constexpr Sum ordered_sum(double a, double b) {
    const double sum = a + b;
    return {sum, b - (sum - a)};
}

constexpr Sum exact_sum(double a, double b) {
    const double sum = a + b, of_b = sum - a;
    return {sum, (a - (sum - of_b)) + (b - of_b)};
}

/// Splits a number, at most 2^995 in size, into two of 26 bits.
constexpr Sum split(double a) {
    const double scaled = a * 0x1p27 + a;
    const double high = scaled - (scaled - a);
    return {high, a - high};
}

/// Returns a times b exactly, unless there is overflow or underflow.
constexpr Sum exact_product(double a, double b) {
    const double product = a * b;
    const auto [a1, a2] = split(a);
    const auto [b1, b2] = split(b);
    return {product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2};
}

constexpr Sum product(Sum a, Sum b) {
    const Sum exact = exact_product(a.high, b.high);
    return ordered_sum(exact.high, exact.low + (a.high * b.low + a.low * b.high));
}

Sum negative(Sum a) {
    return {-a.high, -a.low};
}

Sum plus(Sum a, Sum b) {
    const Sum exact = exact_sum(a.high, b.high);
    return ordered_sum(exact.high, exact.low + (a.low + b.low));
}

/// Returns a / b with an error far below an ulp of the result's high part.
Sum quotient(Sum a, Sum b) {
    const double high = a.high / b.high;
    const Sum back = exact_product(high, b.high);
    return {high, ((a.high - back.high) - back.low + a.low - high * b.low) / b.high};
}

/// Returns the square root of a positive sum, likewise.
Sum root(Sum a) {
    const double high = std::sqrt(a.high);
    const Sum back = exact_product(high, high);
    return {high, ((a.high - back.high) - back.low + a.low) / (2 * high)};
}

/// Rounds a number below 2^31 to the nearest whole number.
int nearest(double x) {
    return static_cast<int>(x + (x < 0 ? -0.5 : 0.5));
}

/// Number of powers of 2 in the table from 1 to 2.
constexpr int kSteps = 16;

/// Powers of 2 with the exponents i / 16.
constexpr auto kPowers = [] {
    std::array<Sum, kSteps> powers{{{1, 0}}};
    for (std::size_t i = 1; i < powers.size(); ++i)
        powers[i] = product(powers[i - 1], {0x1.0b5586cf9890fp+0, 0x1.8a62e4adc610bp-54});
    return powers;
}();

/// Returns 2^(steps / 16) exp(rest + low), rounded to a subnormal number only once. |rest| <= log(2) / 32.
double power_of_2(int steps, double rest, double low) {
    constexpr int kBias = 1023, kBits = 52;
    const int fraction = steps & (kSteps - 1), power = (steps - fraction) / kSteps;
    const Sum& table = kPowers[static_cast<std::size_t>(fraction)];
    const double part = rest + (low + rest * rest * evaluate(kExp, rest));
    const double value = table.high + (table.low + table.high * part);
    if (power < 1 - kBias || power > kBias) return std::ldexp(value, power);
    return value * std::bit_cast<double>(static_cast<std::uint64_t>(power + kBias) << kBits);
}

/// Returns exp(x.high + x.low).
double exp(Sum x) {
    constexpr double kMax = 709.79, kMin = -745.14;
    if (x.high > kMax) return kInfinity;
    if (x.high < kMin) return 0;
    const int steps = nearest(x.high * (kSteps * kLog2E.high));
    const auto [rest, low] =
        ordered_sum(x.high - steps * (kLn2Exact.high / kSteps), x.low - steps * (kLn2Exact.low / kSteps));
    return power_of_2(steps, rest, low);
}

/// A positive number as 2^power (1 + part), with 1 + part in [sqrt(1/2), sqrt(2)].
struct Scaled {
    int power = 0;
    double part = 0;
};

Scaled in_powers_of_2(double x) {
    constexpr int kBias = 1023, kBits = 52, kSubnormal = 54;
    constexpr std::uint64_t kFraction = (std::uint64_t{1} << kBits) - 1;
    int power = 0;
    if (x < std::numeric_limits<double>::min()) {
        x *= 0x1p54;
        power = -kSubnormal;
    }
    const auto bits = std::bit_cast<std::uint64_t>(x);
    power += static_cast<int>(bits >> kBits) - kBias;
    auto mantissa = std::bit_cast<double>((bits & kFraction) | (std::uint64_t{kBias} << kBits));
    if (mantissa > std::numbers::sqrt2) {
        mantissa /= 2;
        ++power;
    }
    return {power, mantissa - 1};
}

/// Returns log(1 + part) with an error below 2^-63 of the result.
Sum log_of_part(double part) {
    // The logarithm is 2 atanh(root).
    const Sum root = quotient({part, 0}, exact_sum(2, part)), square = product(root, root);
    const Sum cubic = product(product(root, square), kTwoThirds);
    const double others = 2 * root.high * square.high * square.high * evaluate<1>(kArtanh, square.high);
    return plus({2 * root.high, 2 * root.low}, {cubic.high, cubic.low + others});
}

/// Returns log(x) of a positive number, with an error below 2^-62 of the result.
Sum log_of(double x) {
    const auto [power, part] = in_powers_of_2(x);
    const Sum of_power = ordered_sum(power * kLn2Exact.high, power * kLn2Exact.low);
    return plus(of_power, log_of_part(part));
}

/// The logarithm of a number that is not finite and positive, to any base.
double special_log(double x) {
    return x == 0 ? -kInfinity : x > 0 ? x : kNaN;
}

bool is_finite_positive(double x) {
    return x > 0 && x < kInfinity;
}

/// Sine and cosine of x.high + x.low; |x| <= pi / 4.
double small_sine(Sum x) {
    const double square = x.high * x.high;
    return x.high + (x.low * (1 - square / 2) + x.high * square * evaluate(kSine, square));
}
double small_cosine(Sum x) {
    const double square = x.high * x.high, half = square / 2, first = 1 - half;
    return first + ((1 - first - half) + (square * square * evaluate(kCosine, square) - x.high * x.low));
}

/// An angle as a multiple of pi / 2, modulo 4, and a rest in [-pi / 4, pi / 4].
struct Reduced {
    unsigned quarter = 0;
    Sum rest;
};

Reduced reduced(double x) {
    constexpr double kMax = 1e6;
    if (!(std::abs(x) <= kMax)) x = std::remainder(x, 2 * std::numbers::pi);  // NaN if infinite
    if (std::isnan(x)) return {0, {x, 0}};
    const int quarters = nearest(x * (2 / std::numbers::pi));
    if (quarters == 0) return {0, {x, 0}};
    const Sum rest = exact_sum(x - quarters * kHalfPi[0], -quarters * kHalfPi[1]);
    return {static_cast<unsigned>(quarters) % 4, ordered_sum(rest.high, rest.low - quarters * kHalfPi[2])};
}

/// Returns the arc tangent of y / x; 0 <= y <= x, and x is in [0.5, 1).
Sum small_angle(Sum y, Sum x) {
    constexpr int kParts = kArcTangents.size() - 1;
    const int step = nearest(y.high / x.high * kParts);
    // The angle is the sum of two angles with the tangents `known` and `tangent`.
    const double known = static_cast<double>(step) / kParts;
    const Sum tangent = quotient(plus(y, product({-known, 0}, x)), plus(x, product({known, 0}, y)));
    const double square = tangent.high * tangent.high;
    const double others = tangent.low + tangent.high * square * evaluate(kArctan, square);
    return plus(kArcTangents[static_cast<std::size_t>(step)], {tangent.high, others});
}

/// Returns the angle of a vector in [0, pi]; y >= 0, the larger one of y and |x| is in [0.5, 1), and neither is 0.
double angle(Sum y, Sum x) {
    const bool is_left = x.high < 0;
    if (is_left) x = negative(x);
    Sum found = y.high <= x.high ? small_angle(y, x) : plus(kRightAngle, negative(small_angle(x, y)));
    if (is_left) found = plus({2 * kRightAngle.high, 2 * kRightAngle.low}, negative(found));
    return found.high;
}

/// Returns a number's exponent e such that 2^-e times the number is in [0.5, 1).
int exponent_of(double x) {
    int exponent = 0;
    std::frexp(x, &exponent);
    return exponent;
}

/// Returns the cube root of a number in [1, 8), with an error of a few ulp.
double root_of_mantissa(double x) {
    double root = 0.6816783 + x * (0.3645337 + x * (-0.04331167 + x * 0.00231335));  // wrong by 0.6 %
    for (int i = 0; i < 2; ++i) {
        const double cube = root * root * root;
        root *= (cube + 2 * x) / (2 * cube + x);  // Halley's method, which cubes the relative error
    }
    return root;
}

/// A number in [1, 8) whose root is multiplied by 2^third.
std::pair<double, int> in_powers_of_8(double x) {
    const int exponent = exponent_of(x) - 1;
    const int third = exponent >= 0 ? exponent / 3 : -((2 - exponent) / 3);
    return {std::ldexp(x, -3 * third), third};
}

/// Whether a number is its own cube root, or has none.
bool is_special_cube(double x) {
    return x == 0 || !std::isfinite(x);
}

}  // namespace

double exp(double x) {
    return std::isnan(x) ? x : exp(Sum{x, 0});
}

double exp2(double x) {
    constexpr double kMax = 1100;
    if (std::isnan(x)) return x;
    const double clamped = std::clamp(x, -kMax, kMax);
    const int steps = nearest(clamped * kSteps);
    const Sum rest = product({clamped - static_cast<double>(steps) / kSteps, 0}, kLn2);
    return power_of_2(steps, rest.high, rest.low);
}

float exp(float x) {
    return static_cast<float>(exp(static_cast<double>(x)));
}

double log(double x) {
    if (!is_finite_positive(x)) return special_log(x);
    const auto [power, part] = in_powers_of_2(x);
    // The logarithm of 1 + part is part - half (1 - root) + root rest, where root is part / (2 + part).
    const double root = part / (2 + part), square = root * root, half = part * part / 2;
    const double rest = 2 * square * evaluate(kArtanh, square);
    return power * kLn2Exact.high - ((half - (root * (half + rest) + power * kLn2Exact.low)) - part);
}

double log2(double x) {
    if (!is_finite_positive(x)) return special_log(x);
    const auto [power, part] = in_powers_of_2(x);
    return plus({static_cast<double>(power), 0}, product(log_of_part(part), kLog2E)).high;
}

double log10(double x) {
    return is_finite_positive(x) ? product(log_of(x), kLog10E).high : special_log(x);
}

float log2(float x) {
    return static_cast<float>(log(static_cast<double>(x)) * kLog2E.high);
}

double log1p(double x) {
    const double sum = 1 + x;
    if (sum == 1) return x;
    // The logarithm of the rounded sum, times the ratio of x and what the rounding left of x.
    return sum < kInfinity ? log(sum) * (x / (sum - 1)) : log(sum);
}

float log1p(float x) {
    return static_cast<float>(log1p(static_cast<double>(x)));
}

double pow(double x, double y) {
    if (y == 0 || x == 1) return 1;
    if (std::isnan(x) || std::isnan(y) || x < 0) return kNaN;
    if (x == 0 || x == kInfinity) return (x == 0) == (y > 0) ? 0 : kInfinity;
    const Sum logarithm = log_of(x);
    constexpr double kMax = 1000;
    const double rough = y * logarithm.high;
    if (!(std::abs(rough) < kMax)) return rough > 0 ? kInfinity : 0;
    const Sum exact = exact_product(y, logarithm.high);
    return exp(ordered_sum(exact.high, exact.low + y * logarithm.low));
}

float pow(float x, float y) {
    if (!(x > 0) || y == 0) return static_cast<float>(pow(static_cast<double>(x), static_cast<double>(y)));
    return static_cast<float>(exp(y * log(static_cast<double>(x))));
}

double cbrt(double x) {
    if (is_special_cube(x)) return x;
    const auto [mantissa, third] = in_powers_of_8(std::abs(x));
    const double root = root_of_mantissa(mantissa);
    const Sum square = exact_product(root, root);
    const Sum cube = product(square, {root, 0});
    const double rest = (mantissa - cube.high) - cube.low;
    return std::copysign(std::ldexp(root + rest / (3 * square.high), third), x);
}

float cbrt(float x) {
    if (is_special_cube(x)) return x;
    const auto [mantissa, third] = in_powers_of_8(std::abs(x));
    return std::copysign(static_cast<float>(std::ldexp(root_of_mantissa(mantissa), third)), x);
}

double hypot(double x, double y) {
    constexpr int kNegligible = 60;
    const double longer = std::max(std::abs(x), std::abs(y)), shorter = std::min(std::abs(x), std::abs(y));
    if (std::isinf(x) || std::isinf(y)) return kInfinity;
    if (std::isnan(x) || std::isnan(y)) return kNaN;
    if (shorter == 0) return longer;
    const int power = exponent_of(longer);
    if (exponent_of(shorter) < power - kNegligible) return longer;
    const double a = std::ldexp(longer, -power), b = std::ldexp(shorter, -power);
    const Sum length = root(plus(exact_product(a, a), exact_product(b, b)));
    return std::ldexp(length.high + length.low, power);
}

double sin(double x) {
    const auto [quarter, rest] = reduced(x);
    const double value = quarter % 2 == 0 ? small_sine(rest) : small_cosine(rest);
    return quarter < 2 ? value : -value;
}

double cos(double x) {
    const auto [quarter, rest] = reduced(x);
    const double value = quarter % 2 == 0 ? small_cosine(rest) : small_sine(rest);
    return quarter == 0 || quarter == 3 ? value : -value;
}

double tan(double x) {
    const auto [quarter, rest] = reduced(x);
    const double sine = small_sine(rest), cosine = small_cosine(rest);
    return quarter % 2 == 0 ? sine / cosine : -cosine / sine;
}

double atan(double x) {
    return atan2(x, 1);
}

double atan2(double y, double x) {
    constexpr int kNegligible = 60;
    if (std::isnan(x) || std::isnan(y)) return kNaN;
    if (std::isinf(x) || std::isinf(y)) {
        y = std::copysign(std::isinf(y) ? 1.0 : 0.0, y);
        x = std::copysign(std::isinf(x) ? 1.0 : 0.0, x);
    }
    const int of_y = exponent_of(y), of_x = exponent_of(x), power = std::max(of_x, of_y);
    if (y == 0 || (x != 0 && of_y < of_x - kNegligible))
        return std::signbit(x) ? std::copysign(std::numbers::pi, y) : y == 0 ? y : y / x;
    if (x == 0 || of_x < of_y - kNegligible) return std::copysign(kRightAngle.high, y);
    return std::copysign(angle({std::ldexp(std::abs(y), -power), 0}, {std::ldexp(x, -power), 0}), y);
}

double acos(double x) {
    if (!(std::abs(x) <= 1)) return kNaN;
    if (x == 0 || std::abs(x) == 1) return (1 - x) * kRightAngle.high;
    const Sum square = exact_product(x, x);
    return angle(root(plus({1, 0}, negative(square))), {x, 0});
}

}  // namespace ccdt::elementary
