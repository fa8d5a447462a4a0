// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/elementary.h"

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Returns a random finite number of any sign and exponent.
double any(Random& random) {
    while (true) {
        const auto value = std::bit_cast<double>(random.bits());
        if (std::isfinite(value)) return value;
    }
}

std::function<double(Random&)> between(double low, double high) {
    return [low, high](Random& random) { return low + (high - low) * random.uniform(); };
}

/// Random numbers of which each power of 2 has as many.
std::function<double(Random&)> of_sizes(double low, double high) {
    return [low, high](Random& random) {
        const double power = std::log2(low) + (std::log2(high) - std::log2(low)) * random.uniform();
        return std::ldexp(1 + random.uniform(), static_cast<int>(std::floor(power)));
    };
}

/// Returns the error of a result in units in its last place.
template <std::floating_point Number>
double ulps(Number result, long double exact) {
    const auto rounded = static_cast<Number>(exact);
    if (std::isnan(rounded) || std::isinf(rounded) || std::isinf(result))
        return rounded == result || (std::isnan(rounded) && std::isnan(result)) ? 0 : kInfinity;
    const Number size = std::abs(rounded);
    const Number below = size == 0 ? 0 : std::nextafter(size, Number{0});
    const Number unit =
        std::abs(exact) < size ? size - below : std::nextafter(size, std::numeric_limits<Number>::max()) - size;
    return static_cast<double>(std::abs(result - exact) / unit);
}

/// A function, its counterpart in extended precision, and arguments.
struct Case {
    std::string name;
    std::function<double(Random&)> x, y;
    double limit = 1;  ///< in ulp
    std::function<double(double, double)> error;
};

template <class Ours, class Exact>
Case one(const std::string& name, double limit, std::function<double(Random&)> x, Ours ours, Exact exact) {
    return {name, std::move(x), [](Random&) { return 0.0; }, limit,
            [=](double a, double) { return ulps(ours(a), exact(static_cast<long double>(a))); }};
}

template <class Ours, class Exact>
Case two(const std::string& name, std::function<double(Random&)> x, std::function<double(Random&)> y, Ours ours,
         Exact exact) {
    return {name, std::move(x), std::move(y), 1, [=](double a, double b) {
                return ulps(ours(a, b), exact(static_cast<long double>(a), static_cast<long double>(b)));
            }};
}

#define CCDT_ONE(function, limit, x)                                                     \
    one(                                                                                 \
        #function " of " #x, limit, x, [](double v) { return elementary::function(v); }, \
        [](long double v) { return std::function(v); })
#define CCDT_TWO(function, x, y)                                                                          \
    two(                                                                                                  \
        #function " of " #x ", " #y, x, y, [](double v, double w) { return elementary::function(v, w); }, \
        [](long double v, long double w) { return std::function(v, w); })
#define CCDT_FLOAT(function, x)                                                                                \
    one(                                                                                                       \
        #function " of float " #x, 0.51, [](Random& random) { return double{static_cast<float>(x(random))}; }, \
        [](double v) { return elementary::function(static_cast<float>(v)); },                                  \
        [](long double v) { return std::function(v); })

std::vector<Case> cases() {
    constexpr double kMin = 1e-320, kMax = 1e308;
    return {
        CCDT_ONE(exp, 1, between(-746, 710)),
        CCDT_ONE(exp, 1, between(-1, 1)),
        CCDT_ONE(exp2, 1, between(-1080, 1025)),
        CCDT_ONE(exp2, 1, between(-1, 1)),
        CCDT_ONE(log, 1, of_sizes(kMin, kMax)),
        CCDT_ONE(log, 1, between(0.5, 2)),
        CCDT_ONE(log2, 1, of_sizes(kMin, kMax)),
        CCDT_ONE(log2, 1, between(0.5, 2)),
        CCDT_ONE(log10, 1, of_sizes(kMin, kMax)),
        CCDT_ONE(log10, 1, between(0.5, 2)),
        CCDT_ONE(log1p, 2.5, of_sizes(kMin, kMax)),
        CCDT_ONE(log1p, 2.5, between(-0.99, 1)),
        CCDT_ONE(cbrt, 1, any),
        CCDT_ONE(cbrt, 1, between(1, 8)),
        CCDT_ONE(sin, 1, of_sizes(kMin, 1)),
        CCDT_ONE(sin, 1, between(-10, 10)),
        CCDT_ONE(sin, 1, between(-1e6, 1e6)),
        CCDT_ONE(cos, 1, between(-10, 10)),
        CCDT_ONE(cos, 1, between(-1e6, 1e6)),
        CCDT_ONE(tan, 2.5, between(-10, 10)),
        CCDT_ONE(tan, 2.5, between(-1e6, 1e6)),
        CCDT_ONE(atan, 1, any),
        CCDT_ONE(atan, 1, between(-2, 2)),
        CCDT_ONE(acos, 1, between(-1, 1)),
        CCDT_ONE(acos, 1, between(0.999, 1)),
        CCDT_TWO(pow, of_sizes(kMin, kMax), between(-1, 1)),
        CCDT_TWO(pow, between(0, 2), between(-20, 20)),
        CCDT_TWO(pow, between(0.99, 1.01), between(-70'000, 70'000)),
        CCDT_TWO(hypot, any, any),
        CCDT_TWO(hypot, between(-1, 1), between(-1, 1)),
        CCDT_TWO(atan2, any, any),
        CCDT_TWO(atan2, between(-1, 1), between(-1, 1)),
        CCDT_FLOAT(exp, between(-100, 88)),
        CCDT_FLOAT(log2, of_sizes(1e-40, 1e38)),
        CCDT_FLOAT(log1p, of_sizes(1e-40, 1e38)),
        CCDT_FLOAT(cbrt, of_sizes(1e-40, 1e38)),
        two(
            "pow of float", of_sizes(1e-12, 1e12), [](Random&) { return 2.4; },
            [](double v, double w) { return elementary::pow(static_cast<float>(v), static_cast<float>(w)); },
            [](long double v, long double w) {
                return std::pow(static_cast<long double>(static_cast<float>(v)),
                                static_cast<long double>(static_cast<float>(w)));
            }),
    };
}

