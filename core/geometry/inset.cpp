// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/inset.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "core/base/elementary.h"
#include "core/geometry/difference.h"
#include "core/geometry/repair.h"
#include "core/geometry/simplify.h"

namespace ccdt {

namespace {

constexpr std::size_t kMore = 16;  ///< argument `more` of max_pieces(), since overlapping strips cross often

double length(Point p) {
    return std::sqrt(dot(p, p));
}

/// Returns the distance of a point from a segment.
double distance_to(Point a, Point b, Point p) {
    const Point along = b - a, from = p - a;
    const double squared = dot(along, along);
    const double at = squared > 0 ? std::clamp(dot(from, along) / squared, 0.0, 1.0) : 0;
    return length(from - at * along);
}

/// Largest angle between corners of the polygon around an arc. The polygon's radius exceeds the arc's by at most 0.5 %.
constexpr double kSlice = std::numbers::pi / 16;

/// A piece of the border and its neighbourhood: the area on the left of an edge, or on both sides of a segment.
struct Reach {
    Point a, b;
    double distance = 0;  ///< width of the neighbourhood
    bool is_edge = false;
    Point before, after;    ///< corners of the border before and after an edge
    double slice = kSlice;  ///< largest angle between corners of the arcs at the ends of an edge

    /// Returns the signed distance of a point from the neighbourhood; negative inside.
    double clearance(Point p) const { return distance_to(a, b, p) - distance; }

    /// Whether this piece begins where the other one ends, and the other piece is at least as wide.
    bool is_after(const Reach& other) const { return other.b == a && other.distance >= distance; }
};

/// Divides the area to remove, which the discs around all border points cover, into pieces (Reach), in the unit frame.
///
/// First case: the discs are centred at the border points. If a point of the domain is too near to the border, the
/// border point nearest to it lies either on an edge or at a reflex corner. On an edge, the point lies on the left of
/// the edge; at a reflex corner, it lies between the normals of the corner's two edges. So a piece is the neighbourhood
/// of an edge, on its left, with the reflex corners at its ends. A run of many edges close to one segment is replaced
/// by a capsule around the segment. So a border with detail much finer than the radius has few pieces.
///
/// Second case: the centres of the discs can differ from the border points. Each piece is then a capsule. If there are
/// many pieces and the discs hardly differ, all edges use the largest distance instead.
class Strip {
public:
    Strip(const Domain& domain, const DiscAround& disc_around, bool is_centred, double indifference)
        : domain_(domain),
          scale_(std::max(domain.bounds().width(), domain.bounds().height())),
          disc_around_(disc_around),
          is_centred_(is_centred),
          indifference_(indifference / scale_) {
        if (!is_centred && domain.corner_count() > kManyCorners) even_out();
        for (const Ring& ring : domain.rings()) add_ring(ring);
    }

    /// Returns the pieces. Successive pieces are neighbours along the border.
    std::vector<Reach> take() { return std::move(reaches_); }

    /// Whether the discs around all corners of the border have a radius above 0.
    bool is_whole() const { return is_whole_; }

private:
    /// Returns the disc around a point of the border, in the unit frame, with a margin for rounding.
    Disc disc(Point p) const {
        constexpr double kRoundings = 1e-12, kResolutions = 4, kMax = 4;  // kMax covers the whole frame
        const Disc given = disc_around_(domain_.to_user(p));
        if (!(given.radius > 0)) return {p, 0};
        const double radius = std::min(kMax, (1 + kRoundings) * (given.radius / scale_));
        const Point centre = is_centred_ ? p : (1 / scale_) * (given.centre - domain_.bounds().min);
        return {centre, radius + kResolutions * domain_.resolution()};
    }

    /// Successive edges of a ring that are replaced by one segment.
    struct Run {
        std::size_t edges = 1;
        double reach = 0;  ///< distance to keep from the segment
    };

    void add_ring(const Ring& ring) {
        const std::size_t size = ring.size();
        const auto at = [&](std::size_t i) { return ring[i % size]; };
        discs_.clear();
        for (const Point& p : ring) discs_.push_back(disc(p));
        is_whole_ = is_whole_ && std::ranges::all_of(discs_, [](const Disc& own) { return own.radius > 0; });
        for (std::size_t i = 0; i < size;) {
            const Run run = longest_run(ring, i);
            const Disc &from = discs_[i], &to = discs_[(i + run.edges) % size];
            if (run.edges > 1) {
                reaches_.push_back({from.centre, to.centre, run.reach, false, {}, {}});
            } else if (is_centred_) {
                reaches_.push_back({at(i), at(i + 1), from.radius, true, at(i + size - 1), at(i + 2)});
            } else if (same_ > 0 && from.radius > 0 && to.radius > 0) {
                reaches_.push_back({at(i), at(i + 1), same_, true, at(i + size - 1), at(i + 2), slice(same_)});
            } else {
                add_swept(at(i), at(i + 1), from, to, kMaxHalvings);
            }
            i += run.edges;
        }
    }

