// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/delaunay.h"
#include "core/geometry/point.h"
#include "core/mesh/site_blocks.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// A number of whole periods of a torus in each direction.
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

/// A triangulation of a domain in flat arrays, updated by insertions, moves and flips.
///
/// Half-edge h is edge h % 4 (0, 1 or 2) of triangle h / 4, whose edges run counter-clockwise. Vertices [0, sites) are
/// sites, the others lie on the border. During construction, triangles outside the domain are part of the mesh. trim()
/// drops these triangles; afterwards an edge of the border has no twin.
///
/// On a torus every edge stores by how many periods its target is shifted from the stored position of the target
/// vertex. So vertices may leave the box, and even a single vertex has a triangulation. All positions are multiples of
/// 2^-50, so shifted positions are exact.
class Triangulation {
public:
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};

    /// @param sites   number of sites to be inserted; the sites come first in the numbering, then the points of the
    ///                border
    /// @param border  triangulation of the border's vertices; its segments are the border itself, with the inside on
    ///                their left. At a place with several separate sectors of the inside, each sector has its own
    ///                vertex.
    Triangulation(std::size_t sites, const ConstrainedDelaunay& border);

    /// Starts the triangulation of a torus.
    /// @param period  sides of the torus, multiples of 2^-50, at most 1
    Triangulation(std::size_t sites, Point period);

    /// Sets the executor that lengthy operations on this triangulation use, in this class and in others. The executor
    /// must outlive this.
    void set_executor(Executor& executor) { executor_ = &executor; }
    Executor& executor() const { return *executor_; }

    bool is_torus() const { return period_.x > 0; }
    Point period() const { return period_; }

    std::size_t site_count() const { return sites_; }
    std::size_t vertex_count() const { return points_.size(); }
    std::size_t triangle_count() const { return triangles_.size(); }

    Point point(std::uint32_t vertex) const { return points_[vertex]; }
    std::vector<Point>& points() { return points_; }
    const std::vector<Point>& points() const { return points_; }
    bool is_site(std::uint32_t vertex) const { return vertex < sites_; }

    /// Number of sites that may move: the first ones. All sites may move unless fix_last() was called.
    std::size_t free_count() const { return free_; }
    bool is_free(std::uint32_t vertex) const { return vertex < free_; }
    void fix_last(std::size_t count);
    /// Blocks of the free sites, which can be processed in parallel.
    const SiteBlocks& blocks() const { return blocks_; }

    static std::uint32_t edge(std::uint32_t triangle, std::uint32_t number) { return 4 * triangle + number; }
    static std::uint32_t triangle_of(std::uint32_t edge) { return edge / 4; }
    static std::uint32_t number_of(std::uint32_t edge) { return edge % 4; }
    static std::uint32_t next(std::uint32_t edge) { return edge % 4 == 2 ? edge - 2 : edge + 1; }
    static std::uint32_t previous(std::uint32_t edge) { return edge % 4 == 0 ? edge + 2 : edge - 1; }

    std::uint32_t origin(std::uint32_t edge) const { return triangles_[edge / 4].corners[edge % 4]; }
    std::uint32_t target(std::uint32_t edge) const { return origin(next(edge)); }
    std::uint32_t twin(std::uint32_t edge) const { return triangles_[edge / 4].twins[edge % 4]; }

    /// Whether a corner of the triangle is shifted relative to the others; only on a torus.
    bool crosses_seam(std::uint32_t triangle) const { return (triangles_[triangle].flags & kSeam) != 0; }

    /// Periods by which the edge's target is shifted relative to its origin.
    Shift shift(std::uint32_t edge) const { return triangles_[edge / 4].shifts[edge % 4]; }

    /// Periods by which the edge's origin is shifted relative to the triangle's first corner.
    Shift lift(std::uint32_t edge) const {
        const auto& shifts = triangles_[edge / 4].shifts;
        return edge % 4 == 0 ? Shift{} : edge % 4 == 1 ? shifts[0] : Shift{} - shifts[2];
    }

    /// Vector that a shift stands for.
    Point distance(Shift shift) const { return {shift.x * period_.x, shift.y * period_.y}; }

    /// Vector from the edge's origin to its target.
    Point along(std::uint32_t edge) const {
        return points_[target(edge)] + distance(shift(edge)) - points_[origin(edge)];
    }

    /// Positions of the corners; the first one is at its stored position.
    std::array<Point, 3> places(std::uint32_t triangle) const {
        const Triangle& t = triangles_[triangle];
        const auto& c = t.corners;
        if ((t.flags & kSeam) == 0) return {points_[c[0]], points_[c[1]], points_[c[2]]};
        return {points_[c[0]], points_[c[1]] + distance(t.shifts[0]), points_[c[2]] - distance(t.shifts[2])};
    }

    /// A half-edge that leaves the vertex. For a vertex of the border, it is the half-edge along the border with the
    /// domain on its left, so that turning counter-clockwise visits all others. Valid after trim().
    std::uint32_t edge_of(std::uint32_t vertex) const { return edge_of_[vertex]; }

    std::array<std::uint32_t, 3> corners(std::uint32_t triangle) const {
        const auto& c = triangles_[triangle].corners;
        return {c[0], c[1], c[2]};
    }

    /// Twice the area; always > 0.
    double doubled_area(std::uint32_t triangle) const {
        const auto [a, b, c] = places(triangle);
        return cross(b - a, c - a);
    }

    /// Inserts a site and restores the constrained Delaunay property around the site. Fastest near the previously
    /// inserted site.
    /// @param margin  least distance from the edges of the border
    /// @param p       on a torus, rounded to a multiple of 2^-50
    /// @returns       false, without inserting the site, if `p` is not strictly inside the domain, is too close to its
    ///                border, or coincides with a vertex
    bool insert(std::uint32_t site, Point p, double margin = 0);

    /// Returns the position to try for a site at a given attempt. Called from several threads.
    using Draw = std::function<Point(std::uint32_t site, int attempt)>;

    /// Inserts sites, each at the first of several positions that insert() accepts.
    /// @param sites     in ascending order and evenly spread; other calls insert the sites numbered in between
    /// @param attempts  positions to try for each site
    /// @param stop      polled regularly; after a stop the triangulation must not be used
    /// @returns         the sites for which no position was accepted; they must be inserted before trim()
    std::vector<std::uint32_t> insert_all(std::span<const std::uint32_t> sites, const Draw& draw, int attempts,
                                          double margin, const std::stop_token& stop = {});

    /// Number of connected parts of the domain.
    std::size_t part_count() const { return part_count_; }
    /// Part in which a vertex lies; kNone for a vertex outside the domain. Before trim(), the four corners of the box
    /// are vertices outside.
    std::uint32_t part_of(std::uint32_t vertex) const { return part_of_.empty() ? 0 : part_of_[vertex]; }
    /// Part in which a position lies; kNone outside the domain. Not for a torus, nor after trim().
    std::uint32_t part_at(Point p);

    /// Corners of the triangles inside the domain, or inside one part of it. Only before trim().
    std::vector<std::array<Point, 3>> inside_triangles(std::uint32_t part = kNone) const;

    /// Drops triangles outside the domain and renumbers the others in the order of the sites. All sites must have been
    /// inserted.
    void trim();

    /// Wraps sites of a torus that have left the box by a quarter of a period or more back into it.
    void wrap();

    /// Flips edges until all edges that are not on the border are locally Delaunay, by exact predicates. Every triangle
    /// must be counter-clockwise.
    /// @param stop  polled regularly; a stop leaves a valid triangulation that is not Delaunay everywhere
    /// @returns     the number of flips
    std::size_t restore_delaunay(const std::stop_token& stop = {});

    /// Removes a site and inserts it in another triangle. Wherever the mesh was Delaunay around both positions, it is
    /// Delaunay afterwards. Not for a torus; only after trim().
    /// @param p  strictly inside the triangle
    /// @returns  false, without moving the site, if no edge can be flipped away from the site because of its
    ///           neighbours' positions
    bool relocate(std::uint32_t site, std::uint32_t triangle, Point p);

    /// Whether the last restore_delaunay() changed a triangle around the vertex.
    bool has_changed(std::uint32_t vertex) const { return changed_[vertex] != 0; }

