// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/base/random.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/ccdt/relax/border.h"
#include "core/ccdt/relax/capacity_integral.h"
#include "core/ccdt/relax/goals.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/mesh/triangulation.h"
#include "tests/support/shapes.h"

namespace ccdt::test {

/// Returns the domain of parts that are known to be valid.
Domain domain_of(const Parts& parts);

/// Returns a density whose cells have the values value(column, row), which are known to be valid.
template <class Function>
Density grid_of(int width, int height, Function&& value) {
    std::vector<double> values;
    for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) values.push_back(value(column, row));
    }
    return Density::grid(width, height, std::span<const double>(values)).value();
}

/// Sites placed in a domain and triangulated, as at the start of distribute().
struct StartMesh {
    StartMesh(Domain of, Density by, const Options& options);
    StartMesh(const StartMesh&) = delete;
    StartMesh& operator=(const StartMesh&) = delete;

    /// Measures the capacities of the current mesh and sets the goals from them. Returns the capacity variation.
    double measure();

    Domain domain;
    Density density;
    CapacityIntegral capacity;  ///< refers to `domain` and `density`
    Border border;
    Triangulation mesh;
    std::vector<double> capacities;
    std::vector<TriangleGoal> goals;
};

/// Moves each site by a random distance towards one of its neighbours. Triangles stay counter-clockwise; edges may lose
/// the Delaunay property.
void stir(Triangulation& mesh, Random& random);

/// Returns the number of triangles that are not counter-clockwise.
std::size_t count_inverted(const Triangulation& mesh);

/// Returns the number of half-edges that are not Delaunay.
std::size_t count_not_delaunay(const Triangulation& mesh);

/// Returns the number of half-edges, triangles and vertices of a trimmed triangulation with inconsistent links or
/// shifts.
std::size_t count_bad_links(const Triangulation& mesh);

}  // namespace ccdt::test
