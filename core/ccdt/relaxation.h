#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/ccdt/capacity_integral.h"
#include "core/ccdt/triangle_goals.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Says where a site may go instead of a place: there, if it may stand there, or somewhere on the way.
using Fence = std::function<Point(std::uint32_t site, Point to)>;

struct RelaxationOptions {
    // Stiffer springs and longer moves gain distance between neighbours and lose tone: benchmarks TorusPattern and
    // PictureTone. Without springs along the border more sites crowd there: benchmark BorderPattern.
    double spring = 0.01;        ///< stiffness of the edges against that of the areas
    double border_spring = 0.1;  ///< further stiffness of edges of the border, which keeps its vertices apart
    double relaxation = 1.2;     ///< length of a move over the one that minimises, in [1, 2)
    double least_height = 1e-9;  ///< that a move leaves a triangle, in the unit frame
    /// Doubled area below which it is looked at whether a triangle is a needle; none: by the mean of all triangles,
    /// which are about as large as each other then.
    std::optional<double> small_area;
    std::optional<double> site_share;  ///< of the capacity, that a site shall have; none: all have as much
    Fence fence;                       ///< of all sites; may be empty
    bool by_two = true;                ///< moves two sites at once if the processor can, which gives the same
};

/// Moves vertices, one at a time, to where the capacities of the triangles around them come closest to their targets:
/// coordinate descent on the sum of (weight * doubled area - target)^2 / share over triangles and of
/// spring * mean weight * share * length^2 over edges, those of the border stiffer. So a fan of k triangles that takes
/// the place of one, each with 1/k of the share, counts as much as that one does.
///
/// Sites move freely, vertices on straight parts of the border along them, corners never. A move is cut short where a
/// triangle would lose more than 90 % of its area, or become a needle: all stay counter-clockwise, for however long.
/// Source: Xu et al. 2011, section 3.2, the 2 x 2 system R^T R X = -R^T S. Departures: targets are given instead of
/// being the mean of the ring; springs; over-relaxation.
class Relaxation {
public:
    /// @param fixed    [vertices - sites] of the border: true for those that never move
    /// @param uniform  all weights are equal, and all targets between three sites
    Relaxation(Triangulation& mesh, std::vector<bool> fixed, bool uniform, const RelaxationOptions& options);

    /// Lists the mesh's edges and takes new goals. To be called before the first pass and after every
    /// restore_delaunay(). O(vertices).
    /// @param stop  asked now and then; no pass must follow
    void prepare(TriangleGoals goals, const std::stop_token& stop = {});

    /// The same before exact passes, the only ones that may follow: these need less of the mesh.
    void prepare_exact(TriangleGoals goals, const std::stop_token& stop = {});

    /// Gives the goals back, and the memory of what was measured. No pass must follow until there are new ones.
    TriangleGoals take_goals();

    /// Moves every vertex so many times. The sites of a block move a few times in turn, while all about them is in the
    /// cache; then those between blocks do as often, and then the border's vertices. O(vertices) a time.
    /// @param stop  asked now and then; leaves vertices as they stand
    void pass(int times = 1, const std::stop_token& stop = {});

    /// Measures what exact passes need: the true capacities, and what edges sweep. O(half-edges), and their length in
    /// cells of the density.
    /// @param stop  asked now and then; no exact pass must follow, then
    void measure(const CapacityIntegral& capacity, const std::stop_token& stop = {});

    /// Moves every vertex, in the order of pass(), to where the true capacities come closest to their targets rather
    /// than those that triangles would have if their mean density went with them: what a moving edge sweeps is the
    /// density along it.
    /// Capacities are carried on to first order, from what was measured before this pass or some passes before.
    ///
    /// Where the density is steep, next to white areas above all, pass() stalls and this one does not. O(vertices).
    /// Source: Gauss and Newton's method; Reynolds' transport theorem.
    void exact_pass(int times = 1, const std::stop_token& stop = {});

    /// Sum that the passes minimise; no pass makes it larger.
    double energy() const;

private:
    struct Term;
    struct NormalEquations;

    /// Sites of one kind, laid out for the fast path. Per site: itself; its neighbours counter-clockwise, the first one
    /// repeated until there are 2 * pairs + 1 of them; unless it is plain, the 2 * pairs triangles between them.
    using Batch = std::vector<std::uint32_t>;

    // Kinds of sites: by the number of neighbours, in pairs, and by whether all goals around are the common one
    // (plain).
    static constexpr std::size_t kFewestPairs = 2, kMostPairs = 4;
    static constexpr std::uint8_t kKinds = 2 * (kMostPairs - kFewestPairs + 1);
    static constexpr std::uint8_t kFanKind = kKinds;  ///< too many neighbours: the general path
    static constexpr std::uint8_t kind_of(bool plain, std::size_t pairs) {
        return static_cast<std::uint8_t>(2 * (pairs - kFewestPairs) + (plain ? 1 : 0));
    }
    static constexpr std::size_t stride(std::uint8_t kind) {
        const std::size_t pairs = kind / 2 + kFewestPairs;
        return 2 + 2 * pairs + (kind % 2 == 1 ? 0 : 2 * pairs);
    }

    /// A vertex and what lies around it, for the general path: neighbours counter-clockwise and the triangle between
    /// each and the next one. The fan of a vertex on the border ends with a neighbour that has no triangle after it.
    struct Fan {
        std::uint32_t vertex;
        std::uint32_t first;  ///< of what lies around it
        std::uint32_t neighbours;
        std::uint32_t triangles;  ///< as many as neighbours, on the border one less
    };

