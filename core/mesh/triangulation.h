#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/delaunay.h"
#include "core/geometry/point.h"

namespace ccdt {

/// A triangulation of a domain in flat arrays, kept alive by insertions, moves and flips.
///
/// Half-edge h is edge h % 4 (0, 1 or 2) of triangle h / 4, whose edges run counter-clockwise. Vertices [0, sites) are
/// sites, the rest lie on the border. While it is built, triangles outside the domain are part of it; trim() drops
/// them, and from then on an edge of the border is one without a twin.
class Triangulation {
public:
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};

    /// @param sites   how many will be inserted; they are numbered first, the points of the border after them
    /// @param border  triangulation of the border's vertices, its segments the border itself
    Triangulation(std::size_t sites, const ConstrainedDelaunay& border);

    std::size_t site_count() const { return sites_; }
    std::size_t vertex_count() const { return points_.size(); }
    std::size_t triangle_count() const { return triangles_.size(); }

    Point point(std::uint32_t vertex) const { return points_[vertex]; }
    std::vector<Point>& points() { return points_; }
    const std::vector<Point>& points() const { return points_; }
    bool is_site(std::uint32_t vertex) const { return vertex < sites_; }

    static std::uint32_t edge(std::uint32_t triangle, std::uint32_t number) { return 4 * triangle + number; }
    static std::uint32_t triangle_of(std::uint32_t edge) { return edge / 4; }
    static std::uint32_t next(std::uint32_t edge) { return edge % 4 == 2 ? edge - 2 : edge + 1; }
    static std::uint32_t previous(std::uint32_t edge) { return edge % 4 == 0 ? edge + 2 : edge - 1; }

    std::uint32_t origin(std::uint32_t edge) const { return triangles_[edge / 4].corners[edge % 4]; }
    std::uint32_t target(std::uint32_t edge) const { return origin(next(edge)); }
    std::uint32_t twin(std::uint32_t edge) const { return triangles_[edge / 4].twins[edge % 4]; }

    /// A half-edge that leaves the vertex; on the border the one that has the domain on its left and the border on
    /// its right, so that turning counter-clockwise meets all others. Valid after trim().
    std::uint32_t edge_of(std::uint32_t vertex) const { return edge_of_[vertex]; }

    std::array<std::uint32_t, 3> corners(std::uint32_t triangle) const {
        const auto& c = triangles_[triangle].corners;
        return {c[0], c[1], c[2]};
    }

    /// Twice the area, > 0 always.
    double doubled_area(std::uint32_t triangle) const {
        const auto& c = triangles_[triangle].corners;
        return cross(points_[c[1]] - points_[c[0]], points_[c[2]] - points_[c[0]]);
    }

    /// Inserts a site and restores the constrained Delaunay property around it.
    /// Sites are best inserted near the one inserted last.
    /// @param margin  least distance from the edges of the border
    /// @returns  false, and nothing changes, where `p` is not strictly inside the domain, too close to its border, or
    ///           coincides with a vertex
    bool insert(std::uint32_t site, Point p, double margin = 0);

    /// Corners of the triangles inside the domain, before trim().
    std::vector<std::array<Point, 3>> inside_triangles() const;

    /// Drops what lies outside the domain and renumbers the triangles in the order of the sites.
    void trim();

    /// Flips edges until all but those on the border are locally Delaunay, by exact predicates.
    /// Needs every triangle counter-clockwise. @returns the number of flips
    std::size_t restore_delaunay();

    /// Whether the last restore_delaunay() has changed anything around the vertex.
    bool has_changed(std::uint32_t vertex) const { return changed_[vertex] != 0; }

private:
    struct Triangle {
        std::array<std::uint32_t, 3> corners{};
        bool inside = true;                 ///< the domain; while it is built
        std::array<bool, 3> constrained{};  ///< while it is built
        std::array<std::uint32_t, 3> twins{kNone, kNone, kNone};
    };

    std::uint32_t locate(Point p) const;
    std::uint32_t add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
    void join(std::uint32_t edge, std::uint32_t twin);
    bool is_constrained(std::uint32_t edge) const { return triangles_[edge / 4].constrained[edge % 4]; }
    void set_twin(std::uint32_t edge, std::uint32_t twin) { triangles_[edge / 4].twins[edge % 4] = twin; }
    void set_constrained(std::uint32_t edge, bool on) { triangles_[edge / 4].constrained[edge % 4] = on; }
    bool wants_flip(std::uint32_t edge) const;
    bool is_certain(std::uint32_t edge, std::uint32_t other) const;
    void flip(std::uint32_t edge);
    std::size_t legalise();
    void mark_inside();
    void number_along_sites();
    void find_edges();

    std::size_t sites_;
    std::vector<Point> points_;
    std::vector<Triangle> triangles_;
    std::vector<std::uint32_t> edge_of_;  ///< [vertices]
    std::vector<std::uint32_t> stack_;    ///< edges that may want a flip
    std::vector<std::uint32_t> sweep_;    ///< one half-edge of each edge
    std::vector<std::uint8_t> changed_;   ///< [vertices]
    std::uint32_t last_ = 0;              ///< triangle near the last insertion
};

}  // namespace ccdt