TEST(Elementary, ErrorsAreAsDocumented) {
    if (std::numeric_limits<long double>::digits <= std::numeric_limits<double>::digits)
        GTEST_SKIP() << "long double is no more precise than double";
    constexpr int kSamples = 20'000;
    for (const Case& each : cases()) {
        Random random(1, 0);
        double worst = 0;
        for (int i = 0; i < kSamples; ++i) {
            const double x = each.x(random), y = each.y(random), error = each.error(x, y);
            if (!(error <= worst)) worst = error;
            ASSERT_LE(error, each.limit) << each.name << ": " << x << " " << y;
        }
        EXPECT_GT(worst, 0.1) << each.name << ": the exact result is not more precise";
    }
}

TEST(Elementary, SpecialValues) {
    using namespace elementary;
    EXPECT_EQ(exp(0.0), 1);
    EXPECT_EQ(exp(-kInfinity), 0);
    EXPECT_EQ(exp(kInfinity), kInfinity);
    EXPECT_EQ(exp(1e308), kInfinity);
    EXPECT_EQ(exp2(-1074.0), std::numeric_limits<double>::denorm_min());
    EXPECT_EQ(exp2(10.0), 1024);
    EXPECT_EQ(exp2(kInfinity), kInfinity);
    EXPECT_EQ(log(1.0), 0);
    EXPECT_EQ(log(0.0), -kInfinity);
    EXPECT_EQ(log(kInfinity), kInfinity);
    EXPECT_EQ(log2(0x1p-1074), -1074);
    for (int i = 0; i <= 22; ++i) {
        EXPECT_EQ(log10(std::stod("1e" + std::to_string(i))), i);
        EXPECT_EQ(elementary::pow(10.0, i), std::stod("1e" + std::to_string(i)));
    }
    EXPECT_EQ(log1p(1e-300), 1e-300);
    EXPECT_EQ(log1p(-1.0), -kInfinity);
    EXPECT_EQ(elementary::pow(0.0, 0.0), 1);
    EXPECT_EQ(elementary::pow(0.0, 2.0), 0);
    EXPECT_EQ(elementary::pow(0.0, -2.0), kInfinity);
    EXPECT_EQ(elementary::pow(kInfinity, 0.5), kInfinity);
    EXPECT_EQ(elementary::pow(0.5, kInfinity), 0);
    EXPECT_EQ(elementary::pow(2.0, 1e308), kInfinity);
    EXPECT_EQ(elementary::pow(0.0F, 2.4F), 0);
    EXPECT_EQ(cbrt(-27.0), -3);
    EXPECT_EQ(cbrt(0x1p-1071), 0x1p-357);
    EXPECT_EQ(hypot(3, -4), 5);
    EXPECT_EQ(hypot(1.7e308, 1.7e308), kInfinity);
    EXPECT_EQ(hypot(3 * 0x1p1020, 4 * 0x1p1020), 5 * 0x1p1020);
    EXPECT_EQ(hypot(-kInfinity, kNaN), kInfinity);
    EXPECT_EQ(hypot(0, 1e-320), 1e-320);
    EXPECT_EQ(sin(0.0), 0);
    EXPECT_EQ(cos(0.0), 1);
    EXPECT_LE(std::abs(sin(1e308)), 1);
    EXPECT_EQ(atan(kInfinity), std::numbers::pi / 2);
    EXPECT_EQ(atan2(0, 0), 0);
    EXPECT_EQ(atan2(0, -1), std::numbers::pi);
    EXPECT_EQ(atan2(-1, 0), -std::numbers::pi / 2);
    EXPECT_EQ(atan2(-kInfinity, -kInfinity), -3 * std::numbers::pi / 4);
    EXPECT_EQ(atan2(1e-308, 1e308), 0);
    EXPECT_EQ(acos(1), 0);
    EXPECT_EQ(acos(-1), std::numbers::pi);
    for (const double wrong : {exp(kNaN), exp2(kNaN), log(-1.0), log(kNaN), log1p(-2.0), elementary::pow(-1.0, 0.5),
                               elementary::pow(2.0, kNaN), cbrt(kNaN), hypot(1, kNaN), sin(kInfinity), cos(kNaN),
                               tan(-kInfinity), atan(kNaN), atan2(kNaN, 1), acos(1.1)})
        EXPECT_TRUE(std::isnan(wrong));
}

TEST(Elementary, BitsAreThoseOfEveryMachine) {
    Random random(2, 0);
    std::uint64_t digest = 0;
    const auto add = [&](double value) { digest = digest * 0x100000001b3 + std::bit_cast<std::uint64_t>(value); };
    for (int i = 0; i < 10'000; ++i) {
        const double x = 20 * (random.uniform() - 0.5), y = random.uniform();
        using namespace elementary;
        for (const double value : {exp(x), exp2(x), log(y), log2(y), log10(y), log1p(y), elementary::pow(y, x), cbrt(x),
                                   hypot(x, y), sin(x), cos(x), tan(x), atan(x), atan2(y, x), acos(y)})
            add(value);
        const auto z = static_cast<float>(y);
        for (const float value : {exp(z), log2(z), elementary::pow(z, 2.4F), cbrt(z)}) add(value);
    }
    EXPECT_EQ(digest, 9285836570864834047U);
}

}  // namespace
}  // namespace ccdt