    /// Returns the run of edges that begins at a corner: a single edge, or several edges that one capsule can replace.
    Run longest_run(const Ring& ring, std::size_t first) const {
        constexpr std::size_t kMinCount = 4;
        Run longest;
        for (std::size_t step = kMinCount; step > 0;) {
            const auto run = run_of(ring, first, longest.edges == 1 ? step : longest.edges + step);
            if (run) longest = *run;
            if (!run && longest.edges == 1) break;
            step = run ? 2 * step : step / 2;
            if (!run && step < kMinCount) break;
        }
        return longest;
    }

    /// Returns the run of the given number of edges; none if too few follow, or if they deviate too far from a segment.
    std::optional<Run> run_of(const Ring& ring, std::size_t first, std::size_t edges) const {
        constexpr double kMaxOff = 2e-3;  // relative to the distance
        if (first + edges > ring.size()) return std::nullopt;
        const Point a = discs_[first].centre, b = discs_[(first + edges) % ring.size()].centre;
        double least = discs_[first].radius, most = least, off = 0;
        for (std::size_t i = first + 1; i <= first + edges; ++i) {
            const Disc& own = discs_[i % ring.size()];
            least = std::min(least, own.radius);
            most = std::max(most, own.radius);
            off = std::max(off, distance_to(a, b, own.centre));
            if (!(most - least + off <= kMaxOff * least) || least == 0) return std::nullopt;
        }
        return Run{edges, most + off};
    }

    /// Adds the area that the discs around the points of an edge sweep. Halves the edge until the disc at the
    /// middle of each piece hardly protrudes from the capsule around the discs at the ends of the piece.
    void add_swept(Point a, Point b, const Disc& from, const Disc& to, int halvings) {
        constexpr double kMaxOff = 5e-4;
        const Point middle = 0.5 * (a + b);
        const Disc between = disc(middle);
        const double widest = std::max(from.radius, to.radius);
        const double off = distance_to(from.centre, to.centre, between.centre) + between.radius - widest;
        if (off <= kMaxOff * widest || halvings == 0) {
            const double distance = widest + std::max(off, 0.0);
            if (widest > 0) reaches_.push_back({from.centre, to.centre, distance, false, {}, {}});
            return;
        }
        add_swept(a, middle, from, between, halvings - 1);
        add_swept(middle, b, between, to, halvings - 1);
    }

    /// Chooses one distance for all edges, if the discs hardly differ.
    void even_out() {
        constexpr double kBetween = 1e-3;  // margin for points between the ends of an edge, relative
        double least = std::numeric_limits<double>::infinity(), most = 0;
        for (const Ring& ring : domain_.rings()) {
            for (const Point& p : ring) {
                const Disc own = disc(p);
                if (own.radius == 0) continue;
                least = std::min(least, own.radius);
                most = std::max(most, (1 + kBetween) * needed(p, own));
            }
        }
        if (most - least <= indifference_) same_ = most;
    }

    /// Returns the radius of the smallest disc around `p` that contains another disc.
    static double needed(Point p, const Disc& disc) { return disc.radius + length(disc.centre - p); }

    /// Returns the angle between corners of the polygon around an arc. The polygon deviates from the arc by no more
    /// than `indifference_`.
    double slice(double distance) const {
        constexpr double kMaxSlice = std::numbers::pi / 3;
        return std::clamp(2 * elementary::acos(distance / (distance + indifference_)), kSlice, kMaxSlice);
    }

    static constexpr int kMaxHalvings = 10;
    static constexpr std::size_t kManyCorners = 4'000;

    const Domain& domain_;
    const double scale_;
    const DiscAround& disc_around_;
    const bool is_centred_;  ///< whether discs are centred at the border points, with one radius
    const double indifference_;
    bool is_whole_ = true;
    double same_ = 0;          ///< common distance of all edges if the discs hardly differ, else 0
    std::vector<Disc> discs_;  ///< around the corners of the current ring
    std::vector<Reach> reaches_;
};

/// Builds polygons around the neighbourhoods of border pieces, clipped to a box.
class Shapes {
public:
    Shapes(const Domain& domain, const Box& box) : box_(box) {
        const Box all = domain.unit_bounds();
        box_.min = {std::max(box.min.x, all.min.x), std::max(box.min.y, all.min.y)};
        box_.max = {std::min(box.max.x, all.max.x), std::min(box.max.y, all.max.y)};
    }

    /// Returns one convex polygon for each added piece.
    std::vector<Area> take() { return std::move(areas_); }

