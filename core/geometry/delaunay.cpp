// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/delaunay.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Constrained_triangulation_face_base_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Spatial_sort_traits_adapter_2.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>
#include <boost/multiprecision/cpp_int.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <unordered_map>
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

using Vertex = Triangulation::Vertex_handle;
using Face = Triangulation::Face_handle;
using Kind = Arrangement::Meeting::Kind;

#ifdef __SIZEOF_FLOAT128__
__extension__ using Wide = __float128;  // quadruple precision, for which the standard has no name
constexpr Wide kEpsilon = 0x1p-112;
#else
using Wide = long double;
constexpr Wide kEpsilon = std::numeric_limits<Wide>::epsilon();
#endif

/// Arithmetic without rounding, by a library that CGAL needs, too. Conversion to double rounds to the nearest.
using Exact = boost::multiprecision::cpp_rational;

Wide size(Wide value) {
    return value < 0 ? -value : value;
}

constexpr std::size_t kStopStride = 256;  ///< points or segments between polls of the stop token

Kernel::Point_2 to_cgal(Point p) {
    return {p.x, p.y};
}

/// Inserts points in spatial order.
/// @returns  [points] the vertex of each point; empty after a stop. Coincident points share a vertex, which has the
///           number of one of them.
std::vector<Vertex> insert_points(Triangulation& triangulation, std::span<const Point> points,
                                  const std::stop_token& stop) {
    using Numbered = std::pair<Kernel::Point_2, std::uint32_t>;
    using Order = CGAL::Spatial_sort_traits_adapter_2<Kernel, CGAL::First_of_pair_property_map<Numbered>>;
    std::vector<Numbered> numbered;
    numbered.reserve(points.size());
    for (const Point& p : points) numbered.emplace_back(to_cgal(p), static_cast<std::uint32_t>(numbered.size()));
    CGAL::spatial_sort(numbered.begin(), numbered.end(), Order());

    std::vector<Vertex> vertices(points.size());
    Face nearby;
    for (std::size_t i = 0; i < numbered.size(); ++i) {
        if (i % kStopStride == 0 && stop.stop_requested()) return {};
        const auto vertex = triangulation.insert(numbered[i].first, nearby);
        vertex->info() = numbered[i].second;
        vertices[numbered[i].second] = vertex;
        nearby = vertex->face();
    }
    return vertices;
}

std::vector<Point> with_box(std::span<const Point> points) {
    std::vector<Point> all(points.begin(), points.end());
    for (const Point corner : {Point{-1, -1}, Point{2, -1}, Point{2, 2}, Point{-1, 2}}) all.push_back(corner);
    return all;
}

/// @returns  for each of the first `count` points, the number of its vertex
std::vector<std::uint32_t> numbers_of(std::span<const Vertex> vertices, std::size_t count) {
    std::vector<std::uint32_t> numbers(count);
    for (std::size_t i = 0; i < count; ++i) numbers[i] = vertices[i]->info();
    return numbers;
}

/// Copies all finite faces, in CGAL's order.
///
/// @param set_edge  sets the data of an edge; arguments: (face, corner opposite the edge, triangle, edge number)
template <class Triangle, class SetEdge>
std::vector<Triangle> copy_faces(const Triangulation& triangulation, SetEdge set_edge) {
    std::uint32_t count = 0;
    for (auto face : triangulation.finite_face_handles()) face->info() = count++;
    std::vector<Triangle> triangles;
    triangles.reserve(count);
    for (auto face : triangulation.finite_face_handles()) {
        Triangle& copy = triangles.emplace_back();
        for (int i = 0; i < 3; ++i) {
            const auto edge = static_cast<std::size_t>(i);
            const int opposite = Triangulation::cw(i);  // CGAL identifies an edge by the opposite corner
            copy.corners[edge] = face->vertex(i)->info();
            const auto neighbour = face->neighbor(opposite);
            copy.neighbours[edge] =
                triangulation.is_infinite(neighbour) ? ConstrainedDelaunay::kNone : neighbour->info();
            set_edge(face, opposite, copy, edge);
        }
    }
    return triangles;
}

