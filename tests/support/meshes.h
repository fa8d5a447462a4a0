// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/ccdt/border.h"
#include "core/ccdt/capacity_integral.h"
#include "core/ccdt/ccdt.h"
#include "core/ccdt/goals.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/mesh/triangulation.h"
#include "core/random.h"
#include "tests/support/shapes.h"

namespace ccdt::test {

/// A domain known to be valid.
Domain domain_of(const Parts& parts);

/// A density known to be valid, its cells filled from a function of their column and row.
template <class Function>
Density grid_of(int width, int height, Function&& value) {
    std::vector<double> values;
    for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) values.push_back(value(column, row));
    }
    return Density::grid(width, height, std::span<const double>(values)).value();
}

/// Sites placed in a domain and triangulated, as distribute() starts with.
struct StartMesh {
    StartMesh(Domain of, Density by, const Options& options);
    StartMesh(const StartMesh&) = delete;
    StartMesh& operator=(const StartMesh&) = delete;

    /// New goals from the capacities of the mesh as it stands.
    double measure();

    Domain domain;
    Density density;
    CapacityIntegral capacity;  // refers to the two above
    Border border;
    Triangulation mesh;
    std::vector<double> capacities;
    std::vector<TriangleGoal> goals;
};

/// Moves each site some way towards a corner of its ring: triangles stay counter-clockwise, edges do not stay Delaunay.
void stir(Triangulation& mesh, Random& random);

/// Invariants of a trimmed triangulation, each one counting what breaks it. Around a torus links have shifts, too.
std::size_t count_inverted(const Triangulation& mesh);
std::size_t count_not_delaunay(const Triangulation& mesh);
std::size_t count_bad_links(const Triangulation& mesh);

}  // namespace ccdt::test
