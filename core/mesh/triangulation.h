// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/executor.h"
#include "core/geometry/delaunay.h"
#include "core/geometry/point.h"
#include "core/mesh/half_edges.h"
#include "core/mesh/site_blocks.h"

namespace ccdt {

/// A translation on a torus: the numbers of whole periods along x and along y.
struct Shift {
    std::int8_t x = 0;
    std::int8_t y = 0;

    friend bool operator==(Shift, Shift) = default;
    friend Shift operator+(Shift a, Shift b) {
        return {static_cast<std::int8_t>(a.x + b.x), static_cast<std::int8_t>(a.y + b.y)};
    }
    friend Shift operator-(Shift a, Shift b) {
        return {static_cast<std::int8_t>(a.x - b.x), static_cast<std::int8_t>(a.y - b.y)};
    }
};

/// A triangle of a Triangulation, which can lie outside the domain during the construction. trim() clears the
/// constraints.
struct PlaneTriangle : LinkedTriangle {
    std::array<Shift, 3> shifts{};  ///< shifts along the edges

    static constexpr std::uint8_t kOutside = 8;  ///< flag: outside the domain; never set after trim()
    static constexpr std::uint8_t kSeam = 16;    ///< flag: some shift is not zero

    bool is_inside() const { return (flags & kOutside) == 0; }
    void set_shifts(Shift first, Shift second, Shift third) {
        shifts = {first, second, third};
        const bool seam = shifts != std::array<Shift, 3>{};
        flags = static_cast<std::uint8_t>((flags & ~kSeam) | (seam ? kSeam : 0));
    }
};

/// A triangulation of a domain in flat arrays. This class stores and navigates the mesh, and changes single triangles.
/// The other files of this folder insert sites (insertion.h), make the mesh Delaunay (flips.h), move sites to distant
/// triangles (relocation.h), and determine what lies inside the domain (inside.h).
///
/// Vertices [0, sites) are sites, the others lie on the border. During construction, triangles outside the domain are
/// part of the mesh. trim() drops these triangles; afterwards an edge of the border has no twin, and edge_of() is
/// valid.
///
/// On a torus every edge stores by how many periods its target is shifted from the stored position of the target
/// vertex. So vertices may leave the box, and even a single vertex has a triangulation. All positions are multiples of
/// 2^-50, so shifted positions are exact.
class Triangulation : public HalfEdges<PlaneTriangle> {
public:
    using Triangle = PlaneTriangle;

    /// Copies the triangulation of a border. For the mesh of a domain, use mesh_of_border(), which marks the inside.
    /// @param sites  number of sites to be inserted, which are numbered before the points of the border
    Triangulation(std::size_t sites, const ConstrainedDelaunay& border);

    /// Creates the triangulation of a torus, without any site so far.
    /// @param sites   number of sites to be inserted
    /// @param period  sides of the torus, multiples of 2^-50, at most 1
    Triangulation(std::size_t sites, Point period);

    /// Sets the executor for lengthy operations on this triangulation, also in other classes. It must outlive this.
    void set_executor(Executor& executor) { executor_ = &executor; }
    Executor& executor() const { return *executor_; }

    bool is_torus() const { return period_.x > 0; }
    Point period() const { return period_; }

    std::size_t site_count() const { return sites_; }
    std::size_t vertex_count() const { return points_.size(); }

    Point point(std::uint32_t vertex) const { return points_[vertex]; }
    std::vector<Point>& points() { return points_; }
    const std::vector<Point>& points() const { return points_; }
    bool is_site(std::uint32_t vertex) const { return vertex < sites_; }

    /// Returns the number of sites that may move: the first ones. All sites may move unless fix_last() was called.
    std::size_t free_count() const { return free_; }
    bool is_free(std::uint32_t vertex) const { return vertex < free_; }
    /// Declares that the last `count` sites never move.
    void fix_last(std::size_t count);
    /// Blocks of the free sites, which can be processed in parallel.
    const SiteBlocks& blocks() const { return blocks_; }

    /// Whether a corner of the triangle is shifted by periods relative to the others, which is possible only on a
    /// torus.
    bool crosses_seam(std::uint32_t triangle) const { return (triangles_[triangle].flags & Triangle::kSeam) != 0; }

    /// Returns the periods by which the edge's target is shifted relative to its origin.
    Shift shift(std::uint32_t edge) const { return triangles_[edge / 4].shifts[edge % 4]; }

