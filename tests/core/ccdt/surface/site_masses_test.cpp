// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/site_masses.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "core/base/executor.h"
#include "core/ccdt/surface/initial_sites.h"
#include "tests/support/surfaces.h"

namespace ccdt {
namespace {

/// Returns a square with a picture of 256 x 256 texels, of which a block of 4 x 4 is black.
/// @param ground  grey level of the other texels
TriangleSoup square_with_block(std::uint8_t ground) {
    TriangleSoup soup = test::square_surface(1);
    for (const Point3& p : soup.vertices) soup.texture.push_back({static_cast<float>(p.x), static_cast<float>(p.y)});
    Material material;
    material.width = material.height = 256;
    soup.texels.assign(256 * 256, {ground, ground, ground, 255});
    for (std::size_t y = 80; y < 84; ++y) {
        for (std::size_t x = 150; x < 154; ++x) soup.texels[256 * y + x] = {0, 0, 0, 255};
    }
    soup.materials = {material};
    soup.material_of.assign(soup.triangles.size(), 0);
    return soup;
}

TEST(SiteMasses, DivideFacesOfUnevenDensityIntoFewPieces) {
    constexpr std::size_t kSites = 20'000;
    for (const std::uint8_t ground : std::array<std::uint8_t, 2>{254, 255}) {
        const TriangleSoup soup = square_with_block(ground);
        const auto made = Surface::create(soup, {});
        ASSERT_TRUE(made);
        const Surface& surface = made->surface;
        const double spacing = 1 / std::sqrt(kSites);
        const auto density = SurfaceDensity::of_colours(surface, soup, spacing);
        ASSERT_TRUE(density);
        double mass = 0;
        for (std::uint32_t f = 0; f < surface.face_count(); ++f) mass += density->mass(surface, f);
        SiteMasses masses(surface, *density, mass / kSites);
        EXPECT_LT(masses.piece_count(), 8 * kSites) << int{ground};
        const SurfaceTriangulation mesh(
            surface, initial_sites(surface, *density, kSites, 0), 0, [&](const SurfacePoint&) { return spacing; },
            choose_crease_vertices(surface, std::vector<double>(surface.vertex_count(), spacing), kSites),
            inline_executor());
        const auto measured = masses.measure(mesh);
        EXPECT_NEAR(std::accumulate(measured.begin(), measured.end(), 0.0), kSites, 1e-2 * kSites) << int{ground};
    }
}

}  // namespace
}  // namespace ccdt