    /// Adds the neighbourhood of a piece.
    /// @param is_after  whether the preceding piece has been added, and with it the corner between the two pieces
    void add(const Reach& reach, bool is_after) {
        if (!reach.is_edge) return add_capsule(reach.a, reach.b, reach.distance);
        add_edge(reach.a, reach.b, reach.distance);
        if (!is_after) add_corner_before(reach);
        add_corner_after(reach);
    }

    /// Returns the number of leading pieces, at least 1, whose neighbourhoods one polygon can represent together. The
    /// neighbourhood of the last corner is not included. The edges of such a run have similar directions, and their
    /// offset lines do not degenerate. So the offset curve is a graph over the direction of the first edge, and does
    /// not cross itself.
    static std::size_t simple_run(std::span<const Reach> pieces) {
        constexpr std::size_t kMax = 256;
        constexpr double kForward = 0.05;  // least cosine
        if (!pieces[0].is_edge) return 1;
        const Point ahead = along(pieces[0]);
        double available = (1 - kKept) * length(pieces[0].b - pieces[0].a);
        std::size_t run = 1;
        for (; run < std::min(kMax, pieces.size()); ++run) {
            const Reach &last = pieces[run - 1], &next = pieces[run];
            if (!next.is_edge || next.a != last.b || next.distance != last.distance) break;
            const double shorter = shortened(last.b - last.a, next.b - next.a, next.distance);
            const double left = (1 - kKept) * length(next.b - next.a) - shorter;
            if (dot(along(next), ahead) < kForward || shorter > available || left < 0) break;
            available = left;
        }
        return run;
    }

    /// Adds the neighbourhood of a simple run of edges, on their left, between the normals at both ends of the run.
    void add_run(std::span<const Reach> run) {
        Ring strip;
        for (const Reach& edge : run) strip.push_back(edge.a);
        strip.push_back(run.back().b);
        strip.push_back(run.back().b + run.back().distance * normal(run.back().a, run.back().b));
        for (std::size_t i = run.size(); i-- > 1;) add_beside(run[i - 1], run[i], strip);
        strip.push_back(run.front().a + run.front().distance * normal(run.front().a, run.front().b));
        add(std::move(strip));
    }

    /// Whether the offset line of an edge keeps enough length (kKept) between the neighbouring offset lines.
    static bool keeps_line(const Reach& edge) {
        const Point along = edge.b - edge.a;
        return shortened(edge.a - edge.before, along, edge.distance) +
                   shortened(along, edge.after - edge.b, edge.distance) <=
               (1 - kKept) * length(along);
    }

    /// Returns the offset lines of a domain's rings, joined by arcs; none if an edge is so short that its offset line
    /// has no length, or if a line leaves the unit square.
    /// @param edges  the edges of all rings, in order
    static std::optional<Area> parallels(std::span<const Ring> rings, std::span<const Reach> edges) {
        Area lines;
        for (const Ring& ring : rings) {
            const auto own = edges.first(ring.size());
            edges = edges.subspan(ring.size());
            Ring line;
            for (std::size_t i = own.size(); i > 0; --i) {
                if (!keeps_line(own[i - 1])) return std::nullopt;
                add_beside(own[i - 1], own[i % own.size()], line);
            }
            const auto is_within = [](double v) { return v >= Domain::kMin && v <= 1; };
            if (!std::ranges::all_of(line, [&](Point p) { return is_within(p.x) && is_within(p.y); }))
                return std::nullopt;
            std::ranges::reverse(line);
            lines.push_back(std::move(line));
        }
        return lines;
    }

    /// Adds the neighbourhood of the corner before an edge.
    void add_corner_before(const Reach& edge) { add_corner(edge.before, edge.a, edge.b, edge); }
    void add_corner_after(const Reach& edge) { add_corner(edge.a, edge.b, edge.after, edge); }

    void add(Ring polygon) {
        Ring inside = clipped(std::move(polygon), box_);
        if (inside.size() < 3) return;
        for (Point& p : inside) {
            if (p.x < Domain::kMin) p.x = 0;
            if (p.y < Domain::kMin) p.y = 0;
        }
        areas_.push_back({std::move(inside)});
    }

private:
    static constexpr double kKept = 0.01;  ///< least length of an offset line, relative to its edge

    static Point along(const Reach& edge) {
        const Point by = edge.b - edge.a;
        return 1 / length(by) * by;
    }

    static double turn_between(Point in, Point out) { return elementary::atan2(cross(in, out), dot(in, out)); }

    /// Returns by how much the corner between two edges shortens the offset line of each of them.
    /// @param in, out  vectors along the edge that ends at the corner, and along the edge that begins there
    static double shortened(Point in, Point out, double distance) {
        const double turn = turn_between(in, out);
        return turn > 0 ? distance * elementary::tan(turn / 2) : 0;
    }

    static Point normal(Point a, Point b) {
        const Point along = b - a;
        const double inverse = 1 / length(along);
        return {-inverse * along.y, inverse * along.x};
    }