/// Lists the segments that begin at coincident points, sorted by their vertices.
std::vector<ConstrainedDelaunay::Branch> find_branches(std::span<const std::uint32_t> vertex_of,
                                                       std::span<const Segment> segments) {
    std::vector<bool> is_shared(vertex_of.size(), false);
    bool any = false;
    for (std::uint32_t i = 0; i < vertex_of.size(); ++i) {
        if (vertex_of[i] == i) continue;
        is_shared[i] = is_shared[vertex_of[i]] = any = true;
    }
    std::vector<ConstrainedDelaunay::Branch> branches;
    if (!any) return branches;
    for (const auto& [from, to] : segments) {
        if (is_shared[from]) branches.push_back({{vertex_of[from], vertex_of[to]}, from});
    }
    std::ranges::sort(branches, {}, &ConstrainedDelaunay::Branch::vertices);
    return branches;
}

/// Computes the same value as exact_crossing() in quadruple precision; returns none if that precision does not suffice.
std::optional<Point> quick_crossing(Point a, Point b, Point c, Point d) {
    constexpr int kRoundings = 8;  // more roundings than in any of the sums below
    const Wide ux = Wide{b.x} - a.x, uy = Wide{b.y} - a.y, vx = Wide{d.x} - c.x, vy = Wide{d.y} - c.y;
    const Wide wx = Wide{c.x} - a.x, wy = Wide{c.y} - a.y;
    const Wide below = ux * vy - uy * vx, below_error = kRoundings * kEpsilon * (size(ux * vy) + size(uy * vx));
    const Wide above = wx * vy - wy * vx, above_error = kRoundings * kEpsilon * (size(wx * vy) + size(wy * vx));
    if (!(size(below) > 2 * below_error)) return std::nullopt;
    const Wide share = above / below;
    const Wide share_error = 2 * (above_error + size(share) * below_error) / size(below) + kEpsilon * size(share);
    const auto coordinate = [&](double from, Wide along, double other, Wide other_along) -> std::optional<double> {
        if (along == 0) return from;
        if (other_along == 0) return other;
        const Wide at = from + share * along;
        const Wide error = size(along) * share_error + kRoundings * kEpsilon * (size(from) + size(share * along));
        const auto low = static_cast<double>(at - error), high = static_cast<double>(at + error);
        return low == high ? std::optional(low) : std::nullopt;
    };
    const auto x = coordinate(a.x, ux, c.x, vx), y = coordinate(a.y, uy, c.y, vy);
    if (!x || !y) return std::nullopt;
    return Point{*x, *y};
}

/// Returns the crossing of two segments, computed exactly and rounded.
Point exact_crossing(Point a, Point b, Point c, Point d) {
    const Exact ux = Exact(b.x) - a.x, uy = Exact(b.y) - a.y, vx = Exact(d.x) - c.x, vy = Exact(d.y) - c.y;
    const Exact share = ((Exact(c.x) - a.x) * vy - (Exact(c.y) - a.y) * vx) / (ux * vy - uy * vx);
    return {static_cast<double>(Exact(a.x + share * ux)), static_cast<double>(Exact(a.y + share * uy))};
}

/// Returns the crossing of two segments, rounded to a point within the bounding boxes of both.
Point crossing(Point a, Point b, Point c, Point d) {
    const auto quick = quick_crossing(a, b, c, d);
    const Point position = quick ? *quick : exact_crossing(a, b, c, d);
    return {position.x < kMinCoordinate ? 0 : position.x, position.y < kMinCoordinate ? 0 : position.y};
}

double distance_to_line(Point p, Point a, Point b) {
    return std::abs(cross(b - a, p - a)) / std::sqrt(dot(b - a, b - a));
}

/// Number of segments above which inserting them one after the other may take too long.
constexpr std::size_t kVeryMany = 100'000;

