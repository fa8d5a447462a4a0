// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/device_gamut.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "core/base/random.h"

namespace ccdt {
namespace {

Light random_light(Random& random) {
    const auto value = [&] { return static_cast<float>(random.uniform()); };
    const float red = value(), green = value();
    return {red, green, value()};
}

/// Returns a mixture of colours with random weights.
Light random_mixture(const std::vector<Light>& colours, Random& random) {
    std::vector<double> weights;
    double sum = 0;
    for (std::size_t i = 0; i < colours.size(); ++i) sum += weights.emplace_back(-std::log(1 - random.uniform()));
    Light light;
    for (std::size_t i = 0; i < colours.size(); ++i) {
        const auto weight = static_cast<float>(weights[i] / sum);
        light.red += weight * colours[i].red;
        light.green += weight * colours[i].green;
        light.blue += weight * colours[i].blue;
    }
    return light;
}

double difference(const Light& a, const Light& b) {
    const auto lab = [](const Light& light) { return lab_of({light.red, light.green, light.blue}); };
    const Lab one = lab(a), other = lab(b);
    return std::hypot(one[0] - other[0], one[1] - other[1], one[2] - other[2]);
}

std::vector<Light> primaries() {
    return {{0, 0, 0}, {1, 1, 1}, {0.8f, 0.7f, 0.05f}, {0.45f, 0.02f, 0.02f}, {0.02f, 0.1f, 0.5f}, {0, 0.1f, 0.02f}};
}

TEST(DeviceGamut, KeepsMixturesOfDeviceColours) {
    const DeviceGamut gamut(primaries());
    Random random(1, 0);
    for (int i = 0; i < 1000; ++i) {
        const Light light = random_mixture(primaries(), random);
        EXPECT_LT(difference(gamut.nearest(light), light), 1e-3);
    }
}

TEST(DeviceGamut, FindsColoursThatNoMixtureBeatsByMuch) {
    const DeviceGamut gamut(primaries());
    Random random(2, 0);
    std::vector<Light> mixtures;
    for (int i = 0; i < 20'000; ++i) mixtures.push_back(random_mixture(primaries(), random));
    double worse = 0;
    constexpr int kColours = 60;
    for (int i = 0; i < kColours; ++i) {
        const Light light = random_light(random);
        const double found = difference(gamut.nearest(light), light);
        double least = found;
        for (const Light& mixture : mixtures) least = std::min(least, difference(mixture, light));
        worse += found - least;
    }
    // The distance is linearised, so some colours are not the nearest ones.
    EXPECT_LT(worse / kColours, 3);
}

TEST(DeviceGamut, ReturnsColoursOfTheGamut) {
    const DeviceGamut gamut(primaries());
    Random random(3, 0);
    for (int i = 0; i < 500; ++i) {
        const Light nearest = gamut.nearest(random_light(random));
        EXPECT_LT(difference(gamut.nearest(nearest), nearest), 0.01);
    }
}

TEST(DeviceGamut, ChangesContinuously) {
    const DeviceGamut gamut(primaries());
    Light before = gamut.nearest({0, 1, 0.3f});
    for (int i = 1; i <= 4000; ++i) {
        const float t = static_cast<float>(i) / 4000;
        const Light now = gamut.nearest({t, 1 - t, 0.3f});
        EXPECT_LT(
            std::abs(now.red - before.red) + std::abs(now.green - before.green) + std::abs(now.blue - before.blue),
            0.01)
            << t;
        before = now;
    }
}

TEST(DeviceGamut, MapsToTheSegmentBetweenTwoColours) {
    const DeviceGamut gamut(std::vector<Light>{{0, 0, 0}, {1, 1, 1}});
    for (const Light& light : {Light{1, 0, 0}, Light{0, 0, 1}, Light{0.5f, 0.5f, 0.5f}, Light{1, 1, 1}}) {
        const Light nearest = gamut.nearest(light);
        EXPECT_FLOAT_EQ(nearest.red, nearest.green);
        EXPECT_FLOAT_EQ(nearest.green, nearest.blue);
    }
    EXPECT_NEAR(gamut.nearest({0.5f, 0.5f, 0.5f}).red, 0.5, 1e-6);
}

TEST(DeviceGamut, MapsToTheTriangleBetweenThreeColours) {
    const DeviceGamut gamut(std::vector<Light>{{0, 0, 0}, {1, 1, 1}, {1, 0, 0}});
    const Light nearest = gamut.nearest({0.3f, 0.6f, 0.6f});
    EXPECT_FLOAT_EQ(nearest.green, nearest.blue);
    const Light pink = gamut.nearest({0.8f, 0.4f, 0.4f});
    EXPECT_NEAR(pink.red, 0.8, 1e-5);
    EXPECT_NEAR(pink.green, 0.4, 1e-5);
}

TEST(DeviceGamut, AcceptsMoreColoursOnOneLine) {
    const DeviceGamut gamut(std::vector<Light>{{0, 0, 0}, {0.2f, 0.2f, 0.2f}, {0.5f, 0.5f, 0.5f}, {1, 1, 1}});
    EXPECT_NEAR(gamut.nearest({0.3f, 0.3f, 0.3f}).green, 0.3, 1e-5);
}

}  // namespace
}  // namespace ccdt