    static Point turned(Point p, double angle) {
        const double c = elementary::cos(angle), s = elementary::sin(angle);
        return {c * p.x - s * p.y, s * p.x + c * p.y};
    }

    /// Adds the neighbourhood of a segment: a polygon around two half discs and the rectangle between them.
    void add_capsule(Point a, Point b, double reach) {
        const Point up = a == b ? Point{0, 1} : normal(a, b);
        const double radius = reach / elementary::cos(kSlice / 2);
        Ring capsule;
        for (const auto& [centre, first] : {std::pair{a, up}, {b, -1 * up}}) {
            for (double angle = kSlice / 2; angle < std::numbers::pi; angle += kSlice)
                capsule.push_back(centre + radius * turned(first, angle));
        }
        add(std::move(capsule));
    }

    /// Adds a polygon that covers the neighbourhood of an edge, on its left. On the right, the polygon bulges beyond
    /// the edge. Otherwise one of its sides would run almost along the border, and cross it many times.
    void add_edge(Point a, Point b, double reach) {
        const Point up = normal(a, b);
        add({a, 0.5 * (a + b) - reach / 8 * up, b, b + reach * up, a + reach * up});
    }

    /// Adds the neighbourhood of a reflex corner: a polygon around the arc between the two normals.
    void add_corner(Point before, Point corner, Point after, const Reach& edge) {
        const double turn = turn_between(corner - before, after - corner);
        if (turn >= 0) return;
        Ring fan{corner};
        add_arc(before, corner, after, edge, turn, fan);
        add(std::move(fan));
    }

    /// Appends the polygon around the arc at a reflex corner, from the second edge's normal to the first edge's normal.
    static void add_arc(Point before, Point corner, Point after, const Reach& edge, double turn, Ring& ring) {
        const double reach = edge.distance;
        const Point first = normal(before, corner), last = normal(corner, after);
        const int slices = static_cast<int>(std::ceil(-turn / edge.slice));
        const double slice = turn / slices, radius = reach / elementary::cos(slice / 2);
        ring.push_back(corner + reach * last);
        for (int i = slices; i-- > 0;) ring.push_back(corner + radius * turned(first, (i + 0.5) * slice));
        ring.push_back(corner + reach * first);
    }

    /// Appends the join of the offset lines of two successive edges: their crossing, or an arc.
    static void add_beside(const Reach& before, const Reach& after, Ring& strip) {
        const double turn = turn_between(along(before), along(after));
        if (turn < 0) return add_arc(before.a, before.b, after.b, before, turn, strip);
        const Point up = normal(before.a, before.b) + normal(after.a, after.b);
        strip.push_back(after.a + 2 * before.distance / dot(up, up) * up);
    }

    Box box_;
    std::vector<Area> areas_;
};

/// Unites areas in groups of eight, repeatedly, until at most eight are left. Edges inside a union disappear early,
/// before they could cross other areas.
Result<std::vector<Area>> joined(std::vector<Area> areas, const Domain& domain, const std::stop_token& stop) {
    constexpr std::size_t kTogether = 8;
    while (areas.size() > kTogether) {
        std::vector<Area> fewer;
        for (std::span<const Area> rest = areas; !rest.empty(); rest = rest.subspan(std::min(kTogether, rest.size()))) {
            auto one = united(rest.first(std::min(kTogether, rest.size())), domain.resolution(), stop, kMore);
            if (!one) return tl::unexpected(one.error());
            fewer.push_back(*std::move(one));
        }
        areas = std::move(fewer);
    }
    return areas;
}

/// A quadtree over the unit square. Only the nearest piece of the border decides whether a point is too near to the
/// border. So a square is divided until few pieces can be the nearest piece of any point in the square.
class ReachTree {
public:
    /// @param coarse    radius in the unit frame of squares that are removed as a whole if the new border may cross
    ///                  them; 0: none
    /// @param coarsest  largest radius that `coarse` may grow to if there are very many squares; if `coarse` is 0, the
    ///                  division then ends early instead (see is_too_fine)
    ReachTree(const Domain& domain, std::vector<Reach> reaches, double coarse, double coarsest,
              const std::stop_token& stop)
        : domain_(domain), reaches_(std::move(reaches)), coarse_(coarse), coarsest_(coarsest), stop_(stop) {
        std::vector<std::uint32_t> all(reaches_.size());
        std::iota(all.begin(), all.end(), 0U);
        while (true) {
            squares_.assign(1, {});
            members_.clear();
            counts_whole_.assign(reaches_.size(), false);
            divide(0, kRoot, all);
            if (!has_very_many_squares() || coarse_ == 0) break;
            coarse_ = std::min(2 * coarse_, coarsest_);
        }
    }

    /// Whether the division ended early because there are very many squares. The tree is then useless.
    bool is_too_fine() const { return coarse_ == 0 && has_very_many_squares(); }