/// Returns the order in which to insert segments. The time to insert a segment grows with the number of triangles that
/// it crosses. A segment crosses no triangle beyond a neighbouring segment that is already inserted. So if there are
/// very many segments, they are inserted in the order of their numbers with reversed bits, which separates neighbours
/// along a chain. In another order, the segments of n needles beside each other can take O(n^2).
///
/// Source: Shewchuk and Brown, Fast segment insertion and incremental construction of constrained Delaunay
/// triangulations, Computational Geometry 48 (2015). Departure: the order is not random.
std::vector<std::uint32_t> insertion_order(std::size_t segments) {
    std::vector<std::uint32_t> order(segments);
    std::iota(order.begin(), order.end(), 0U);
    const auto reversed = [](std::uint32_t bits) {
        for (const auto& [shift, mask] :
             {std::pair(1, 0x55555555U), {2, 0x33333333U}, {4, 0x0F0F0F0FU}, {8, 0x00FF00FFU}, {16, 0x0000FFFFU}})
            bits = (bits >> shift & mask) | (bits & mask) << shift;
        return bits;
    };
    if (segments > kVeryMany) std::ranges::sort(order, {}, reversed);
    return order;
}

/// Finds the first vertex or constrained edge that a segment meets after its beginning. Precondition: no edge at
/// `from` runs along the segment.
std::pair<Vertex, Triangulation::Edge> look_along(const Triangulation& triangulation, Vertex from, Vertex to) {
    const auto side = [&](Vertex v) { return triangulation.orientation(from->point(), to->point(), v->point()); };
    auto face = triangulation.incident_faces(from);
    while (triangulation.is_infinite(face) ||
           side(face->vertex(Triangulation::ccw(face->index(from)))) != CGAL::RIGHT_TURN ||
           side(face->vertex(Triangulation::cw(face->index(from)))) != CGAL::LEFT_TURN) {
        ++face;
    }
    Triangulation::Edge ahead{face, face->index(from)};
    while (true) {
        if (ahead.first->is_constrained(ahead.second)) return {nullptr, ahead};
        const auto [left, right] = std::pair(ahead.first->vertex(Triangulation::cw(ahead.second)),
                                             ahead.first->vertex(Triangulation::ccw(ahead.second)));
        const Face next = ahead.first->neighbor(ahead.second);
        const Vertex apex = next->vertex(3 - next->index(left) - next->index(right));
        const auto turn = apex == to ? CGAL::COLLINEAR : side(apex);
        if (turn == CGAL::COLLINEAR) return {apex, {}};
        ahead = {next, next->index(turn == CGAL::LEFT_TURN ? left : right)};
    }
}

/// Returns the first vertex that a segment meets after its beginning; null if it crosses a constrained edge before.
Vertex first_vertex_along(const Triangulation& triangulation, Vertex from, Vertex to) {
    Vertex end;
    Face face;
    int i = 0;
    if (triangulation.includes_edge(from, to, end, face, i)) return end;
    return look_along(triangulation, from, to).first;
}

using DelaunayBase = Triangulation;  // within a derived class, CGAL gives the name Triangulation another meaning

/// A triangulation that may lose the Delaunay property where segments are inserted. The flips that would restore the
/// property take up to O(n^2) for a segment that crosses n triangles.
class LooseTriangulation : public Triangulation {
public:
    explicit LooseTriangulation(bool is_delaunay) : is_delaunay_(is_delaunay) {}

private:
    void triangulate_hole(List_faces& crossed, List_edges& left, List_edges& right) override {
        if (is_delaunay_) return DelaunayBase::triangulate_hole(crossed, left, right);
        List_edges added;
        Ctr::triangulate_hole(crossed, left, right, added);
    }

    const bool is_delaunay_;
};

/// Inserts the segments of chains. Cuts segments and edges where they cross.
class Arranger {
public:
    Arranger(const Chains& chains, double tolerance, std::size_t most)
        : chains_(chains), tolerance_(tolerance), left_(most), triangulation_(chains.points.size() <= kVeryMany) {
        result_.points = with_box(chains.points);
    }

