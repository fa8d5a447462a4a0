// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/surface_density.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/surfaces.h"

namespace ccdt {
namespace {

constexpr double kPi = std::numbers::pi;

Surface made(const TriangleSoup& soup) {
    auto result = Surface::create(soup, {});
    EXPECT_TRUE(result) << result.error().message;
    return std::move(result->surface);
}

double total_mass(const Surface& surface, const SurfaceDensity& density) {
    double sum = 0;
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) sum += density.mass(surface, f);
    return sum;
}

/// Returns the density at the centre of the face whose centre is nearest to a point.
double at(const Surface& surface, const SurfaceDensity& density, Point3 p) {
    return density.at({surface.nearest(surface.from_input(p)).face, {1. / 3, 1. / 3, 1. / 3}});
}

TEST(SurfaceDensity, IsUniformByDefault) {
    const Surface surface = made(test::cube_surface());
    const SurfaceDensity density = SurfaceDensity::uniform();
    EXPECT_TRUE(density.is_uniform());
    EXPECT_EQ(density.at_corner(3, 1), 1);
    EXPECT_DOUBLE_EQ(total_mass(surface, density), 6);
}

TEST(SurfaceDensity, IsLinearBetweenValuesAtVertices) {
    TriangleSoup soup = test::square_surface(4);
    std::swap(soup.triangles[5][0], soup.triangles[5][1]);  // this triangle will be turned over
    std::vector<double> values;
    for (const Point3& p : soup.vertices) values.push_back(4e300 * (p.x + 2 * p.y));
    const Surface surface = made(soup);
    const auto density = SurfaceDensity::of_vertices(surface, soup, values);
    ASSERT_TRUE(density);
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const SurfacePoint point{f, {0.5, 0.3, 0.2}};
        const Point3 p = surface.position(point);
        EXPECT_NEAR(density->at(point), (p.x + 2 * p.y) / 3, 1e-12);
        EXPECT_NEAR(density->at_corner(f, 2), density->at({f, {0, 0, 1}}), 1e-12);
    }
    EXPECT_NEAR(total_mass(surface, *density), 0.5, 1e-12);
}

TEST(SurfaceDensity, RejectsUnusableValues) {
    const TriangleSoup soup = test::square_surface(1);
    const Surface surface = made(soup);
    const auto error = [&](std::vector<double> values) {
        const auto density = SurfaceDensity::of_vertices(surface, soup, values);
        return density ? Error{} : density.error();
    };
    EXPECT_EQ(error({1, 1, 1}).code, ErrorCode::Malformed);
    EXPECT_EQ(error({1, 1, -1, 1}).field, "density/2");
    EXPECT_EQ(error({1, 1, 1, std::numeric_limits<double>::quiet_NaN()}).field, "density/3");
    EXPECT_EQ(error({1, std::numeric_limits<double>::infinity(), 1, 1}).field, "density/1");
    EXPECT_EQ(SurfaceDensity::of_colours(surface, soup, 0.1).error().code, ErrorCode::Unusable);
}

TEST(SurfaceDensity, FollowsTheDarknessOfColours) {
    TriangleSoup soup = test::square_surface(1);
    soup.colours = {{0, 0, 0}, {0.5, 0.5, 0.5}, {1, 1, 1}, {0, 1, 0}};
    const Surface surface = made(soup);
    const auto density = SurfaceDensity::of_colours(surface, soup, 0.1);
    ASSERT_TRUE(density);
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        for (std::uint32_t k = 0; k < 3; ++k) {
            const Point3 p = surface.positions(f)[k];
            const double darkness[] = {1, 0.5, 0, 1 - 0.7152};
            EXPECT_NEAR(density->at_corner(f, k), darkness[static_cast<int>(p.x + 2 * p.y)], 1e-6);
        }
    }
    soup.colours.assign(4, {1, 1, 1});
    EXPECT_EQ(total_mass(surface, *SurfaceDensity::of_colours(surface, soup, 0.1)), 0);
    std::stop_source source;
    source.request_stop();
    EXPECT_EQ(SurfaceDensity::of_colours(surface, soup, 0.1, source.get_token()).error().code, ErrorCode::Stopped);
}

