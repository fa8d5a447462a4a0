// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "core/ccdt/plane/ccdt.h"
#include "core/ccdt/relax/capacity_integral.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

constexpr int kCells = 96;

/// A density with steps between its sides.
struct Pattern {
    const char* name;
    int sides;
    int (*side)(double x, double y);
    /// @param low  density of side 0, if it is constant; side 1 has the density 1
    double (*density)(double x, double y, double low);
};

template <int (*kSide)(double, double)>
double two_values(double x, double y, double low) {
    return kSide(x, y) == 0 ? low : 1;
}

int half(double x, double) {
    return x < 0.5 ? 1 : 0;
}

int disc(double x, double y) {
    return std::hypot(x - 0.5, y - 0.5) < 0.3 ? 1 : 0;
}

int corner(double x, double y) {
    return x < 0.3 || y < 0.25 ? 1 : 0;
}

int stripes(double x, double y) {
    return static_cast<int>(5 * (x + y)) % 2;
}

int line(double x, double) {
    return std::abs(x - 0.5) < 0.02 ? 1 : 0;
}

int checkerboard(double x, double y) {
    return (static_cast<int>(8 * x) + static_cast<int>(8 * y)) % 2;
}

int blocks(double x, double y) {
    return static_cast<int>(8 * x) % 2 == 0 && static_cast<int>(8 * y) % 2 == 0 ? 1 : 0;
}

int stairs(double x, double) {
    return static_cast<int>(4 * x);
}

const std::array kPatterns{
    Pattern{"half", 2, half, two_values<half>},
    Pattern{"disc", 2, disc, two_values<disc>},
    Pattern{"corner", 2, corner, two_values<corner>},
    Pattern{"stripes", 2, stripes, two_values<stripes>},
    Pattern{"line", 2, line, two_values<line>},
    Pattern{"checkerboard", 2, checkerboard, two_values<checkerboard>},
    Pattern{"blocks", 2, blocks, two_values<blocks>},
    Pattern{"stairs", 4, stairs, [](double x, double y, double low) { return low + stairs(x, y); }},
    Pattern{"ramps", 2, half,
            [](double x, double y, double low) { return half(x, y) == 1 ? 0.1 + y : 3 * (low + 0.1 + y); }},
    Pattern{"ramp beside a plateau", 2, half,
            [](double x, double y, double low) { return half(x, y) == 1 ? 1 + 2 * x : low; }},
    Pattern{"antialiased disc", 2, disc,
            [](double x, double y, double low) {
                return std::lerp(low, 1, std::clamp(kCells * (0.3 - std::hypot(x - 0.5, y - 0.5)) + 0.5, 0.0, 1.0));
            }},
};

Density density_of(const Pattern& pattern, double low, int only = -1) {
    return test::grid_of(kCells, kCells, [&](int i, int j) {
        const double x = (i + 0.5) / kCells, y = (j + 0.5) / kCells;
        return only < 0 || pattern.side(x, y) == only ? pattern.density(x, y, low) : 0;
    });
}

Domain domain_of(int number) {
    if (number == 0) return Domain::rectangle(1, 1).value();
    if (number == 1) return Domain::torus(1, 1).value();
    return Domain::create({{{{0, 0}, {0.5, 0.01}, {1, 0}, {0.99, 0.5}, {1, 1}, {0, 1}}, {}}}).value();
}

/// Returns the share of the capacity on each side.
std::vector<double> shares_of(const Domain& domain, const Pattern& pattern, double low) {
    std::vector<double> shares;
    double all = 0;
    for (int side = 0; side < pattern.sides; ++side) {
        double largest = 0;
        for (int i = 0; i < kCells * kCells; ++i) {
            const double x = (i % kCells + 0.5) / kCells, y = (i / kCells + 0.5) / kCells;
            if (pattern.side(x, y) == side) largest = std::max(largest, pattern.density(x, y, low));
        }
        shares.push_back(0);
        if (!(largest > 0)) continue;
        const Density own = density_of(pattern, low, side);
        shares.back() = CapacityIntegral(domain, own).total() * largest / own.largest();
        all += shares.back();
    }
    for (double& share : shares) share /= all;
    return shares;
}

class Steps : public testing::TestWithParam<std::tuple<Quality, int>> {};

TEST_P(Steps, HaveTheirShareOfSitesOnEachSide) {
    const auto& [quality, number] = GetParam();
    const Domain domain = domain_of(number);
    for (const Pattern& pattern : kPatterns) {
        for (const double low : {0.0, 1e-6, 0.01, 0.1, 0.5}) {
            const Density density = density_of(pattern, low);
            const std::vector<double> shares = shares_of(domain, pattern, low);
            for (const std::size_t sites : {500u, 1500u}) {
                const auto run = distribute(domain, density, {.sites = sites, .seed = sites, .quality = quality});
                ASSERT_TRUE(run);
                std::vector<double> found(shares.size(), 0);
                for (const Point p : run->points) {
                    const auto centre = [](double v) { return (std::floor(v * kCells) + 0.5) / kCells; };
                    ++found[static_cast<std::size_t>(pattern.side(centre(p.x), centre(p.y)))];
                    EXPECT_GT(pattern.density(centre(p.x), centre(p.y), low), 0) << pattern.name;
                }
                for (std::size_t side = 0; side < shares.size(); ++side) {
                    const double exact = shares[side] * static_cast<double>(sites);
                    EXPECT_NEAR(found[side], exact, std::max(2.0, 0.02 * exact))
                        << pattern.name << ' ' << low << ' ' << sites << " side " << side;
                }
            }
        }
    }
}

std::string name_of(const testing::TestParamInfo<Steps::ParamType>& index) {
    constexpr std::array kQualities{"Draft", "Standard", "Best"};
    constexpr std::array kDomains{"Square", "Torus", "Polygon"};
    const auto& [quality, domain] = index.param;
    return std::string(kQualities[static_cast<std::size_t>(quality)]) + kDomains[static_cast<std::size_t>(domain)];
}

INSTANTIATE_TEST_SUITE_P(Qualities, Steps,
                         testing::Combine(testing::Values(Quality::Draft, Quality::Standard, Quality::Best),
                                          testing::Values(0, 1, 2)),
                         name_of);

}  // namespace
}  // namespace ccdt