    /// Returns the removed area. If more than a fifth of the pieces are long and far apart, computes the whole area.
    /// Otherwise, computes the area only in the squares that its border can cross, square by square.
    Result<std::vector<Area>> border() const {
        constexpr double kMaxWhole = 0.2;
        const auto whole = static_cast<double>(std::ranges::count(counts_whole_, true));
        if (whole > kMaxWhole * static_cast<double>(reaches_.size())) {
            auto areas = joined(all_shapes(), domain_, stop_);
            if (areas || areas.error().code == ErrorCode::Stopped) return areas;
        }
        std::vector<Area> areas;
        for (const auto& [square, cell] : leaves()) {
            auto area = united(shapes_in(square, cell), domain_.resolution(), stop_, kMore);
            if (!area) return tl::unexpected(area.error());
            if (!area->empty()) areas.push_back(*std::move(area));
        }
        return areas;
    }

    /// Returns the offset lines of all edges, joined to rings; none if there are few pieces, or if any two of the lines
    /// meet. The rings are the new border, and rings inside the removed area, which the caller must drop.
    Result<std::optional<Area>> lines() const {
        const auto is_alike = [&](const Reach& piece) {
            return piece.is_edge && piece.distance == reaches_.front().distance;
        };
        const bool are_alike = reaches_.size() == domain_.corner_count() && std::ranges::all_of(reaches_, is_alike);
        if (!has_many() || !are_alike) return std::nullopt;
        auto lines = Shapes::parallels(domain_.rings(), reaches_);
        if (!lines) return lines;
        const auto enclosed = difference(*lines, {}, domain_.resolution(), stop_, kMore);
        if (!enclosed && enclosed.error().code == ErrorCode::Stopped) return tl::unexpected(enclosed.error());
        const auto corners = [](const Area& area) {
            std::size_t sum = 0;
            for (const Ring& ring : area) sum += ring.size();
            return sum;
        };
        // Each meeting of lines adds a corner.
        if (!enclosed || enclosed->size() != lines->size() || corners(*enclosed) != corners(*lines))
            return std::nullopt;
        return lines;
    }

    /// Returns the domain minus strips along its border; none if there are few pieces or the strips cross too often.
    Result<std::optional<Area>> without_strips() const {
        constexpr double kMaxLost = 0.02;  // beyond this share of degenerate lines, strips overlap repeatedly
        const auto is_lost = [](const Reach& piece) { return !piece.is_edge || !Shapes::keeps_line(piece); };
        const auto lost = static_cast<double>(std::ranges::count_if(reaches_, is_lost));
        if (!has_many() || lost > kMaxLost * static_cast<double>(reaches_.size())) return std::nullopt;
        const auto strips = this->strips();
        auto left = strips ? difference(domain_.rings(), *strips, domain_.resolution(), stop_)
                           : Result<Area>(tl::unexpected(strips.error()));
        if (left) return std::optional(*std::move(left));
        if (left.error().code == ErrorCode::Stopped) return tl::unexpected(left.error());
        return std::nullopt;
    }

    /// Whether a corner of the area that remains after subtracting border() is too near to the border of the domain.
    bool is_too_near(Point p) const {
        // Tolerances: kRounding is relative to the distance; kRoundings is in units of the resolution, and half of the
        // margin of the discs.
        constexpr double kRounding = 1e-6, kRoundings = 2;
        std::uint32_t at = 0;
        Cell cell = kRoot;
        while (squares_[at].kind == Kind::Divided) {
            const bool right = p.x >= cell.centre.x, upper = p.y >= cell.centre.y;
            const int quarter = 2 * upper + right;
            at = squares_[at].first + static_cast<std::uint32_t>(quarter);
            cell = cell.quarter(quarter);
        }
        const Square& square = squares_[at];
        if (square.kind != Kind::Border) return square.kind == Kind::Near;
        return std::ranges::any_of(pieces_in(square), [&](std::uint32_t i) {
            const double rounding = std::max(kRounding * reaches_[i].distance, kRoundings * domain_.resolution());
            return reaches_[i].clearance(p) < -rounding;
        });
    }

private:
    struct Cell {
        Point centre;
        double half = 0;  ///< half of the side
        double radius() const { return std::numbers::sqrt2 * half; }
        Cell quarter(int i) const {
            const double by = half / 2;
            return {centre + Point{i % 2 == 1 ? by : -by, i / 2 == 1 ? by : -by}, by};
        }
        Box box() const { return {centre - Point{half, half}, centre + Point{half, half}}; }
    };
    enum class Kind : std::uint8_t {
        Clear,    ///< no point of the square is too near to the border
        Near,     ///< all points of the square are too near
        Border,   ///< few pieces of the border can be nearest to points of the square
        Crowded,  ///< removed as a whole: too small to be divided, or all quarters are removed
        Divided,  ///< divided into four
    };
    struct Square {
        Kind kind = Kind::Clear;
        std::uint32_t first = 0;  ///< index of its first quarter in `squares_`, or of its first piece in `members_`
        std::uint32_t count = 0;  ///< number of pieces
    };
    static constexpr Cell kRoot{{0.5, 0.5}, 0.5};