    /// Returns the periods by which the edge's origin is shifted relative to the triangle's first corner.
    Shift lift(std::uint32_t edge) const {
        const auto& shifts = triangles_[edge / 4].shifts;
        return edge % 4 == 0 ? Shift{} : edge % 4 == 1 ? shifts[0] : Shift{} - shifts[2];
    }

    /// Returns the vector that a shift stands for.
    Point distance(Shift shift) const { return {shift.x * period_.x, shift.y * period_.y}; }

    /// Returns the vector from the edge's origin to its target.
    Point along(std::uint32_t edge) const {
        return points_[target(edge)] + distance(shift(edge)) - points_[origin(edge)];
    }

    /// Returns the vector perpendicular to the edge, of the same length, that points into the edge's triangle.
    Point inward(std::uint32_t edge) const {
        const Point a = along(edge);
        return {-a.y, a.x};
    }

    /// Returns the positions of the corners. The first corner has its stored position; the others are shifted by
    /// periods to be next to it.
    std::array<Point, 3> positions(std::uint32_t triangle) const {
        const Triangle& t = triangles_[triangle];
        const auto& c = t.corners;
        if ((t.flags & Triangle::kSeam) == 0) return {points_[c[0]], points_[c[1]], points_[c[2]]};
        return {points_[c[0]], points_[c[1]] + distance(t.shifts[0]), points_[c[2]] - distance(t.shifts[2])};
    }

    /// Returns twice the area; always > 0.
    double doubled_area(std::uint32_t triangle) const {
        const auto [a, b, c] = positions(triangle);
        return cross(b - a, c - a);
    }

    /// Returns the number of connected parts of the domain.
    std::size_t part_count() const { return part_count_; }
    /// Returns the part in which a vertex lies; kNone outside the domain, where the four corners of the box lie until
    /// trim().
    std::uint32_t part_of(std::uint32_t vertex) const { return part_of_.empty() ? 0 : part_of_[vertex]; }

    /// Moves sites of a torus back into the box if they have left it by a quarter of a period or more.
    void wrap();

    /// Whether the last restore_delaunay() changed a triangle around the vertex.
    bool has_changed(std::uint32_t vertex) const { return changed_[vertex] != 0; }

    // The following members are for the algorithms of this folder.

    /// Returns the first triangle of the border. The triangles of the sites come before it: two for each site, near the
    /// site in the plane.
    std::uint32_t border_triangle() const { return static_cast<std::uint32_t>(2 * sites_); }

    /// Splits a triangle into three at a site.
    /// @param shift  shift of the site from its stored position to its position in the triangle
    /// @param u, v   two unused triangles, which become parts of the divided one
    void divide(std::uint32_t site, std::uint32_t triangle, Shift shift, std::uint32_t u, std::uint32_t v);
    /// Replaces the edge a-b of triangles (a, b, c) and (b, a, d) by d-c of (a, d, c) and (b, c, d).
    void flip(std::uint32_t edge);
    /// Sets has_changed() of all vertices to false.
    void forget_changes() { changed_.assign(points_.size(), 0); }

    /// Sets the part of each vertex [vertices], and the number of parts.
    void set_parts(std::vector<std::uint32_t> part_of, std::size_t count);
    void set_part(std::uint32_t vertex, std::uint32_t part) {
        if (!part_of_.empty()) part_of_[vertex] = part;
    }
    /// Ends the construction, after the triangles outside the domain have been dropped.
    void finish();

    /// Returns the triangle at which the next search for a position begins; kNone in an empty torus. Only before
    /// trim().
    std::uint32_t search_start() const { return search_start_; }
    void set_search_start(std::uint32_t triangle) { search_start_ = triangle; }

private:
    void reserve_triangles(std::size_t border);
    void flip_shifts(std::uint32_t edge);

    std::size_t sites_;
    std::size_t free_ = sites_;
    Point period_;  ///< 0 unless a torus
    std::vector<Point> points_;
    std::vector<std::uint32_t> part_of_;  ///< [vertices]; empty after trim() if there is only one part
    std::size_t part_count_ = 0;
    /// [vertices] whether the last restore_delaunay() changed a triangle around the vertex.
    std::vector<std::uint8_t> changed_;
    SiteBlocks blocks_;  ///< blocks of the free sites
    std::uint32_t search_start_ = kNone;
    Executor* executor_ = &inline_executor();
};

}  // namespace ccdt