private:
    // Bit 1 << i is set if edge i of the triangle is constrained.
    static constexpr std::uint8_t kConstrained = 7;  ///< during construction
    static constexpr std::uint8_t kOutside = 8;      ///< outside the domain; during construction
    static constexpr std::uint8_t kSeam = 16;        ///< some shift is not zero

    struct Triangle {
        std::array<std::uint32_t, 3> corners{};
        std::array<std::uint32_t, 3> twins{kNone, kNone, kNone};
        std::array<Shift, 3> shifts{};  ///< shifts along the edges
        std::uint8_t flags = 0;

        bool is_inside() const { return (flags & kOutside) == 0; }
        bool is_constrained(std::uint32_t number) const { return (flags >> number & 1) != 0; }
        void set_constrained(std::uint32_t number, bool on) {
            flags = static_cast<std::uint8_t>((flags & ~(1u << number)) | (on ? 1u << number : 0u));
        }
        void set_shifts(Shift first, Shift second, Shift third) {
            shifts = {first, second, third};
            const bool seam = shifts != std::array<Shift, 3>{};
            flags = static_cast<std::uint8_t>((flags & ~kSeam) | (seam ? kSeam : 0));
        }
    };

    /// A triangle, and a point relative to the position of its first corner.
    struct Location {
        std::uint32_t triangle;
        Point point;
        Shift shift;  ///< shift of the point from its given position
    };

    /// A site still to be inserted.
    struct Pending {
        std::uint32_t number = 0;        ///< index in the batch
        std::uint32_t triangle = kNone;  ///< triangle at which the walk to the site left a region
    };

    /// The part of the mesh that one task may change: the triangles with all vertices in one block.
    struct Region {
        std::uint32_t first = 0;     ///< first vertex of the block
        std::uint32_t size = kNone;  ///< number of vertices; kNone for the last level's block, which has all vertices
        std::uint32_t last = kNone;  ///< a triangle of the region, near the last insertion
        std::vector<std::uint32_t> stack;  ///< edges that may need a flip
        std::vector<std::uint32_t> edges;  ///< edges left for a larger region
        std::vector<Pending> sites;        ///< sites to insert; afterwards the sites left for a larger region
        std::size_t flips = 0;

        bool has(std::uint32_t vertex) const { return vertex - first < size; }
        bool is_whole() const { return size == kNone; }
    };
    struct Regions {
        int first_level = 0;
        std::vector<std::vector<Region>> levels;  ///< [levels][blocks], from the first level to the last

        Region& of(SiteBlocks::Block block);
    };
    /// An edge that needs a flip, and the block of the four vertices around it.
    struct Flip {
        std::uint32_t edge;
        SiteBlocks::Block block;
    };
    enum class Insertion { Done, Refused, Elsewhere };
    struct Batch;

    void reserve_triangles(std::size_t border);
    /// First triangle of the border. The triangles of the sites come before it.
    std::uint32_t border_triangle() const { return static_cast<std::uint32_t>(2 * sites_); }
    void insert_first(std::uint32_t site, Point p);
    void divide(std::uint32_t site, const Location& at, std::uint32_t u, std::uint32_t v);
    std::vector<std::uint32_t> edges_around(std::uint32_t site) const;
    bool isolate(std::uint32_t site);
    bool is_within(std::uint32_t triangle, Point p) const;
    bool locate(const Region& region, Location& at) const;
    Location way_from(std::uint32_t triangle, Point p) const;
    Insertion insert(Region& region, std::uint32_t site, Point p, double margin, Pending& pending);
    void insert_in(Region& region, const Batch& batch);
    Regions make_regions(std::size_t sites) const;
    template <class Work>
    Region work_upwards(Regions regions, Work&& work);
    void join(std::uint32_t edge, std::uint32_t twin);
    bool is_constrained(std::uint32_t edge) const { return triangles_[edge / 4].is_constrained(edge % 4); }
    void set_twin(std::uint32_t edge, std::uint32_t twin) { triangles_[edge / 4].twins[edge % 4] = twin; }
    void set_constrained(std::uint32_t edge, bool on) { triangles_[edge / 4].set_constrained(edge % 4, on); }
    void flip_shifts(std::uint32_t edge);
    bool wants_flip(std::uint32_t edge) const;
    bool is_certain(std::uint32_t edge, std::uint32_t other) const;
    void flip(std::uint32_t edge);
    void legalise(Region& region);
    void find_flips(std::size_t begin, std::size_t end, std::vector<Flip>& found) const;
    void keep_edge(std::uint32_t edge);
    void mark_inside();
    void mark_parts();
    void separate(std::span<const ConstrainedDelaunay::Branch> branches);
    void drop_outside();
    void number_along_sites();
    void find_edges();

    std::size_t sites_;
    std::size_t free_ = sites_;
    Point period_;  ///< 0 unless a torus
    std::vector<Point> points_;
    std::vector<Triangle> triangles_;     ///< two for each site, near it in the plane; then the triangles of the border
    std::vector<std::uint32_t> part_of_;  ///< [vertices]; empty after trim() if there is only one part
    std::size_t part_count_ = 0;
    std::vector<std::uint32_t> edge_of_;  ///< [vertices] a half-edge that leaves the vertex
    /// [vertices] whether the last restore_delaunay() changed a triangle around the vertex.
    std::vector<std::uint8_t> changed_;
    SiteBlocks blocks_;  ///< blocks of the free sites
    Region whole_;
    Executor* executor_ = &inline_executor();
};

}  // namespace ccdt