/// Adds a picture of dark and light squares, `cells` in each direction, to a soup. The dark ones have the darkness
/// `dark`, and the upper left one is dark.
void add_checker(TriangleSoup& soup, std::uint32_t cells, std::uint32_t texels_per_cell, Material material = {}) {
    material.width = material.height = cells * texels_per_cell;
    for (std::uint32_t y = 0; y < material.height; ++y) {
        for (std::uint32_t x = 0; x < material.width; ++x) {
            const bool is_dark = (x / texels_per_cell + y / texels_per_cell) % 2 == 0;
            const auto value = static_cast<std::uint8_t>(is_dark ? 0 : 255);
            soup.texels.push_back({value, value, value, 255});
        }
    }
    for (const Point3& p : soup.vertices) soup.texture.push_back({static_cast<float>(p.x), static_cast<float>(p.y)});
    soup.materials = {material};
    soup.material_of.assign(soup.triangles.size(), 0);
}

TEST(SurfaceDensity, FollowsAPictureWithinFaces) {
    TriangleSoup soup = test::square_surface(1);
    add_checker(soup, 4, 16);
    std::swap(soup.triangles[1][0], soup.triangles[1][1]);
    const Surface surface = made(soup);
    const auto density = SurfaceDensity::of_colours(surface, soup, 0.01);
    ASSERT_TRUE(density) << density.error().message;
    EXPECT_NEAR(total_mass(surface, *density), 0.5, 2e-3);
    for (int i = 0; i < 16; ++i) {
        const double x = (i % 4 + 0.5) / 4, y = (i / 4 + 0.4) / 4;
        const SurfacePoint at = surface.nearest(surface.from_input({x, y, 0}));
        EXPECT_NEAR(density->at(at), (i % 4 + i / 4) % 2 == 0 ? 1 : 0, 1e-6) << i;
    }
    EXPECT_EQ(density->largest(0), 1);
}

TEST(SurfaceDensity, AveragesDetailBelowTheSpacing) {
    TriangleSoup soup = test::square_surface(1);
    add_checker(soup, 128, 2);
    const Surface surface = made(soup);
    const auto density = SurfaceDensity::of_colours(surface, soup, 0.2);
    ASSERT_TRUE(density);
    EXPECT_NEAR(density->at(surface.nearest(surface.from_input({0.3, 0.4, 0}))), 0.5, 0.1);
}

TEST(SurfaceDensity, MultipliesColoursOfVerticesMaterialsAndPictures) {
    TriangleSoup soup = test::square_surface(1);
    Material material;
    material.factor = {0.5F, 0.5F, 0.5F, 0.25F};
    material.alpha = AlphaMode::Blend;
    add_checker(soup, 1, 1, material);
    soup.texels[0] = {255, 255, 255, 128};
    soup.colours.assign(4, {0.5F, 0.5F, 0.5F});
    const auto colour = soup.colour_at(0, {0.2, 0.3, 0.5});
    EXPECT_FLOAT_EQ(colour[0], 0.25F);
    EXPECT_NEAR(colour[3], 0.125, 1e-3);
    soup.materials[0].alpha = AlphaMode::Mask;
    EXPECT_EQ(soup.colour_at(0, {0.2, 0.3, 0.5})[3], 0);
    const Surface surface = made(soup);
    EXPECT_EQ(total_mass(surface, *SurfaceDensity::of_colours(surface, soup, 0.1)), 0);
    soup.materials[0].alpha = AlphaMode::Opaque;
    EXPECT_NEAR(total_mass(surface, *SurfaceDensity::of_colours(surface, soup, 0.1)), 0.75, 1e-6);
}