    /// @returns  the error if there are too many crossings; none on success or after a stop
    std::optional<TooManyCrossings> insert_all(const std::stop_token& stop) {
        vertices_ = insert_points(triangulation_, result_.points, stop);
        if (vertices_.empty()) return std::nullopt;
        result_.vertex_of = numbers_of(vertices_, chains_.points.size());
        for (const std::uint32_t i : insertion_order(chains_.points.size())) {
            pending_.push_back({vertices_[i], vertices_[chains_.next[i]], i, {chains_.group[i]}});
            while (!pending_.empty()) {
                if (++steps_ % kStopStride == 0 && stop.stop_requested()) return std::nullopt;
                Piece piece = std::move(pending_.back());
                pending_.pop_back();
                if (auto error = insert(std::move(piece))) return error;
            }
        }
        return std::nullopt;
    }

    Arrangement finish() {
        for (std::uint32_t g = 0; g <= chains_.groups; ++g) result_.begins.push_back(g);
        for (std::uint32_t g = 0; g < chains_.groups; ++g) result_.members.push_back(g);
        result_.triangles = copy_faces<Arrangement::Triangle>(
            triangulation_, [this](Face face, int i, Arrangement::Triangle& copy, std::size_t edge) {
                copy.sets[edge] = face->is_constrained(i) ? number_of_set(ends_of(face, i)) : kNone;
            });
        return std::move(result_);
    }

private:
    static constexpr std::uint32_t kNone = Arrangement::kNone;
    using Ends = std::pair<Vertex, Vertex>;
    using Groups = std::vector<std::uint32_t>;

    /// A part of one segment, or of several segments along the same edge.
    struct Piece {
        Vertex from;
        Vertex to;
        std::uint32_t segment;  ///< kNone if the piece was inserted before; its meetings are then not reported again
        Groups groups;
    };
    struct Edge {
        Groups groups;
        std::uint32_t set = kNone;  ///< number of its set of groups, once assigned
    };

    static Ends ends_of(Face face, int i) {
        return {face->vertex(Triangulation::cw(i)), face->vertex(Triangulation::ccw(i))};
    }
    static std::uint64_t key(const Ends& ends) {
        const auto [less, more] = std::minmax(ends.first->info(), ends.second->info());
        return std::uint64_t{less} << 32 | more;
    }
    Point position(Vertex vertex) const { return result_.points[vertex->info()]; }

    /// Returns the segment between two vertices in either direction, given by its first point; kNone if there is none.
    std::uint32_t segment_along(const Ends& ends) const {
        const auto runs = [&](Vertex from, Vertex to) {
            const std::uint32_t point = from->info();
            return point < chains_.points.size() && vertices_[chains_.next[point]] == to;
        };
        const auto [less, more] = ends.first->info() < ends.second->info() ? ends : Ends{ends.second, ends.first};
        return runs(less, more) ? less->info() : runs(more, less) ? more->info() : kNone;
    }

    /// Returns the groups along an edge, stored in `edges_`. Creates the entry if there is none; an edge that is one
    /// whole segment has no entry at first.
    Groups& groups_along(const Ends& ends, bool is_constrained) {
        const auto [found, is_new] = edges_.try_emplace(key(ends));
        Groups& groups = found->second.groups;
        if (is_new && is_constrained) groups.push_back(chains_.group[segment_along(ends)]);
        return groups;
    }

    std::uint32_t number_of_set(const Ends& ends) {
        const auto found = edges_.find(key(ends));
        if (found == edges_.end()) return chains_.group[segment_along(ends)];
        auto& [groups, set] = found->second;
        if (groups.size() == 1) return groups.front();
        if (set == kNone) {
            set = static_cast<std::uint32_t>(result_.begins.size() - 1);
            result_.members.insert(result_.members.end(), groups.begin(), groups.end());
            result_.begins.push_back(static_cast<std::uint32_t>(result_.members.size()));
        }
        return set;
    }

    std::optional<TooManyCrossings> insert(Piece piece) {
        while (piece.from != piece.to) {
            Vertex end;
            Face face;
            int i = 0;
            bool is_constrained = false;
            if (triangulation_.includes_edge(piece.from, piece.to, end, face, i)) {
                is_constrained = face->is_constrained(i);
            } else {
                const auto [vertex, edge] = look_along(triangulation_, piece.from, piece.to);
                if (vertex == nullptr) return cross(std::move(piece), edge);
                end = vertex;
            }
            if (!is_constrained) triangulation_.insert_constraint(piece.from, end);
            lay(piece, {piece.from, end}, is_constrained);
            if (end != piece.to) meet(Kind::Touch, piece, end->info(), kNone, position(end));
            piece.from = end;
        }
        return std::nullopt;
    }