    struct Fans {
        std::vector<Fan> all;
        std::vector<std::uint32_t> vertices;  ///< around one after the other
        std::vector<Point> lifts;
        std::vector<std::uint32_t> triangles;

        void clear();
    };

    using Batches = std::array<Batch, kKinds>;

    /// Sites that one task moves, one after the other: all of their neighbours that move at the same time are among
    /// them.
    struct Group {
        const std::uint32_t* records = nullptr;          ///< of all batches, one after the other
        std::array<std::uint32_t, kKinds + 1> begins{};  ///< of the batches
        std::vector<std::uint32_t> own;                  ///< the records, if they are kept here
        Fans fans;
        std::vector<std::uint32_t> sites;   ///< all of them; not at level 0, where they are most of a block's
        std::vector<std::uint32_t> others;  ///< of the block, which belong to larger ones

        std::span<const std::uint32_t> batch(std::uint8_t kind) const {
            return {records + begins[kind], begins[kind + std::size_t{1}] - begins[kind]};
        }
        void clear();
        void keep(const Batches& batches, std::span<std::uint32_t> room);
    };

    /// Of a triangle (site, from, to) in an exact pass.
    struct ExactTriangle {
        std::uint32_t triangle;
        std::uint32_t vertex;  ///< from
        Point from;            ///< seen from the site
        Point gradient;        ///< of its capacity
    };

    /// Room for what lies around a site in an exact pass, counter-clockwise.
    struct ExactRing {
        std::vector<ExactTriangle> triangles;
        Fans fans;  ///< the site's, where the general path is taken
    };

    /// Neighbours of a vertex on the general path, counter-clockwise; the one after the last is the first.
    struct Ring {
        std::span<const std::uint32_t> vertices;
        const Point* lifts;  ///< how far each is shifted around a torus; null: not at all
    };
    Point place(const Ring& ring, std::size_t i) const;
    Ring ring_of(const Fans& fans, const Fan& fan) const;
    double mean_doubled_area() const;
    Term term(std::uint32_t triangle) const;
    void make_groups();
    void list_sites(const std::stop_token& stop);
    void list_border();
    std::size_t room_of(std::size_t sites) const;
    void list_block(std::size_t number, bool first_time);
    void find_levels(std::size_t number, bool first_time);
    void list_larger(std::size_t level, std::size_t number, bool exact);
    std::uint8_t level_of(std::uint32_t site) const;
    bool add_site(std::uint32_t site, Batches& batches, Fans& fans, std::uint32_t first, std::uint32_t size);
    void add_fan(std::uint32_t vertex, Fans& fans) const;
    template <class Move>
    void for_groups(int times, const std::stop_token& stop, Move&& move);
    void move_group(const Group& group);
    template <bool kPlain, std::size_t kPairs>
    void move_batch(const Group& group);
    template <std::size_t kPairs>
    static bool has_neighbour(const std::uint32_t* record, std::uint32_t site);
    template <bool kPlain, std::size_t kPairs>
    void move_two(const std::array<const std::uint32_t*, 2>& records);
    template <bool kPlain, std::size_t kPairs, class Lanes>
    void move_few(const std::array<const std::uint32_t*, Lanes::kCount>& records);
    NormalEquations equations_of(const Fans& fans, const Fan& fan) const;
    void move_site(const Fans& fans, const Fan& fan);
    void move_group_exactly(std::size_t level, std::size_t number);
    double swept(std::uint32_t edge) const {
        return flows_[Triangulation::triangle_of(edge)].swept[Triangulation::number_of(edge)];
    }
    void move_exactly(std::uint32_t site, ExactRing& ring);
    bool surely_fits(std::uint32_t site, Point by, const ExactRing& ring) const;
    void slide(const Fans& fans, const Fan& fan);
    void move(std::uint32_t vertex, Point by, const Ring& ring, std::size_t triangles);
    Point fenced(std::uint32_t site, Point by) const {
        return options_.fence ? options_.fence(site, mesh_.point(site) + by) - mesh_.point(site) : by;
    }
    Point rounded(Point p) const { return {(p.x + magic_) - magic_, (p.y + magic_) - magic_}; }

    Triangulation& mesh_;
    std::vector<bool> fixed_;
    bool uniform_;
    RelaxationOptions options_;
    double magic_ = 0;         ///< rounds places to what is exact on a torus; else 0
    double small_ = 0;         ///< doubled area below which the fast path leaves a triangle to the general one
    double plain_weight_ = 0;  ///< of the triangles around plain sites
    TriangleGoals goals_;

    std::vector<std::uint8_t> kinds_;         ///< [sites] while there are records
    std::vector<std::uint8_t> levels_;        ///< [sites] of the groups that they belong to
    std::vector<std::vector<Group>> groups_;  ///< [levels][blocks]
    /// For the records of each block of level 0. In one piece, which goes back as such: of pieces the size of a block
    /// little could be used by what comes after.
    std::vector<std::uint32_t> room_;
    Fans border_;
    std::vector<TriangleFlows> flows_;  ///< [triangles] capacities in exact passes, sweeps when they were measured
    double unit_ = 0;                   ///< capacities' to those of the terms
};

}  // namespace ccdt
