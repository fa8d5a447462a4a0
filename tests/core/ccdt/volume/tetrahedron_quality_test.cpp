// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/tetrahedron_quality.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/solids.h"

namespace ccdt {
namespace {

double volume_of(const TetrahedronMesh& mesh) {
    double sum = 0;
    for (const auto& [a, b, c, d] : mesh.tetrahedra) {
        const Point3 from = mesh.vertices[a];
        sum += dot(cross(mesh.vertices[b] - from, mesh.vertices[c] - from), mesh.vertices[d] - from) / 6;
    }
    return sum;
}

TEST(TetrahedronQuality, RemovesAnEdge) {
    // Three tetrahedra around a long edge become two that share the triangle in the middle.
    TetrahedronMesh mesh{{{0, 0, -1}, {0, 0, 1}}, {}};
    for (int i = 0; i < 3; ++i) {
        const double angle = 2 * std::numbers::pi * i / 3;
        mesh.vertices.push_back({std::cos(angle), std::sin(angle), 0});
    }
    mesh.tetrahedra = {{0, 1, 2, 3}, {0, 1, 3, 4}, {0, 1, 4, 2}};
    const double volume = volume_of(mesh), before = test::dihedral_angles(mesh).front();
    improve_tetrahedra(mesh, {}, [&](std::uint32_t v, Point3) { return mesh.vertices[v]; }, {});
    EXPECT_EQ(mesh.tetrahedra.size(), 2u);
    EXPECT_NEAR(volume_of(mesh), volume, 1e-12);
    EXPECT_GT(test::dihedral_angles(mesh).front(), before);
}

TEST(TetrahedronQuality, MovesAVertexOffAFace) {
    // The centre of a regular tetrahedron, moved almost to a face.
    TetrahedronMesh mesh{{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}, {-0.3, -0.3, -0.3}}, {}};
    mesh.tetrahedra = {{4, 1, 2, 3}, {0, 4, 2, 3}, {0, 1, 4, 3}, {0, 1, 2, 4}};
    if (volume_of(mesh) < 0) {
        for (Tetrahedron& corners : mesh.tetrahedra) std::swap(corners[0], corners[1]);
    }
    const double before = test::dihedral_angles(mesh).front();
    improve_tetrahedra(mesh, {}, [&](std::uint32_t v, Point3 to) { return v == 4 ? to : mesh.vertices[v]; }, {});
    EXPECT_GT(test::dihedral_angles(mesh).front(), before + 5);
    EXPECT_LT(length(mesh.vertices[4]), 0.4);
    EXPECT_EQ(mesh.vertices[0], (Point3{1, 1, 1}));
}

}  // namespace
}  // namespace ccdt
