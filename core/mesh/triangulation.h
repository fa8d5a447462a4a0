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
#include "core/parallel/team.h"

namespace ccdt {

/// Whole periods of a torus.
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

/// A triangulation of a domain in flat arrays, kept alive by insertions, moves and flips.
///
/// Half-edge h is edge h % 4 (0, 1 or 2) of triangle h / 4, whose edges run counter-clockwise. Vertices [0, sites) are
/// sites, the rest lie on the border. While it is built, triangles outside the domain are part of it; trim() drops
/// them, and from then on an edge of the border is one without a twin.
///
/// On a torus every edge knows by how many periods its far end is shifted against the place that is stored for that
/// vertex, so that vertices may leave the box and however few of them, even one, have a triangulation. All places are
/// multiples of 2^-50, which makes shifted ones exact.
class Triangulation {
public:
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};

    /// @param sites   how many will be inserted; they are numbered first, the points of the border after them
    /// @param border  triangulation of the border's vertices, its segments the border itself, the inside on their left.
    ///                Where several vertices are in one place, each fan of triangles inside has one of its own.
    Triangulation(std::size_t sites, const ConstrainedDelaunay& border);

    /// Starts the triangulation of a torus.
    /// @param period  its sides, multiples of 2^-50, at most 1
    Triangulation(std::size_t sites, Point period);

    /// Has a team do what takes long, and what others do with the triangulation; it must outlive this.
    void set_team(Team& team) { team_ = &team; }
    Team& team() const { return *team_; }

    bool is_torus() const { return period_.x > 0; }
    Point period() const { return period_; }

    std::size_t site_count() const { return sites_; }
    std::size_t vertex_count() const { return points_.size(); }
    std::size_t triangle_count() const { return triangles_.size(); }

    Point point(std::uint32_t vertex) const { return points_[vertex]; }
    std::vector<Point>& points() { return points_; }
    const std::vector<Point>& points() const { return points_; }
    bool is_site(std::uint32_t vertex) const { return vertex < sites_; }

    /// Of the sites the first so many are free to move; all, unless the last ones are fixed.
    std::size_t free_count() const { return free_; }
    bool is_free(std::uint32_t vertex) const { return vertex < free_; }
    void fix_last(std::size_t count);
    /// The free sites in blocks, which steps on the triangulation may work on at the same time.
    const SiteBlocks& blocks() const { return blocks_; }

    static std::uint32_t edge(std::uint32_t triangle, std::uint32_t number) { return 4 * triangle + number; }
    static std::uint32_t triangle_of(std::uint32_t edge) { return edge / 4; }
    static std::uint32_t number_of(std::uint32_t edge) { return edge % 4; }
    static std::uint32_t next(std::uint32_t edge) { return edge % 4 == 2 ? edge - 2 : edge + 1; }
    static std::uint32_t previous(std::uint32_t edge) { return edge % 4 == 0 ? edge + 2 : edge - 1; }

    std::uint32_t origin(std::uint32_t edge) const { return triangles_[edge / 4].corners[edge % 4]; }
    std::uint32_t target(std::uint32_t edge) const { return origin(next(edge)); }
    std::uint32_t twin(std::uint32_t edge) const { return triangles_[edge / 4].twins[edge % 4]; }

    /// Tells whether a corner of the triangle is shifted against the others; on a torus only.
    bool crosses_seam(std::uint32_t triangle) const { return (triangles_[triangle].flags & kSeam) != 0; }

    /// Periods by which the edge's far end is shifted if its near end is not.
    Shift shift(std::uint32_t edge) const { return triangles_[edge / 4].shifts[edge % 4]; }

    /// Periods by which the edge's near end is shifted if the triangle's first corner is not.
    Shift lift(std::uint32_t edge) const {
        const auto& shifts = triangles_[edge / 4].shifts;
        return edge % 4 == 0 ? Shift{} : edge % 4 == 1 ? shifts[0] : Shift{} - shifts[2];
    }

    /// Length of so many periods.
    Point distance(Shift shift) const { return {shift.x * period_.x, shift.y * period_.y}; }

    /// Vector from the edge's near end to its far end.
    Point along(std::uint32_t edge) const {
        return points_[target(edge)] + distance(shift(edge)) - points_[origin(edge)];
    }

    /// The corners' places, the first one where it is stored.
    std::array<Point, 3> places(std::uint32_t triangle) const {
        const Triangle& t = triangles_[triangle];
        const auto& c = t.corners;
        if ((t.flags & kSeam) == 0) return {points_[c[0]], points_[c[1]], points_[c[2]]};
        return {points_[c[0]], points_[c[1]] + distance(t.shifts[0]), points_[c[2]] - distance(t.shifts[2])};
    }

    /// A half-edge that leaves the vertex; on the border the one that has the domain on its left and the border on
    /// its right, so that turning counter-clockwise meets all others. Valid after trim().
    std::uint32_t edge_of(std::uint32_t vertex) const { return edge_of_[vertex]; }

    std::array<std::uint32_t, 3> corners(std::uint32_t triangle) const {
        const auto& c = triangles_[triangle].corners;
        return {c[0], c[1], c[2]};
    }

    /// Twice the area, > 0 always.
    double doubled_area(std::uint32_t triangle) const {
        const auto [a, b, c] = places(triangle);
        return cross(b - a, c - a);
    }