    /// Adds the groups of a piece to the groups along an edge. A group that already runs along the edge is removed
    /// instead, since by the even-odd rule two copies cancel out.
    void lay(const Piece& piece, const Ends& ends, bool was_constrained) {
        const bool is_whole = !was_constrained && piece.segment != kNone && piece.segment == segment_along(ends);
        if (is_whole && (edges_.empty() || !edges_.contains(key(ends)))) return;
        Groups& groups = groups_along(ends, was_constrained);
        const Point a = position(ends.first), along = position(ends.second) - a;
        const bool is_told = !groups.empty() && dot(along, along) > tolerance_ * tolerance_;
        if (is_told) meet_edge(Kind::Overlap, piece, groups, a + 0.5 * along);
        for (const std::uint32_t group : piece.groups) {
            const auto at = std::lower_bound(groups.begin(), groups.end(), group);
            if (at != groups.end() && *at == group) {
                groups.erase(at);
            } else {
                groups.insert(at, group);
            }
        }
    }

    /// Cuts a piece and an edge at their crossing.
    std::optional<TooManyCrossings> cross(Piece piece, const Triangulation::Edge& edge) {
        const Ends ends = ends_of(edge.first, edge.second);
        const Groups groups = std::exchange(groups_along(ends, true), {});
        if (groups.empty()) {
            triangulation_.remove_constrained_edge(edge.first, edge.second);
            pending_.push_back(std::move(piece));
            return std::nullopt;
        }
        const Point at =
            crossing(position(piece.from), position(piece.to), position(ends.first), position(ends.second));
        tell_crossing(piece, ends, groups, at);
        const std::size_t made = 2 * (piece.groups.size() + groups.size());
        if (made > left_) return TooManyCrossings{piece.segment == kNone ? 0 : piece.segment, at};
        left_ -= made;
        triangulation_.remove_constrained_edge(edge.first, edge.second);
        const Vertex middle = vertex_at(at, ends.first->face());
        pending_.push_back({middle, piece.to, piece.segment, piece.groups});
        pending_.push_back({piece.from, middle, piece.segment, std::move(piece.groups)});
        pending_.push_back({middle, ends.second, kNone, groups});
        pending_.push_back({ends.first, middle, kNone, groups});
        return std::nullopt;
    }

    /// Returns the vertex at a position; inserts one if needed. Because of rounding, several lines through one point
    /// cross at several positions close together. All of these crossings share the first vertex.
    Vertex vertex_at(Point at, Face nearby) {
        Triangulation::Locate_type where{};
        int i = 0;
        const Face face = triangulation_.locate(to_cgal(at), where, i, nearby);
        if (where == Triangulation::VERTEX) return face->vertex(i);
        for (int corner = 0; corner < 3; ++corner) {
            for (const Vertex vertex : {face->vertex(corner), triangulation_.mirror_vertex(face, corner)}) {
                if (triangulation_.is_infinite(vertex)) continue;  // beyond the side of the box
                const Point away = position(vertex) - at;
                if (dot(away, away) <= tolerance_ * tolerance_ / 16) return vertex;
            }
        }
        const bool on_constrained = where == Triangulation::EDGE && face->is_constrained(i);
        const Ends ends = on_constrained ? ends_of(face, i) : Ends{};
        const Vertex vertex = triangulation_.insert(to_cgal(at), where, face, i);
        vertex->info() = static_cast<std::uint32_t>(result_.points.size());
        result_.points.push_back(at);
        if (on_constrained) {
            const Groups groups = std::exchange(groups_along(ends, true), {});
            edges_[key({ends.first, vertex})].groups = groups;
            edges_[key({vertex, ends.second})].groups = groups;
        }
        return vertex;
    }