    /// Whether there are so many pieces that combining them saves time. Combining pieces changes how corners of the
    /// result are rounded.
    bool has_many() const {
        constexpr std::size_t kManyPieces = 10'000;
        return reaches_.size() > kManyPieces;
    }

    /// Whether there are too many squares, and larger squares are allowed. Exact squares cost less than coarse ones,
    /// whose sides all become edges of the removed area.
    bool has_very_many_squares() const {
        constexpr std::size_t kVeryManySquares = 200'000, kVeryManyExactSquares = 3'000'000;
        return squares_.size() > (coarse_ > 0 ? kVeryManySquares : kVeryManyExactSquares) && coarse_ < coarsest_;
    }

    std::span<const std::uint32_t> pieces_in(const Square& square) const {
        return std::span(members_).subspan(square.first, square.count);
    }

    void divide(std::uint32_t at, const Cell& cell, std::span<const std::uint32_t> candidates) {
        constexpr std::size_t kFew = 12, kMinCount = 2;
        constexpr double kSure = 1e-3, kMin = 2e-3;  // relative to the distance
        constexpr double kRounding = 1e-15;
        if (stop_.stop_requested() || has_very_many_squares()) return;
        std::vector<double> clearances(candidates.size());
        std::size_t nearest = 0;
        for (std::size_t i = 0; i < candidates.size(); ++i) {
            clearances[i] = reaches_[candidates[i]].clearance(cell.centre);
            if (clearances[i] < clearances[nearest]) nearest = i;
        }
        const double radius = cell.radius() + kRounding;
        if (candidates.empty() || clearances[nearest] > radius) return;
        const double distance = reaches_[candidates[nearest]].distance;
        if (clearances[nearest] + radius <= -kSure * distance) {
            squares_[at].kind = Kind::Near;
            return;
        }
        const double most = std::min(clearances[nearest] + 2 * radius, radius);
        std::vector<std::uint32_t> left;
        for (std::size_t i = 0; i < candidates.size(); ++i) {
            if (clearances[i] <= most) left.push_back(candidates[i]);
        }
        if (radius <= coarse_) {
            squares_[at].kind = Kind::Crowded;
        } else if (left.size() <= (coarse_ > 0 ? kMinCount : kFew)) {
            squares_[at] = {Kind::Border, static_cast<std::uint32_t>(members_.size()),
                            static_cast<std::uint32_t>(left.size())};
            members_.insert(members_.end(), left.begin(), left.end());
            for (const std::uint32_t i : left)
                if (2 * reaches_[i].distance < cell.half) counts_whole_[i] = true;
        } else if (radius <= std::max(kMin * distance, 4 * kRounding)) {
            squares_[at].kind = Kind::Crowded;
        } else {
            const auto first = static_cast<std::uint32_t>(squares_.size());
            squares_[at] = {Kind::Divided, first, 0};
            squares_.resize(squares_.size() + 4);
            for (int i = 0; i < 4; ++i) divide(first + static_cast<std::uint32_t>(i), cell.quarter(i), left);
            const auto is_full = [](const Square& square) {
                return square.kind == Kind::Near || square.kind == Kind::Crowded;
            };
            if (coarse_ > 0 && std::ranges::all_of(std::span(squares_).subspan(first, 4), is_full))
                squares_[at] = {Kind::Crowded, 0, 0};
        }
    }

    struct Leaf {
        Square square;
        Cell cell;
    };

    /// Returns the squares that the border of the removed area can cross.
    std::vector<Leaf> leaves() const {
        std::vector<Leaf> found;
        find_leaves({squares_[0], kRoot}, found);
        return found;
    }

    void find_leaves(const Leaf& at, std::vector<Leaf>& found) const {
        if (at.square.kind == Kind::Border || at.square.kind == Kind::Crowded) found.push_back(at);
        if (at.square.kind != Kind::Divided) return;
        for (int i = 0; i < 4; ++i)
            find_leaves({squares_[at.square.first + static_cast<std::uint32_t>(i)], at.cell.quarter(i)}, found);
    }

    std::vector<Area> shapes_in(const Square& square, const Cell& cell) const {
        const Box box = cell.box();
        Shapes shapes(domain_, box);
        if (square.kind == Kind::Crowded)
            shapes.add({box.min, {box.max.x, box.min.y}, box.max, {box.min.x, box.max.y}});
        const auto pieces = pieces_in(square);
        for (std::size_t i = 0; i < pieces.size(); ++i)
            shapes.add(reaches_[pieces[i]], i > 0 && reaches_[pieces[i]].is_after(reaches_[pieces[i - 1]]));
        return shapes.take();
    }

