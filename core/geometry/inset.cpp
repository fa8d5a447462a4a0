#include "core/geometry/inset.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/difference.h"
#include "core/geometry/repair.h"

namespace ccdt {

namespace {

double length(Point p) {
    return std::sqrt(dot(p, p));
}

/// Distance of a point from a segment.
double distance_to(Point a, Point b, Point p) {
    const Point along = b - a, from = p - a;
    const double squared = dot(along, along);
    const double at = squared > 0 ? std::clamp(dot(from, along) / squared, 0.0, 1.0) : 0;
    return length(from - at * along);
}

/// What is too near to a domain's border, as many polygons; in the unit frame.
///
/// If discs lie around their points, the nearest point of the border to a place inside that is too near lies on an
/// edge, and the place on its left; or it is a corner that reaches inwards, and the place is between the two edges'
/// normals. Many edges that hardly differ from one segment are taken for it, and what is near to that on either side:
/// of those that are much finer than the distance few are left. Other discs are all taken so.
class Strip {
public:
    Strip(const Domain& domain, const DiscAround& disc_around, bool is_centred)
        : domain_(domain),
          scale_(std::max(domain.bounds().width(), domain.bounds().height())),
          disc_around_(disc_around),
          is_centred_(is_centred) {
        for (const Ring& ring : domain.rings()) add_ring(ring);
    }

    /// One convex polygon each; neighbours in number are neighbours in the plane, mostly.
    std::vector<Area> take() { return std::move(areas_); }

private:
    static constexpr double kSlice = std::numbers::pi / 16;  ///< of an arc: its radius over the polygon's is 0.995

    /// The disc around a point of the border, in the unit frame, with room for rounding.
    Disc disc(Point p) const {
        constexpr double kRoundings = 1e-12, kResolutions = 4, kMost = 4;  // the latter reaches over all of the frame
        const Disc given = disc_around_(domain_.to_user(p));
        if (!(given.radius > 0)) return {p, 0};
        const double radius = std::min(kMost, (1 + kRoundings) * (given.radius / scale_));
        const Point centre = is_centred_ ? p : (1 / scale_) * (given.centre - domain_.bounds().min);
        return {centre, radius + kResolutions * domain_.resolution()};
    }

    static Point normal(Point a, Point b) {
        const Point along = b - a;
        const double inverse = 1 / length(along);
        return {-inverse * along.y, inverse * along.x};
    }

    /// Edges of a ring that are taken for one segment.
    struct Run {
        std::size_t edges = 1;
        double reach = 0;  ///< distance to be kept from the segment
    };

    void add_ring(const Ring& ring) {
        const std::size_t size = ring.size();
        const auto at = [&](std::size_t i) { return ring[i % size]; };
        discs_.clear();
        for (const Point& p : ring) discs_.push_back(disc(p));
        bool was_edge = false, first_is_edge = false;
        for (std::size_t i = 0; i < size;) {
            const Run run = longest_run(ring, i);
            const bool is_edge = run.edges == 1;
            const Disc &from = discs_[i], &to = discs_[(i + run.edges) % size];
            if (!is_edge) {
                add_capsule(from.centre, to.centre, run.reach);
            } else if (is_centred_) {
                add_edge(at(i), at(i + 1), from.radius);
            } else {
                add_swept(at(i), at(i + 1), from, to, kMostHalvings);
            }
            if (was_edge && is_edge && is_centred_) add_corner(at(i - 1), at(i), at(i + 1), from.radius);
            if (i == 0) first_is_edge = is_edge;
            was_edge = is_edge;
            i += run.edges;
        }
        if (was_edge && first_is_edge && is_centred_) add_corner(at(size - 1), at(0), at(1), discs_[0].radius);
    }

    /// The run of edges from a corner on: one edge, or so many that a capsule is less work than they are.
    Run longest_run(const Ring& ring, std::size_t first) const {
        constexpr std::size_t kFewest = 4;
        Run longest;
        for (std::size_t step = kFewest; step > 0;) {
            const auto run = run_of(ring, first, longest.edges == 1 ? step : longest.edges + step);
            if (run) longest = *run;
            if (!run && longest.edges == 1) break;
            step = run ? 2 * step : step / 2;
            if (!run && step < kFewest) break;
        }
        return longest;
    }

    /// A run of so many edges; none if there are not as many left, or they bend too far.
    std::optional<Run> run_of(const Ring& ring, std::size_t first, std::size_t edges) const {
        constexpr double kMostOff = 2e-3;  // of the distance that is kept
        if (first + edges > ring.size()) return std::nullopt;
        const Point a = discs_[first].centre, b = discs_[(first + edges) % ring.size()].centre;
        double least = discs_[first].radius, most = least, off = 0;
        for (std::size_t i = first + 1; i <= first + edges; ++i) {
            const Disc& own = discs_[i % ring.size()];
            least = std::min(least, own.radius);
            most = std::max(most, own.radius);
            off = std::max(off, distance_to(a, b, own.centre));
            if (!(most - least + off <= kMostOff * least) || least == 0) return std::nullopt;
        }
        return Run{edges, most + off};
    }

    /// What the discs around the points of an edge cover, halved until the disc of its middle is where it should be.
    void add_swept(Point a, Point b, const Disc& from, const Disc& to, int halvings) {
        constexpr double kMostOff = 5e-4;
        const Point middle = 0.5 * (a + b);
        const Disc between = disc(middle);
        const double widest = std::max(from.radius, to.radius);
        const double off = distance_to(from.centre, to.centre, between.centre) + between.radius - widest;
        if (off <= kMostOff * widest || halvings == 0) {
            if (widest > 0) add_capsule(from.centre, to.centre, widest + std::max(off, 0.0));
            return;
        }
        add_swept(a, middle, from, between, halvings - 1);
        add_swept(middle, b, between, to, halvings - 1);
    }

