// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include "core/ccdt/surface/surface.h"
#include "core/ccdt/volume/solid.h"
#include "core/ccdt/volume/tetrahedron_mesh.h"
#include "core/ccdt/volume/volume_construction.h"
#include "tests/support/surfaces.h"

namespace ccdt::test {

inline TriangleSoup moved(TriangleSoup soup, double scale, Point3 by) {
    for (Point3& p : soup.vertices) p = scale * p + by;
    return soup;
}

/// Returns a soup with the other orientation.
inline TriangleSoup turned_over(TriangleSoup soup) {
    for (auto& triangle : soup.triangles) std::swap(triangle[1], triangle[2]);
    return soup;
}

inline Surface surface_of(const TriangleSoup& soup) {
    return std::move(Surface::create(soup, std::nullopt)->surface);
}

inline Solid solid_of(const TriangleSoup& soup) {
    return *Solid::create(surface_of(soup));
}

/// Returns the six dihedral angles of each tetrahedron of a mesh, sorted, in degrees.
/// @param periods  sides of a torus; 0 for other domains
inline std::vector<double> dihedral_angles(const TetrahedronMesh& mesh, Point3 periods = {}) {
    std::vector<double> angles;
    for (const Tetrahedron& corners : mesh.tetrahedra) {
        std::array<Point3, 4> p;
        for (std::size_t i = 0; i < 4; ++i) {
            p[i] = mesh.vertices[corners[i]] - mesh.vertices[corners[0]];
            if (periods.x > 0) {
                p[i] = p[i] - Point3{periods.x * std::round(p[i].x / periods.x),
                                     periods.y * std::round(p[i].y / periods.y),
                                     periods.z * std::round(p[i].z / periods.z)};
            }
        }
        for (std::size_t i = 0; i < 4; ++i) {
            for (std::size_t j = i + 1; j < 4; ++j) {
                const std::size_t k = i == 0 ? (j == 1 ? 2 : 1) : 0, l = 6 - i - j - k;
                const Point3 a = cross(p[j] - p[i], p[k] - p[i]), b = cross(p[j] - p[i], p[l] - p[i]);
                const double cosine = std::clamp(dot(a, b) / (length(a) * length(b)), -1.0, 1.0);
                angles.push_back(std::acos(cosine) * 180 / std::numbers::pi);
            }
        }
    }
    std::ranges::sort(angles);
    return angles;
}

/// Checks that a distribution in space ends with its current points after a stop in any of the given steps of its
/// progress.
/// @param distribute  takes options and a control
template <class Distribute>
void expect_stops(std::initializer_list<int> steps, Distribute distribute) {
    for (const int step : steps) {
        std::stop_source source;
        int calls = 0;
        Control control{.stop = source.get_token()};
        control.progress = [&](const Progress&) {
            if (calls++ == step) source.request_stop();
        };
        const Result<VolumeDistribution> result = distribute(VolumeOptions{.sites = 500, .keep_mesh = true}, control);
        ASSERT_TRUE(result);
        EXPECT_TRUE(result->stopped);
        EXPECT_EQ(result->points.size(), 500U);
        EXPECT_FALSE(result->mesh);
        EXPECT_EQ(calls, step + 1);
    }
}

}  // namespace ccdt::test
