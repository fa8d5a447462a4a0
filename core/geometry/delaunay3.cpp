// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/delaunay3.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/Triangulation_cell_base_3.h>
#include <CGAL/Triangulation_data_structure_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>

#include <utility>

// CGAL's functions of this name branch on signs of intervals. An uncertain sign makes them throw an exception, which
// CGAL catches; there are no exceptions in WebAssembly. These overloads return an uncertain sign instead, after which
// CGAL computes exactly, too.
namespace CGAL {

using Interval = Interval_nt<false>;

inline bool is_zero(const Uncertain<Sign>& sign) {
    return sign.is_certain() && sign.make_certain() == ZERO;
}

inline Uncertain<Sign> coplanar_orientationC3(const Interval& px, const Interval& py, const Interval& pz,
                                              const Interval& qx, const Interval& qy, const Interval& qz,
                                              const Interval& rx, const Interval& ry, const Interval& rz) {
    Uncertain<Sign> sign = orientationC2(px, py, qx, qy, rx, ry);
    if (is_zero(sign)) sign = orientationC2(py, pz, qy, qz, ry, rz);
    if (is_zero(sign)) sign = orientationC2(px, pz, qx, qz, rx, rz);
    return sign;
}

inline Uncertain<Sign> coplanar_orientationC3(const Interval& px, const Interval& py, const Interval& pz,
                                              const Interval& qx, const Interval& qy, const Interval& qz,
                                              const Interval& rx, const Interval& ry, const Interval& rz,
                                              const Interval& sx, const Interval& sy, const Interval& sz) {
    const auto product = [](const Uncertain<Sign>& a, const Uncertain<Sign>& b) { return a.is_certain() ? a * b : a; };
    const Uncertain<Sign> xy = orientationC2(px, py, qx, qy, rx, ry);
    if (!is_zero(xy)) return product(xy, orientationC2(px, py, qx, qy, sx, sy));
    const Uncertain<Sign> yz = orientationC2(py, pz, qy, qz, ry, rz);
    if (!is_zero(yz)) return product(yz, orientationC2(py, pz, qy, qz, sy, sz));
    return product(orientationC2(px, pz, qx, qz, rx, rz), orientationC2(px, pz, qx, qz, sx, sz));
}

}  // namespace CGAL

namespace ccdt {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;
using Structure = CGAL::Triangulation_data_structure_3<VertexBase, CGAL::Triangulation_cell_base_3<Kernel>>;
using Triangulation = CGAL::Delaunay_triangulation_3<Kernel, Structure>;
using Numbered = std::pair<Kernel::Point_3, std::uint32_t>;
using Order = CGAL::Spatial_sort_traits_adapter_3<Kernel, CGAL::First_of_pair_property_map<Numbered>>;

constexpr std::size_t kStopStride = 256;  ///< points between polls of the stop token

}  // namespace

std::vector<Tetrahedron> delaunay_tetrahedra(std::span<const Point3> points, const std::stop_token& stop) {
    std::vector<Numbered> numbered;
    numbered.reserve(points.size());
    for (const Point3 p : points)
        numbered.emplace_back(Kernel::Point_3(p.x, p.y, p.z), static_cast<std::uint32_t>(numbered.size()));
    CGAL::spatial_sort(numbered.begin(), numbered.end(), Order());
    Triangulation triangulation;
    Triangulation::Cell_handle nearby;
    for (std::size_t i = 0; i < numbered.size(); ++i) {
        if (i % kStopStride == 0 && stop.stop_requested()) return {};
        const auto vertex = triangulation.insert(numbered[i].first, nearby);
        vertex->info() = numbered[i].second;
        nearby = vertex->cell();
    }
    std::vector<Tetrahedron> tetrahedra;
    if (triangulation.dimension() < 3) return tetrahedra;
    tetrahedra.reserve(triangulation.number_of_cells());
    for (const auto cell : triangulation.finite_cell_handles()) {
        Tetrahedron& corners = tetrahedra.emplace_back();
        for (int i = 0; i < 4; ++i) corners[static_cast<std::size_t>(i)] = cell->vertex(i)->info();
    }
    return tetrahedra;
}

}  // namespace ccdt