    std::vector<Area> all_shapes() const {
        Shapes shapes(domain_, domain_.unit_bounds());
        for (std::size_t i = 0; i < reaches_.size(); ++i)
            shapes.add(reaches_[i], i > 0 && reaches_[i].is_after(reaches_[i - 1]));
        return shapes.take();
    }

    /// Builds the neighbourhoods of all pieces, with simple runs of edges combined into strips.
    Result<std::vector<Area>> strips() const {
        Shapes shapes(domain_, domain_.unit_bounds());
        Shapes strips(domain_, domain_.unit_bounds());
        for (std::span<const Reach> rest = reaches_; !rest.empty();) {
            const std::size_t run = Shapes::simple_run(rest);
            const bool is_after = rest.size() < reaches_.size() && rest[0].is_after(*(rest.data() - 1));
            if (run == 1) {
                shapes.add(rest[0], is_after);
            } else {
                strips.add_run(rest.first(run));
                if (!is_after) shapes.add_corner_before(rest[0]);
                shapes.add_corner_after(rest[run - 1]);
            }
            rest = rest.subspan(run);
        }
        auto areas = joined(shapes.take(), domain_, stop_);
        if (areas) std::ranges::move(strips.take(), std::back_inserter(*areas));
        return areas;
    }

    const Domain& domain_;
    std::vector<Reach> reaches_;
    double coarse_;
    const double coarsest_;
    std::vector<Square> squares_;
    std::vector<std::uint32_t> members_;  ///< pieces of all squares of kind Border, concatenated
    std::vector<bool> counts_whole_;  ///< [pieces] whether a square wider than 4 times the piece's distance lists it
    std::stop_token stop_;
};

/// Tries the three methods of ReachTree. Returns the new border, and leftover rings inside the removed area.
Result<Area> divided(const Domain& domain, const ReachTree& tree, const std::stop_token& stop) {
    for (const auto way : {&ReachTree::lines, &ReachTree::without_strips}) {
        auto left = (tree.*way)();
        if (!left) return tl::unexpected(left.error());
        if (*left) return **std::move(left);
    }
    const auto strip = tree.border();
    if (!strip) return tl::unexpected(strip.error());
    return difference(domain.rings(), *strip, domain.resolution(), stop, kMore);
}

/// Subtracts the neighbourhood of the border from the bounding box. Returns the remaining area, inside and outside the
/// domain, and leftover rings inside the neighbourhood. Requires discs with a radius above 0 around all points of the
/// border. Does not intersect the domain itself, since its very many edges would be cut very often.
Result<Area> far_from_border(const Domain& domain, const ReachTree& tree, const std::stop_token& stop) {
    const Point most = domain.unit_bounds().max;
    const auto strip = tree.border();
    if (!strip) return tl::unexpected(strip.error());
    return difference({{{0, 0}, {most.x, 0}, most, {0, most.y}}}, *strip, domain.resolution(), stop, kMore);
}

/// Erases the rings that lie outside a domain. No ring may cross the border of the domain.
void erase_outside(Area& rings, const Domain& domain) {
    struct Position {
        Point point;
        std::size_t ring = 0;
    };
    std::vector<Position> positions;
    for (std::size_t i = 0; i < rings.size(); ++i) positions.push_back({rings[i][0], i});
    const auto height = [](const Position& position) { return position.point.y; };
    std::ranges::sort(positions, {}, height);
    std::vector<bool> is_inside(rings.size(), false);
    for (const Ring& ring : domain.rings()) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Point a = ring[i], b = ring[(i + 1) % ring.size()];
            const auto [low, high] = std::minmax(a.y, b.y);
            for (auto at = std::ranges::lower_bound(positions, low, {}, height);
                 at != positions.end() && at->point.y < high; ++at) {
                if ((cross(b - a, at->point - a) > 0) == (b.y > a.y)) is_inside[at->ring] = !is_inside[at->ring];
            }
        }
    }
    std::size_t i = 0;
    std::erase_if(rings, [&](const Ring&) { return !is_inside[i++]; });
}

/// Simplifies the border of an area, whose rings may share corners.
Result<Area> simplified(const Area& area, double tolerance, double resolution, const std::stop_token& stop) {
    Area simple;
    for (const Ring& ring : area) simple.push_back(ccdt::simplified(ring, tolerance));
    return difference(simple, {}, resolution, stop, kMore);
}

