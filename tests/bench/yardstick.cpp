// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/yardstick.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <chrono>
#include <vector>

namespace ccdt::bench {

double delaunay_ms(std::span<const Point> points) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    std::vector<Kernel::Point_2> copy;
    copy.reserve(points.size());
    for (const Point& p : points) copy.emplace_back(p.x, p.y);
    const auto begin = std::chrono::steady_clock::now();
    const CGAL::Delaunay_triangulation_2<Kernel> triangulation(copy.begin(), copy.end());
    const auto end = std::chrono::steady_clock::now();
    return triangulation.number_of_vertices() > 0 ? std::chrono::duration<double, std::milli>(end - begin).count() : 0;
}

}  // namespace ccdt::bench