    /// What is near to a segment: the polygon about two half circles and what is between.
    void add_capsule(Point a, Point b, double reach) {
        const Point up = a == b ? Point{0, 1} : normal(a, b);
        const double radius = reach / std::cos(kSlice / 2);
        Ring capsule;
        for (const auto& [centre, first] : {std::pair{a, up}, {b, -1 * up}}) {
            for (double angle = kSlice / 2; angle < std::numbers::pi; angle += kSlice)
                capsule.push_back(centre + radius * turned(first, angle));
        }
        add(std::move(capsule));
    }

    static Point turned(Point p, double angle) {
        const double c = std::cos(angle), s = std::sin(angle);
        return {c * p.x - s * p.y, s * p.x + c * p.y};
    }

    void add_edge(Point a, Point b, double reach) {
        const Point up = normal(a, b);
        add({a, b, b + reach * up, a + reach * up});
    }

    /// What is too near to a corner that reaches inwards: the polygon about the arc between the normals.
    void add_corner(Point before, Point corner, Point after, double reach) {
        const Point in = corner - before, out = after - corner;
        const double turn = std::atan2(cross(in, out), dot(in, out));
        if (turn >= 0) return;
        const Point first = normal(before, corner), last = normal(corner, after);
        const int slices = static_cast<int>(std::ceil(-turn / kSlice));
        const double slice = turn / slices, radius = reach / std::cos(slice / 2);
        Ring fan{corner, corner + reach * last};
        for (int i = slices; i-- > 0;) {
            fan.push_back(corner + radius * turned(first, (i + 0.5) * slice));
        }
        fan.push_back(corner + reach * first);
        add(std::move(fan));
    }

    void add(Ring polygon) {
        Ring inside = clipped(std::move(polygon), domain_.unit_bounds());
        if (inside.size() < 3) return;
        for (Point& p : inside) {
            if (p.x < Domain::kLeast) p.x = 0;
            if (p.y < Domain::kLeast) p.y = 0;
        }
        areas_.push_back({std::move(inside)});
    }

    static constexpr int kMostHalvings = 10;

    const Domain& domain_;
    const double scale_;
    const DiscAround& disc_around_;
    const bool is_centred_;    ///< discs have the points for centres, and one radius
    std::vector<Disc> discs_;  ///< around the corners of a ring
    std::vector<Area> areas_;
};

/// Joins areas, few at a time, into few: what each of them has inside others is gone before it meets the rest.
Result<std::vector<Area>> joined(std::vector<Area> areas, const Domain& domain, const std::stop_token& stop) {
    constexpr std::size_t kTogether = 8;
    while (areas.size() > kTogether) {
        std::vector<Area> fewer;
        for (std::span<const Area> rest = areas; !rest.empty(); rest = rest.subspan(std::min(kTogether, rest.size()))) {
            auto one = united(rest.first(std::min(kTogether, rest.size())), domain.resolution(), stop);
            if (!one) return tl::unexpected(one.error());
            fewer.push_back(*std::move(one));
        }
        areas = std::move(fewer);
    }
    return areas;
}

Result<Domain> without_strip(const Domain& domain, const DiscAround& disc_around, bool is_centred,
                             const std::stop_token& stop) {
    auto strip = joined(Strip(domain, disc_around, is_centred).take(), domain, stop);
    if (!strip) return tl::unexpected(strip.error());
    if (strip->empty()) return domain;
    return domain.without(*strip, stop);
}

/// Distance of a point from the border, below 0 outside; in the unit frame.
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

Result<Domain> inset(const Domain& domain, double distance, const std::stop_token& stop) {
    return without_strip(
        domain,
        [distance](Point p) {
            return Disc{p, distance};
        },
        true, stop);
}

Result<Domain> inset(const Domain& domain, const DiscAround& disc_around, const std::stop_token& stop) {
    return without_strip(domain, disc_around, false, stop);
}

double largest_clearance(const Domain& domain, const std::stop_token& stop) {
    struct Cell {
        Point centre;
        double half;   ///< of its side
        double depth;  ///< of its centre
        double most() const { return depth + half * std::numbers::sqrt2; }
        bool operator<(const Cell& other) const { return most() < other.most(); }
    };
    constexpr double kEnough = 1.01, kLeast = 1e-6;
    constexpr int kMostCells = 10'000;
    const auto cell_at = [&](Point centre, double half) { return Cell{centre, half, depth(domain, centre)}; };
    std::priority_queue<Cell> cells;
    cells.push(cell_at({0.5, 0.5}, 0.5));
    double best = 0;
    for (int looked_at = 0; looked_at < kMostCells && !stop.stop_requested(); ++looked_at) {
        const Cell cell = cells.top();
        cells.pop();
        best = std::max(best, cell.depth);
        if (cell.most() <= std::max(kEnough * best, kLeast)) break;
        const double half = cell.half / 2;
        for (const Point by : {Point{-half, -half}, Point{half, -half}, Point{-half, half}, Point{half, half}})
            cells.push(cell_at(cell.centre + by, half));
    }
    return best * std::max(domain.bounds().width(), domain.bounds().height());
}

}  // namespace ccdt
