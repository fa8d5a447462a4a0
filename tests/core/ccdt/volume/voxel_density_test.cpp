// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/voxel_density.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

constexpr Box3 kAll{{0, 0, 0}, {1, 1, 1}};

/// Returns 3 x 2 x 2 voxels with the values 0, 1, ..., 11.
VoxelDensity steps() {
    std::vector<double> values;
    for (int i = 0; i < 12; ++i) values.push_back(i);
    return *VoxelDensity::create({3, 2, 2}, values);
}

TEST(VoxelDensity, IsRelativeToItsMean) {
    const VoxelDensity density = steps();
    EXPECT_NEAR(density.at({0.1, 0.1, 0.1}), 0, 1e-12);
    EXPECT_NEAR(density.at({0.5, 0.1, 0.1}), 1 / 5.5, 1e-12);
    EXPECT_NEAR(density.at({0.5, 0.7, 0.1}), 4 / 5.5, 1e-12);
    EXPECT_NEAR(density.at({1, 1, 1}), 11 / 5.5, 1e-12);
}

TEST(VoxelDensity, FindsItsGaps) {
    const VoxelDensity density = steps();
    EXPECT_TRUE(density.has_gaps());
    EXPECT_FALSE(density.is_positive({0.3, 0.4, 0.4}));
    EXPECT_TRUE(density.is_positive({0.4, 0.4, 0.4}));
    EXPECT_TRUE(density.is_positive({0.3, 0.4, 0.6}));
    EXPECT_FALSE(VoxelDensity::uniform().has_gaps());
    EXPECT_FALSE(VoxelDensity::create({2, 1, 1}, std::array{1.0, 1e-15})->has_gaps());
    EXPECT_FALSE(VoxelDensity::create({2, 1, 1}, std::array{1.0, 1e-16})->is_positive({0.9, 0.5, 0.5}));
}

TEST(VoxelDensity, MeasuresTheMassOfBoxes) {
    const VoxelDensity density = steps();
    EXPECT_NEAR(density.mass(kAll), 1, 1e-15);
    EXPECT_NEAR(density.mass({{0, 0, 0.5}, {1, 1, 1}}), 51.0 / 66, 1e-15);
    EXPECT_NEAR(density.mass({{1.0 / 3, 0.25, 0.25}, {2.0 / 3, 0.5, 0.5}}), 1.0 / 66 / 4, 1e-15);
}

TEST(VoxelDensity, HasTheContrastOfTheAveragePoint) {
    EXPECT_NEAR(steps().contrast(), 506.0 * 12 / (66 * 66), 1e-12);
    EXPECT_EQ(VoxelDensity::uniform().contrast(), 1);
}

TEST(VoxelDensity, CutsSharesOfTheMass) {
    for (const VoxelDensity& density : {steps(), VoxelDensity::uniform()}) {
        for (const Box3& box : {kAll, Box3{{0.2, 0.1, 0.4}, {0.9, 0.45, 0.95}}}) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                for (const double share : {0.01, 0.5, 0.9}) {
                    Box3 part = box;
                    along(part.max, axis) = density.cut(box, axis, share);
                    EXPECT_NEAR(density.mass(part), share * density.mass(box), 1e-14);
                }
            }
        }
    }
}

TEST(VoxelDensity, CutsEmptyBoxesEvenly) {
    EXPECT_DOUBLE_EQ(steps().cut({{0, 0, 0}, {0.2, 0.2, 0.2}}, 0, 0.25), 0.05);
}

TEST(VoxelDensity, DrawsInProportion) {
    const VoxelDensity density = steps();
    Random random(1, 0);
    std::array<double, 12> counts{};
    constexpr int kDrawn = 66'000;
    for (int i = 0; i < kDrawn; ++i) {
        const double x = random.uniform(), y = random.uniform(), z = random.uniform();
        const Point3 p = density.draw(kAll, {x, y, z});
        ++counts[static_cast<std::size_t>(p.x * 3) + 3 * static_cast<std::size_t>(p.y * 2) +
                 6 * static_cast<std::size_t>(p.z * 2)];
    }
    EXPECT_EQ(counts[0], 0);
    for (std::size_t i = 1; i < 12; ++i) EXPECT_NEAR(counts[i], 1000.0 * double(i), 5 * std::sqrt(1000.0 * double(i)));
}

TEST(VoxelDensity, IsUniformIfAllValuesAreEqual) {
    EXPECT_TRUE(VoxelDensity::create({2, 1, 1}, std::array{3.0, 3.0})->is_uniform());
}

TEST(VoxelDensity, AcceptsTinyAndHugeValues) {
    const double tiny = 1e-308, huge = std::numeric_limits<double>::max();
    EXPECT_NEAR(VoxelDensity::create({2, 1, 1}, std::array{tiny, 3 * tiny})->at({0.9, 0, 0}), 1.5, 1e-12);
    EXPECT_NEAR(VoxelDensity::create({2, 1, 1}, std::array{huge, 0.0})->at({0.1, 0, 0}), 2, 1e-12);
}

TEST(VoxelDensity, RejectsUnusableValues) {
    const auto code = [](std::initializer_list<double> values) {
        const auto density = VoxelDensity::create({2, 1, 1}, std::vector<double>(values));
        return density ? std::string() : density.error().field;
    };
    EXPECT_EQ(code({1, 2, 3}), "density");
    EXPECT_EQ(code({1, -1}), "density/1");
    EXPECT_EQ(code({std::numeric_limits<double>::quiet_NaN(), 1}), "density/0");
    EXPECT_EQ(code({1, std::numeric_limits<double>::infinity()}), "density/1");
    EXPECT_EQ(code({0, 0}), "density");
    EXPECT_EQ(VoxelDensity::create({2, 1, 1}, std::array{0.0, 0.0}).error().code, ErrorCode::Unusable);
    EXPECT_EQ(VoxelDensity::create({0, 1, 1}, {}).error().code, ErrorCode::Malformed);
    constexpr std::size_t kHuge = std::size_t{1} << 32;  // its square overflows to 0
    EXPECT_EQ(VoxelDensity::create({kHuge, kHuge, 1}, {}).error().code, ErrorCode::Malformed);
}

}  // namespace
}  // namespace ccdt