    void tell_crossing(const Piece& piece, const Ends& ends, const Groups& groups, Point at) {
        const Point a = position(piece.from), b = position(piece.to), c = position(ends.first),
                    d = position(ends.second);
        for (const Vertex end : {ends.first, ends.second}) {
            if (distance_to_line(position(end), a, b) <= tolerance_) {
                return meet(Kind::Touch, piece, end->info(), kNone, position(end));
            }
        }
        const bool ends_there = std::min(distance_to_line(a, c, d), distance_to_line(b, c, d)) <= tolerance_;
        meet_edge(ends_there ? Kind::Touch : Kind::Cross, piece, groups, at);
    }

    void meet_edge(Kind kind, const Piece& piece, const Groups& groups, Point at) {
        if (piece.segment == kNone) return;
        const bool is_own = std::ranges::binary_search(groups, chains_.group[piece.segment]);
        meet(kind, piece, kNone, is_own ? chains_.group[piece.segment] : groups.front(), at);
    }

    void meet(Kind kind, const Piece& piece, std::uint32_t vertex, std::uint32_t group, Point at) {
        if (piece.segment != kNone) result_.meetings.push_back({kind, piece.segment, vertex, group, at});
    }

    const Chains& chains_;
    const double tolerance_;
    std::size_t left_;  ///< pieces that may still be created
    std::size_t steps_ = 0;
    LooseTriangulation triangulation_;
    std::vector<Vertex> vertices_;  ///< [points] vertex of each point
    std::unordered_map<std::uint64_t, Edge> edges_;
    std::vector<Piece> pending_;
    Arrangement result_;
};

}  // namespace

tl::expected<ConstrainedDelaunay, SegmentConflict> constrained_delaunay(std::span<const Point> points,
                                                                        std::span<const Segment> segments,
                                                                        const std::stop_token& stop) {
    ConstrainedDelaunay result;
    result.points = with_box(points);
    Triangulation triangulation;
    const auto vertices = insert_points(triangulation, result.points, stop);
    if (vertices.empty()) return result;
    for (const std::size_t i : insertion_order(segments.size())) {
        if (i % kStopStride == 0 && stop.stop_requested()) return result;
        const auto a = vertices[segments[i][0]];
        const auto b = vertices[segments[i][1]];
        if (a == b) return tl::unexpected(SegmentConflict{i});
        if (first_vertex_along(triangulation, a, b) != b) return tl::unexpected(SegmentConflict{i});
        triangulation.insert_constraint(a, b);
    }
    result.vertex_of = numbers_of(vertices, points.size());
    result.branches = find_branches(result.vertex_of, segments);
    result.triangles = copy_faces<ConstrainedDelaunay::Triangle>(
        triangulation, [](Face face, int i, ConstrainedDelaunay::Triangle& copy, std::size_t edge) {
            copy.constrained[edge] = face->is_constrained(i);
        });
    return result;
}

tl::expected<Arrangement, TooManyCrossings> arrange(const Chains& chains, double tolerance, std::size_t most,
                                                    const std::stop_token& stop) {
    Arranger arranger(chains, tolerance, most);
    if (auto error = arranger.insert_all(stop)) return tl::unexpected(*error);
    if (stop.stop_requested()) return Arrangement{};
    return arranger.finish();
}

int exact_orientation(Point a, Point b, Point c) {
    return static_cast<int>(CGAL::orientation(to_cgal(a), to_cgal(b), to_cgal(c)));
}

double exact_ordinate(Point a, Point b, double x) {
    constexpr int kRoundings = 8;
    const Wide rise = (Wide{b.y} - a.y) * (Wide{x} - a.x) / (Wide{b.x} - a.x), y = a.y + rise;
    const Wide error = kRoundings * kEpsilon * (size(a.y) + size(rise));
    const auto low = static_cast<double>(y - error), high = static_cast<double>(y + error);
    if (low == high) return low;
    const Exact share = (Exact(x) - a.x) / (Exact(b.x) - a.x);
    return static_cast<double>(Exact(a.y + share * (Exact(b.y) - a.y)));
}

int exact_in_circle(Point a, Point b, Point c, Point d) {
    return static_cast<int>(CGAL::side_of_oriented_circle(to_cgal(a), to_cgal(b), to_cgal(c), to_cgal(d)));
}

}  // namespace ccdt