TEST(SurfaceDensity, WrapsPictureCoordinates) {
    TriangleSoup soup = test::square_surface(1);
    add_checker(soup, 2, 1);
    const auto at = [&](Wrap wrap, float s, float t) {
        soup.materials[0].wrap = {wrap, wrap};
        soup.texture.assign(soup.vertices.size(), {s, t});
        return soup.colour_at(0, {1, 0, 0})[0];
    };
    // The centres of the texels of the upper row are at 0.25, which is dark, and 0.75.
    for (const float turns : {-4.0F, 0.0F, 2.0F, 1e6F}) {
        EXPECT_EQ(at(Wrap::Repeat, turns + 0.25F, 0.25F), 0) << turns;
        EXPECT_EQ(at(Wrap::Mirror, turns + 0.25F, 0.25F), 0) << turns;
        EXPECT_EQ(at(Wrap::Repeat, turns + 1.25F, 0.25F), 0) << turns;
        EXPECT_EQ(at(Wrap::Mirror, turns + 1.25F, 0.25F), 1) << turns;
    }
    EXPECT_EQ(at(Wrap::Repeat, 0, 0.25F), 0.5F);
    EXPECT_EQ(at(Wrap::Mirror, 0, 0.25F), 0);
    EXPECT_EQ(at(Wrap::Mirror, 1, 0.25F), 1);
    EXPECT_EQ(at(Wrap::Clamp, -5, 0.25F), 0);
    EXPECT_EQ(at(Wrap::Clamp, 1e30F, 0.25F), 1);
    for (const Wrap wrap : {Wrap::Repeat, Wrap::Clamp, Wrap::Mirror}) {
        const float none = std::numeric_limits<float>::quiet_NaN();
        for (const float s : {none, 1e38F, -1e38F, std::numeric_limits<float>::infinity()})
            EXPECT_TRUE(at(wrap, s, s) >= 0 && at(wrap, s, s) <= 1);
    }
}

TEST(SurfaceDensity, IsUniformOnPlanesAndSpheres) {
    const Surface square = made(test::square_surface(10));
    const SurfaceDensity flat = SurfaceDensity::of_curvature(square, 0.1);
    EXPECT_NEAR(total_mass(square, flat), 1, 1e-9);
    const Surface sphere = made(test::sphere_surface(4));
    const SurfaceDensity round = SurfaceDensity::of_curvature(sphere, 0.05);
    for (std::uint32_t f = 0; f < sphere.face_count(); ++f) {
        EXPECT_NEAR(round.at_corner(f, 0), 4.5, 0.1);
    }
}

TEST(SurfaceDensity, FollowsTheCurvatureOfABend) {
    // A plane, a half cylinder with radius 1, and a plane again: a quarter of the area is bent.
    const Surface surface = made(test::grid_surface(400, 20, [](double u, double v) {
        const double length = 4 * kPi * u, bent = length - 1.5 * kPi;
        if (bent <= 0) return Point3{length, 3 * v, 0};
        if (bent >= kPi) return Point3{1.5 * kPi - (bent - kPi), 3 * v, 2};
        return Point3{1.5 * kPi + std::sin(bent), 3 * v, 1 - std::cos(bent)};
    }));
    const SurfaceDensity density = SurfaceDensity::of_curvature(surface, 0.01, 6);
    EXPECT_NEAR(at(surface, density, {1.5 * kPi + 1, 1.5, 1}), 1 + 5 / 1.25, 0.1);
    EXPECT_NEAR(at(surface, density, {2, 1.5, 0}), 1, 0.01);
    EXPECT_NEAR(at(surface, density, {2, 1.5, 2}), 1, 0.01);
}

TEST(SurfaceDensity, IgnoresCurvatureBelowTheSpacing) {
    // Ripples whose length is a third of the spacing, and a bend.
    const auto ripples = [](double size) {
        return made(test::grid_surface(300, 30, [size](double u, double v) {
            return Point3{10 * u, v, std::cosh(10 * u - 5) / 50 + size * std::cos(2 * kPi * 30 * u)};
        }));
    };
    const Surface smooth = ripples(0), rough = ripples(0.01);
    const SurfaceDensity wanted = SurfaceDensity::of_curvature(smooth, 0.1);
    const SurfaceDensity found = SurfaceDensity::of_curvature(rough, 0.1);
    const SurfaceDensity fine = SurfaceDensity::of_curvature(rough, 1e-4);
    std::vector<double> expected(smooth.face_count());  // [triangles of the soup]
    for (std::uint32_t f = 0; f < expected.size(); ++f) expected[smooth.triangle_of(f)] = wanted.at_corner(f, 0);
    double error = 0, fine_error = 0;
    for (std::uint32_t f = 0; f < rough.face_count(); ++f) {
        const double value = expected[rough.triangle_of(f)];
        error = std::max(error, std::abs(found.at_corner(f, 0) - value));
        fine_error = std::max(fine_error, std::abs(fine.at_corner(f, 0) - value));
    }
    EXPECT_LT(error, 1);
    EXPECT_GT(fine_error, 2);
}

}  // namespace
}  // namespace ccdt