    /// Inserts a site and restores the constrained Delaunay property around it.
    /// Sites are best inserted near the one inserted last.
    /// @param margin  least distance from the edges of the border
    /// @param p       on a torus, rounded to what is exact there
    /// @returns  false, and nothing changes, where `p` is not strictly inside the domain, too close to its border, or
    ///           coincides with a vertex
    bool insert(std::uint32_t site, Point p, double margin = 0);

    /// A place for a site, the one to try so many attempts after the first. Called by several at the same time.
    using Draw = std::function<Point(std::uint32_t site, int attempt)>;

    /// Inserts sites where insert() finds the first of several places good.
    /// @param sites     in ascending order; those numbered in between, about evenly, are inserted already or later
    /// @param attempts  places to try for each
    /// @param stop      asked now and then; leaves a triangulation of no use
    /// @returns         those for which no place was good, which must be inserted before trim()
    std::vector<std::uint32_t> insert_all(std::span<const std::uint32_t> sites, const Draw& draw, int attempts,
                                          double margin, const std::stop_token& stop = {});

    /// Connected parts of the domain.
    std::size_t part_count() const { return part_count_; }
    /// Part that a vertex lies in; kNone for a place outside, of which there are four until trim().
    std::uint32_t part_of(std::uint32_t vertex) const { return part_of_.empty() ? 0 : part_of_[vertex]; }
    /// Part that a place lies in; kNone outside the domain. Not for tori, nor after trim().
    std::uint32_t part_at(Point p);

    /// Corners of the triangles inside the domain, or inside one part of it; before trim().
    std::vector<std::array<Point, 3>> inside_triangles(std::uint32_t part = kNone) const;

    /// Drops what lies outside the domain and renumbers the triangles in the order of the sites, all of which must
    /// have been inserted.
    void trim();

    /// Stores sites of a torus that have left the box, by a quarter of a period or more, where they are within it.
    void wrap();

    /// Flips edges until all but those on the border are locally Delaunay, by exact predicates.
    /// Needs every triangle counter-clockwise.
    /// @param stop  asked now and then; leaves the triangulation sound, but not Delaunay everywhere
    /// @returns     the number of flips
    std::size_t restore_delaunay(const std::stop_token& stop = {});

    /// Takes a site away from where it stands and inserts it in a triangle elsewhere; restores the Delaunay property
    /// around both places, as far as it was there. Not on a torus; after trim().
    /// @param p         strictly inside the triangle
    /// @returns         false, and the site stays, where its neighbours lie so that no edge can be turned away from it
    bool relocate(std::uint32_t site, std::uint32_t triangle, Point p);

    /// Tells whether the last restore_delaunay() has changed anything around the vertex.
    bool has_changed(std::uint32_t vertex) const { return changed_[vertex] != 0; }

private:
    // Edge i of a triangle is constrained: 1 << i.
    static constexpr std::uint8_t kConstrained = 7;  ///< while it is built
    static constexpr std::uint8_t kOutside = 8;      ///< the domain; while it is built
    static constexpr std::uint8_t kSeam = 16;        ///< some shift is not zero

    struct Triangle {
        std::array<std::uint32_t, 3> corners{};
        std::array<std::uint32_t, 3> twins{kNone, kNone, kNone};
        std::array<Shift, 3> shifts{};  ///< of the edges
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

    /// A triangle, and a point as seen from its first corner's place.
    struct Location {
        std::uint32_t triangle;
        Point point;
        Shift shift;  ///< of the point against where it was given
    };

    /// A site to be inserted.
    struct Pending {
        std::uint32_t number = 0;        ///< in a batch
        std::uint32_t triangle = kNone;  ///< where a walk to it has left a region
    };

    /// What one task may change: the triangles all of whose vertices lie in a block.
    struct Region {
        std::uint32_t first = 0;           ///< of the block's vertices
        std::uint32_t size = kNone;        ///< how many these are; the last level's block has all
        std::uint32_t last = kNone;        ///< one of its triangles, near the last insertion
        std::vector<std::uint32_t> stack;  ///< edges that may want a flip
        std::vector<std::uint32_t> edges;  ///< those that do if a larger region finds so
        std::vector<Pending> sites;        ///< to be inserted; then those that a larger region is to insert
        std::size_t flips = 0;

        bool has(std::uint32_t vertex) const { return vertex - first < size; }
        bool is_whole() const { return size == kNone; }
    };
    struct Regions {
        int first_level = 0;
        std::vector<std::vector<Region>> levels;  ///< [levels][blocks], from the first level to the last

        Region& of(SiteBlocks::Block block);
    };
    /// An edge that wants to be flipped, and the block of the four vertices around.
    struct Flip {
        std::uint32_t edge;
        SiteBlocks::Block block;
    };
    enum class Insertion { Done, Refused, Elsewhere };
    struct Batch;

    void make_room(std::size_t border);
    /// The first triangle of those that were there before the first site.
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
    std::vector<Triangle> triangles_;     ///< two for each site, near it in the plane, then the border's
    std::vector<std::uint32_t> part_of_;  ///< [vertices]; after trim() none if there is one part
    std::size_t part_count_ = 0;
    std::vector<std::uint32_t> edge_of_;  ///< [vertices]
    std::vector<std::uint8_t> changed_;   ///< [vertices]
    SiteBlocks blocks_;                   ///< of the free sites
    Region whole_;
    Team* team_ = &alone();
};

}  // namespace ccdt
