#include "core/geometry/delaunay.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Constrained_triangulation_face_base_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Spatial_sort_traits_adapter_2.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>

#include <utility>

namespace ccdt {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
using FaceBase = CGAL::Triangulation_face_base_with_info_2<std::uint32_t, Kernel,
                                                           CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Triangulation =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure,
                                               CGAL::No_constraint_intersection_requiring_constructions_tag>;

constexpr std::size_t kStopStride = 256;  ///< points, or segments, between two looks at the stop token

Kernel::Point_2 to_cgal(Point p) {
    return {p.x, p.y};
}

/// @returns  [points] or, once a stop is asked for, none; of points that coincide only one has a vertex
std::vector<Triangulation::Vertex_handle> insert_points(Triangulation& triangulation, std::span<const Point> points,
                                                        const std::stop_token& stop) {
    using Numbered = std::pair<Kernel::Point_2, std::uint32_t>;
    using Order = CGAL::Spatial_sort_traits_adapter_2<Kernel, CGAL::First_of_pair_property_map<Numbered>>;
    std::vector<Numbered> numbered;
    numbered.reserve(points.size());
    for (const Point& p : points) numbered.emplace_back(to_cgal(p), static_cast<std::uint32_t>(numbered.size()));
    CGAL::spatial_sort(numbered.begin(), numbered.end(), Order());

    Triangulation::Face_handle nearby;
    for (std::size_t i = 0; i < numbered.size(); ++i) {
        if (i % kStopStride == 0 && stop.stop_requested()) return {};
        const auto vertex = triangulation.insert(numbered[i].first, nearby);
        vertex->info() = numbered[i].second;
        nearby = vertex->face();
    }
    std::vector<Triangulation::Vertex_handle> handles(points.size());
    for (auto v : triangulation.finite_vertex_handles()) handles[v->info()] = v;
    return handles;
}

ConstrainedDelaunay::Triangle copy_face(const Triangulation& triangulation, Triangulation::Face_handle face) {
    ConstrainedDelaunay::Triangle copy{};
    for (int i = 0; i < 3; ++i) {
        const auto edge = static_cast<std::size_t>(i);
        const int opposite = Triangulation::cw(i);  // CGAL names an edge by the corner that faces it
        copy.corners[edge] = face->vertex(i)->info();
        const auto neighbour = face->neighbor(opposite);
        copy.neighbours[edge] = triangulation.is_infinite(neighbour) ? ConstrainedDelaunay::kNone : neighbour->info();
        copy.constrained[edge] = face->is_constrained(opposite);
    }
    return copy;
}

}  // namespace

tl::expected<ConstrainedDelaunay, SegmentConflict> constrained_delaunay(std::span<const Point> points,
                                                                        std::span<const Segment> segments,
                                                                        const std::stop_token& stop) {
    ConstrainedDelaunay result;
    result.points.assign(points.begin(), points.end());
    for (const Point corner : {Point{-1, -1}, Point{2, -1}, Point{2, 2}, Point{-1, 2}}) result.points.push_back(corner);

    Triangulation triangulation;
    const auto handles = insert_points(triangulation, result.points, stop);
    if (handles.empty()) return result;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        if (i % kStopStride == 0 && stop.stop_requested()) return result;
        const auto a = handles[segments[i][0]];
        const auto b = handles[segments[i][1]];
        // Of points that coincide only one has become a vertex.
        if (a == nullptr || b == nullptr) return tl::unexpected(SegmentConflict{i});
        try {
            triangulation.insert_constraint(a, b);
        } catch (const Triangulation::Intersection_of_constraints_exception&) {
            return tl::unexpected(SegmentConflict{i});
        }
        // A point on the segment splits it silently.
        if (!triangulation.is_edge(a, b)) return tl::unexpected(SegmentConflict{i});
    }

    std::uint32_t count = 0;
    for (auto face : triangulation.finite_face_handles()) face->info() = count++;
    result.triangles.reserve(count);
    for (auto face : triangulation.finite_face_handles()) result.triangles.push_back(copy_face(triangulation, face));
    return result;
}

int exact_orientation(Point a, Point b, Point c) {
    return static_cast<int>(CGAL::orientation(to_cgal(a), to_cgal(b), to_cgal(c)));
}

int exact_in_circle(Point a, Point b, Point c, Point d) {
    return static_cast<int>(CGAL::side_of_oriented_circle(to_cgal(a), to_cgal(b), to_cgal(c), to_cgal(d)));
}

}  // namespace ccdt