/// Subtracts the neighbourhood of the border, at least where the new border runs. The remaining area consists of the
/// eroded domain and of rings that are too near to the border, which are dropped.
/// @param is_coarse  whether the new border may be much farther from the old one than the indifference
/// @returns          none if the exact border needs too many squares, and `indifference` permits a coarse border
Result<std::optional<Domain>> without_strip(const Domain& domain, const DiscAround& disc_around, bool is_centred,
                                            double indifference, bool is_coarse, const std::stop_token& stop) {
    constexpr double kCoarser = 10, kRadius = 0.25, kMaxRadius = 4, kSimplified = 0.5;  // relative to the indifference
    if (is_coarse) indifference *= kCoarser;
    const double tolerance = is_coarse ? kSimplified * indifference : 0;
    const DiscAround enlarged = [&](Point p) {
        const Disc disc = disc_around(p);
        return Disc{disc.centre, disc.radius > 0 ? disc.radius + tolerance : 0};
    };
    Strip border(domain, enlarged, is_centred, indifference);
    is_coarse = is_coarse && border.is_whole();
    auto reaches = border.take();
    if (reaches.empty()) return domain;
    const double scale = std::max(domain.bounds().width(), domain.bounds().height());
    const double unit = border.is_whole() ? indifference / scale : 0;
    const ReachTree tree(domain, std::move(reaches), is_coarse ? kRadius * unit : 0, kMaxRadius * unit, stop);
    if (tree.is_too_fine()) return std::nullopt;
    auto left = is_coarse ? far_from_border(domain, tree, stop) : divided(domain, tree, stop);
    if (!left) return tl::unexpected(left.error());
    if (is_coarse) erase_outside(*left, domain);
    std::erase_if(*left, [&](const Ring& ring) {
        return std::ranges::any_of(ring, [&](Point p) { return tree.is_too_near(p); });
    });
    if (is_coarse) left = simplified(*left, tolerance / scale, domain.resolution(), stop);
    if (!left) return tl::unexpected(left.error());
    return domain.within(*std::move(left)).map([](Domain&& whole) { return std::optional(std::move(whole)); });
}

/// Erodes a domain. If `indifference` > 0 and the border is very fine, the new border is coarse; see inset().
Result<Domain> eroded(const Domain& domain, const DiscAround& disc_around, bool is_centred, double indifference,
                      const std::stop_token& stop) {
    constexpr std::size_t kVeryManyCorners = 50'000;
    for (const bool is_coarse : {indifference > 0 && domain.corner_count() > kVeryManyCorners, true}) {
        auto left = without_strip(domain, disc_around, is_centred, indifference, is_coarse, stop);
        if (!left) return tl::unexpected(left.error());
        if (*left) return **std::move(left);
    }
    return failure(ErrorCode::Internal, "a coarse border was too fine");
}

/// Returns the distance of a point from the border in the unit frame, negative outside.
double depth(const Domain& domain, Point p) {
    double nearest = 2;
    bool inside = false;
    for (const Ring& ring : domain.rings()) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Point a = ring[i], b = ring[(i + 1) % ring.size()], along = b - a, from = p - a;
            nearest = std::min(nearest, distance_to(a, b, p));
            if ((from.y < 0) != (from.y < along.y) && (cross(along, from) > 0) == (along.y > 0)) inside = !inside;
        }
    }
    return inside ? nearest : -nearest;
}

}  // namespace

Result<Domain> inset(const Domain& domain, double distance, double indifference, const std::stop_token& stop) {
    return eroded(
        domain,
        [distance](Point p) {
            return Disc{p, distance};
        },
        true, indifference, stop);
}

Result<Domain> inset(const Domain& domain, const DiscAround& disc_around, double indifference,
                     const std::stop_token& stop) {
    return eroded(domain, disc_around, false, indifference, stop);
}

double largest_clearance(const Domain& domain, const std::stop_token& stop) {
    struct Cell {
        Point centre;
        double half;   ///< half of the side
        double depth;  ///< depth of the centre
        double most() const { return depth + half * std::numbers::sqrt2; }
        bool operator<(const Cell& other) const { return most() < other.most(); }
    };
    constexpr double kEnough = 1.01, kMin = 1e-6;
    constexpr int kMaxCells = 10'000;
    const auto cell_at = [&](Point centre, double half) { return Cell{centre, half, depth(domain, centre)}; };
    std::priority_queue<Cell> cells;
    cells.push(cell_at({0.5, 0.5}, 0.5));
    double best = 0;
    for (int looked_at = 0; looked_at < kMaxCells && !stop.stop_requested(); ++looked_at) {
        const Cell cell = cells.top();
        cells.pop();
        best = std::max(best, cell.depth);
        if (cell.most() <= std::max(kEnough * best, kMin)) break;
        const double half = cell.half / 2;
        for (const Point by : {Point{-half, -half}, Point{half, -half}, Point{-half, half}, Point{half, half}})
            cells.push(cell_at(cell.centre + by, half));
    }
    return best * std::max(domain.bounds().width(), domain.bounds().height());
}

}  // namespace ccdt
