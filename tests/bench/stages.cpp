// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/stages.h"

#include <algorithm>

#include "core/ccdt/plane/placement.h"
#include "core/ccdt/plane/start.h"
#include "core/ccdt/relax/border.h"
#include "core/ccdt/relax/capacity_integral.h"
#include "core/ccdt/relax/goals.h"
#include "core/ccdt/relax/relaxation.h"
#include "core/mesh/flips.h"
#include "core/mesh/inside.h"
#include "core/mesh/triangulation.h"

namespace ccdt::bench {

Stages time_stages(const Domain& domain, const Density& density, const Options& options) {
    Stages stages;
    Clock clock;
    const CapacityIntegral capacity(domain, density);
    const Border border = make_border(domain, capacity, options.sites);
    const StartSites start(domain, density, options);
    stages.start = clock.lap();
    Triangulation mesh = mesh_of_border(options.sites, *triangulate(border));
    place_sites(mesh, {}, start, {}, options.seed, 0, {});
    trim(mesh);
    stages.triangulate = clock.lap();

    std::vector<double> capacities;
    std::vector<TriangleGoal> goals;
    const auto measure = [&] {
        capacity.of_triangles(mesh, capacities);
        set_goals(mesh, capacity, capacities, goals);
        stages.capacity += clock.lap();
    };
    measure();
    Relaxation relaxation(mesh, border.corner, capacity.is_uniform(), {});
    for (int iteration = 0; iteration < options.iterations; ++iteration) {
        relaxation.prepare(goals);
        for (int pass = 0; pass < options.passes; ++pass) relaxation.pass();
        stages.geometry += clock.lap();
        restore_delaunay(mesh);
        stages.flips += clock.lap();
        measure();
    }
    return stages;
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values.empty() ? 0 : values[values.size() / 2];
}

}  // namespace ccdt::bench
