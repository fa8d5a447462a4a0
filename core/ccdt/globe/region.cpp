// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/region.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "core/base/elementary.h"
#include "core/ccdt/globe/turns.h"

namespace ccdt {

namespace {

/// Least radius of curvature of the ellipsoid, in metres.
constexpr double kMinRadius = 6'335'439;

/// Tolerance of coordinates at the ends of their ranges, in degrees: ten micrometres.
constexpr double kClose = 1e-10;
constexpr double kTolerance = 1e-3;  ///< tolerance of edges on a chart, relative to the pitch of sites
constexpr double kBentTo = 4'000;    ///< ratio of the buffer to the tolerance of edges

Result<void> check_positions(const Ring& ring, const std::string& pointer) {
    constexpr double kFarthest = 540;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const bool is_longitude = std::abs(ring[i].x) <= kFarthest, is_latitude = std::abs(ring[i].y) <= 90;
        if (is_longitude && is_latitude) continue;
        return failure(
            ErrorCode::Unusable,
            is_longitude ? "a latitude must be from -90 to 90 degrees" : "a longitude must be from -540 to 540 degrees",
            pointer + '/' + std::to_string(i));
    }
    return {};
}

/// Whether a ring jumps from one side of a map to the other: one of its edges spans more than 180 and less than 360
/// degrees.
bool jumps(const Ring& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const double jump = std::abs(ring[(i + 1) % ring.size()].x - ring[i].x);
        if (jump > kTurn / 2 && jump < kTurn) return true;
    }
    return false;
}

/// Removes the jumps of a ring. If the ring has jumps, its edges of 360 degrees count as edges of zero length. If the
/// ring goes around a pole, closes it along the pole.
void unroll(Ring& ring) {
    if (!jumps(ring)) return;
    double shift = 0, latitudes = 0;
    const double first = ring.front().x;
    double before = first;
    const auto follow = [&](double longitude) {
        const double jump = longitude - before;
        if (std::abs(jump) > kTurn / 2) shift -= std::copysign(kTurn, jump);
        before = longitude;
        return longitude + shift;
    };
    for (Point& p : ring) {
        p.x = follow(p.x);
        latitudes += p.y;
    }
    const double end = follow(first);
    if (end == first) return;
    const double pole = std::copysign(90.0, latitudes);
    if (ring.back().x != end) ring.push_back({end, ring.front().y});
    ring.push_back({end, pole});
    ring.push_back({first, pole});
}

/// Whether a closed ring goes around a pole.
bool goes_around(const Ring& ring) {
    return ring.size() > 2 && std::abs(ring.back().y) == 90 && ring.back().y == ring[ring.size() - 2].y &&
           std::abs(ring.back().x - ring[ring.size() - 2].x) >= kTurn;
}

/// Swaps an outer ring and a larger hole around the same pole. Either order encloses the same area on the globe.
void put_larger_outside(PolygonPart& part) {
    if (!goes_around(part.outer)) return;
    const auto reach = [](const Ring& ring) {
        double sum = 0;
        for (const Point& p : ring) sum += std::abs(p.y - ring.back().y);
        return sum / static_cast<double>(ring.size());
    };
    for (Ring& hole : part.holes) {
        if (goes_around(hole) && hole.back().y == part.outer.back().y && reach(hole) > reach(part.outer))
            std::swap(hole, part.outer);
    }
}

/// Shifts a hole by whole turns to the longitudes of its outer ring.
void follow(const Ring& outer, Ring& hole) {
    if (outer.empty() || hole.empty()) return;
    const auto by_longitude = [](Point a, Point b) { return a.x < b.x; };
    const auto [west, east] = std::ranges::minmax_element(outer, by_longitude);
    const auto [least, most] = std::ranges::minmax_element(hole, by_longitude);
    if (least->x <= east->x && most->x >= west->x) return;
    const double shift = longitude_wrap_offset(least->x, west->x);
    for (Point& p : hole) p.x += shift;
}

/// Clips a ring to one side of a meridian. Where the ring is cut off, the result has edges along the meridian.
/// @param sign  1: keeps the part east of the meridian; -1: west
///
/// Source: Sutherland and Hodgman, Reentrant polygon clipping, CACM 17 (1974).
Ring cut(const Ring& ring, double meridian, double sign) {
    Ring kept;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point a = ring[i], b = ring[(i + 1) % ring.size()];
        const double from = sign * (a.x - meridian), to = sign * (b.x - meridian);
        if (from >= 0) kept.push_back(a);
        if ((from < 0) != (to < 0) && from != 0 && to != 0)
            kept.push_back({meridian, a.y + from / (from - to) * (b.y - a.y)});
    }
    return kept;
}

/// A point far from any border, and whether it lies in the region.
struct FarPoint {
    Direction direction;
    double distance = 0;  ///< angle on the sphere, in radians
    bool is_inside = false;
};

/// Projects a region in degrees onto charts.
class ChartBuilder {
public:
    ChartBuilder(const Domain& degrees, std::size_t sites, double buffer, const std::stop_token& stop);

    Result<std::vector<ChartedPart>> execute();

    /// Returns the mean spacing of sites, in radians on the sphere.
    double pitch() const;

    /// Projects the region onto an existing chart.
    Result<Domain> project_onto(const Chart& chart, double pitch);

private:
    bool is_seam(Point a, Point b) const { return closes_ && a.x == b.x && (a.x == west_ || a.x == east_); }
    static bool is_pole(Point a, Point b) { return a.y == b.y && std::abs(a.y) == 90; }
    template <class Visit>
    void for_edges(Visit visit) const {
        for (const Ring& ring : rings_) {
            for (std::size_t i = 0; i < ring.size(); ++i) visit(ring[i], ring[(i + 1) % ring.size()]);
        }
    }
    template <class Visit>
    void for_pieces_of_seam(Point a, Point b, Visit visit) const;
    void find_seam();
    void sample_border();
    bool contains(Direction direction) const;
    double distance_to_border(Direction direction) const;
    void improve(FarPoint& far) const;
    FarPoint far_from_border() const;
    std::optional<Chart> simple_chart() const;
    double deviation(const Chart& chart, Point a, Point b) const;
    template <class Visit>
    static void for_chunks(Point a, Point b, Visit visit);
    template <class Visit>
    void for_bent_edges(Visit visit) const;
    double tolerance(const Chart& chart) const;
    double error(double tolerance) const;
    void project_edge(const Chart& chart, double tolerance, Point a, Point b, Ring& plane) const;
    std::vector<Ring> project_rings(const Chart& chart, double tolerance) const;
    Result<std::vector<ChartedPart>> on_one_chart(const Chart& chart) const;
    Result<std::vector<ChartedPart>> on_two_charts(const FarPoint& far) const;

    const std::stop_token& stop_;
    const double sites_;
    const double buffer_;      ///< distance of sites from the border, in radians
    std::vector<Ring> rings_;  ///< in degrees, with the inside on the left
    double west_ = 0, east_ = 0;
    bool closes_ = false;            ///< whether the east and west sides are the same meridian
    std::vector<double> seam_;       ///< latitudes of corners on the seam, ascending, which divide it into pieces
    std::vector<int> seam_sides_;    ///< [pieces of the seam] number of edges along the piece
    std::vector<Direction> border_;  ///< points on all edges, at most `step_` apart
    double step_ = 0;                ///< largest distance between successive points of `border_`, in radians
    std::size_t stride_ = 1;         ///< stride at which searches visit `border_`
    double coarsest_ = 0;            ///< largest tolerance of edges, in radians on the ground
};

ChartBuilder::ChartBuilder(const Domain& degrees, std::size_t sites, double buffer, const std::stop_token& stop)
    : stop_(stop),
      sites_(static_cast<double>(sites)),
      buffer_(buffer > 0 ? std::max(buffer, kMinBuffer) / kMinRadius : 0),
      west_(degrees.bounds().min.x),
      east_(degrees.bounds().max.x) {
    closes_ = east_ - west_ > kTurn - kClose;
    const auto corrected = [&](Point p) {
        if (closes_ && p.x > west_ + kTurn - kClose) p.x = west_ + kTurn;
        if (p.x < west_ + kClose) p.x = west_;
        if (std::abs(p.y) > 90 - kClose) p.y = std::copysign(90.0, p.y);
        return p;
    };
    for (const Ring& ring : degrees.rings()) {
        Ring& own = rings_.emplace_back();
        for (const Point& p : ring) own.push_back(corrected(degrees.to_user(p)));
    }
    if (closes_) east_ = west_ + kTurn;
}

/// Calls `visit(piece, from, to)` for the pieces of an edge on the seam, in order.
template <class Visit>
void ChartBuilder::for_pieces_of_seam(Point a, Point b, Visit visit) const {
    const auto index = [&](double latitude) {
        return static_cast<std::size_t>(std::ranges::lower_bound(seam_, latitude) - seam_.begin());
    };
    std::size_t i = index(a.y);
    const std::size_t end = index(b.y);
    while (i != end) {
        const std::size_t next = i < end ? i + 1 : i - 1;
        visit(std::min(i, next), Point{a.x, seam_[i]}, Point{a.x, seam_[next]});
        i = next;
    }
}

void ChartBuilder::find_seam() {
    if (!closes_) return;
    for (const Ring& ring : rings_) {
        for (const Point& p : ring) {
            if (p.x == west_ || p.x == east_) seam_.push_back(p.y);
        }
    }
    std::ranges::sort(seam_);
    seam_.erase(std::unique(seam_.begin(), seam_.end()), seam_.end());
    seam_sides_.assign(seam_.size(), 0);
    for_edges([&](Point a, Point b) {
        if (is_seam(a, b)) for_pieces_of_seam(a, b, [&](std::size_t piece, Point, Point) { ++seam_sides_[piece]; });
    });
}

void ChartBuilder::sample_border() {
    constexpr double kStep = 1, kMax = 1e6;
    constexpr std::size_t kLookedAt = 4'096;
    double length = 0;
    for_edges([&](Point a, Point b) { length += std::sqrt(dot(b - a, b - a)); });
    const double step = std::max(kStep, length / kMax);
    const auto add = [&](Point a, Point b) {
        const int steps = std::max(1, static_cast<int>(std::ceil(std::sqrt(dot(b - a, b - a)) / step)));
        for (int i = 0; i < steps; ++i) border_.push_back(direction_of(a + static_cast<double>(i) / steps * (b - a)));
    };
    for_bent_edges(add);
    step_ = step * kDegree;
    stride_ = 1 + border_.size() / kLookedAt;
}

bool ChartBuilder::contains(Direction direction) const {
    Point position = position_of(direction);
    position.x += longitude_wrap_offset(position.x, west_);
    bool inside = false;
    for_edges([&](Point a, Point b) {
        if ((a.x <= position.x) == (b.x <= position.x)) return;
        if (a.y + (position.x - a.x) / (b.x - a.x) * (b.y - a.y) > position.y) inside = !inside;
    });
    return inside;
}

double ChartBuilder::distance_to_border(Direction direction) const {
    double nearest = -1;
    for (std::size_t i = 0; i < border_.size(); i += stride_) nearest = std::max(nearest, dot(direction, border_[i]));
    return elementary::acos(std::clamp(nearest, -1.0, 1.0));
}

/// Moves a point to the local maximum of its distance from the border.
void ChartBuilder::improve(FarPoint& far) const {
    constexpr double kFirst = 0.1, kLast = 1e-4, kGain = 1e-9;
    for (double step = kFirst; step > kLast;) {
        const Chart around(far.direction);
        bool found = false;
        for (const Point move : {Point{step, 0}, Point{-step, 0}, Point{0, step}, Point{0, -step}}) {
            const Direction there = around.to_direction(move);
            const double distance = distance_to_border(there);
            if (distance < far.distance + kGain) continue;
            far.direction = there;
            far.distance = distance;
            found = true;
        }
        if (!found) step /= 2;
    }
}

/// Finds the point outside the region that is farthest from the border. If it is less than 5 degrees from the border,
/// and a point inside the region is farther, finds the farthest point inside.
FarPoint ChartBuilder::far_from_border() const {
    constexpr int kTried = 2'000;
    constexpr double kFree = 5 * kDegree;  // with a free cap of this radius, the scale varies by a factor of 525
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    FarPoint outside, inside{{0, 0, 0}, 0, true};
    for (int i = 0; i < kTried; ++i) {
        const double z = 1 - (2 * i + 1.0) / kTried, across = std::sqrt(1 - z * z);
        const Direction there{across * elementary::cos(i * golden), across * elementary::sin(i * golden), z};
        const double distance = distance_to_border(there);
        if (distance <= std::min(outside.distance, inside.distance)) continue;
        FarPoint& known = contains(there) ? inside : outside;
        if (distance > known.distance) known = {there, distance, known.is_inside};
    }
    for (FarPoint* each : {&outside, &inside}) {
        if (each->distance > 0) improve(*each);
    }
    return outside.distance >= std::min(kFree, inside.distance) ? outside : inside;
}

/// Returns the chart of a region that is small relative to the globe; none if the region is larger.
std::optional<Chart> ChartBuilder::simple_chart() const {
    constexpr double kMax = 0.5;  // cosine of the largest angle from the centre
    Direction sum{0, 0, 0};
    for (const Direction& each : border_) sum = sum + each;
    if (dot(sum, sum) < 1e-6) return std::nullopt;
    const Direction mean = normalised(sum);
    const bool is_near = std::ranges::all_of(border_, [&](const Direction& each) { return dot(mean, each) > kMax; });
    if (!is_near || contains(-mean)) return std::nullopt;
    return Chart(mean);
}

double ChartBuilder::pitch() const {
    double area = 0;
    for_edges([&](Point a, Point b) { area -= elementary::sin((a.y + b.y) / 2 * kDegree) * (b.x - a.x) * kDegree; });
    constexpr double kMin = 1e-20;
    return std::sqrt(std::max(area, kMin) / sites_);
}

/// Returns the deviation of an edge from a straight line on a chart, as a distance on the ground.
double ChartBuilder::deviation(const Chart& chart, Point a, Point b) const {
    const Point from = chart.to_plane(direction_of(a)), along = chart.to_plane(direction_of(b)) - from;
    double most = 0;
    for (const double part : {0.25, 0.5, 0.75}) {
        const Point there = chart.to_plane(direction_of(a + part * (b - a)));
        const Point off = there - from - part * along;
        most = std::max(most, std::sqrt(dot(off, off)) / (1 + dot(there, there) / 4));
    }
    return most;
}

/// Calls `visit(from, to)` for pieces of an edge that are at most four degrees long, in order.
template <class Visit>
void ChartBuilder::for_chunks(Point a, Point b, Visit visit) {
    constexpr double kLong = 4;
    const Point along = b - a;
    const int pieces = std::max(1, static_cast<int>(std::ceil(std::sqrt(dot(along, along)) / kLong)));
    for (int i = 0; i < pieces; ++i)
        visit(a + static_cast<double>(i) / pieces * along, i + 1 == pieces ? b : a + (i + 1.0) / pieces * along);
}

/// Whether an edge is straight on every chart, to within a tolerance.
bool is_straight(Point a, Point b, double tolerance) {
    const Point along = b - a;
    return dot(along, along) * kDegree * kDegree < tolerance;
}

/// Calls `visit(a, b)` for all edges that count as border. Edges along a pole, and pieces common to both sides of the
/// seam, do not count. All other edges are curved on a chart.
template <class Visit>
void ChartBuilder::for_bent_edges(Visit visit) const {
    for_edges([&](Point a, Point b) {
        if (is_pole(a, b)) return;
        if (!is_seam(a, b)) return visit(a, b);
        for_pieces_of_seam(a, b, [&](std::size_t piece, Point from, Point to) {
            if (seam_sides_[piece] == 1) visit(from, to);
        });
    });
}

/// Returns the tolerance for edges on a chart, in radians on the ground. A small buffer requires a fine tolerance, but
/// the number of pieces is limited. If there are very many corners, `inset` simplifies the border coarsely, so the
/// tolerance may be coarse.
double ChartBuilder::tolerance(const Chart& chart) const {
    constexpr double kMaxPieces = 10'000, kCoarser = 10;
    constexpr std::size_t kVeryManyCorners = 50'000;
    const double wanted = buffer_ / kBentTo;
    if (buffer_ == 0 || wanted >= coarsest_) return coarsest_;
    std::size_t corners = 0;
    for (const Ring& ring : rings_) corners += ring.size();
    const double coarsest = corners > kVeryManyCorners ? kCoarser * coarsest_ : coarsest_;
    double pieces = 0;  // number of pieces times the square root of the tolerance
    for_bent_edges([&](Point a, Point b) {
        if (is_straight(a, b, wanted)) return;
        for_chunks(a, b, [&](Point from, Point to) { pieces += std::sqrt(deviation(chart, from, to)); });
    });
    const double root = pieces / kMaxPieces;
    return std::clamp(root * root, wanted, coarsest);
}

/// Returns the deviation of edges in metres, or 0 if it is negligible relative to the buffer.
double ChartBuilder::error(double tolerance) const {
    constexpr double kMaxRadius = 6'399'594;
    return buffer_ > 0 && tolerance > buffer_ / kBentTo ? tolerance * kMaxRadius : 0;
}

/// Appends the approximation of an edge on a chart, without the end point.
void ChartBuilder::project_edge(const Chart& chart, double tolerance, Point a, Point b, Ring& plane) const {
    constexpr double kMaxPieces = 1'000;
    for_chunks(a, b, [&](Point from, Point to) {
        plane.push_back(chart.to_plane(direction_of(from)));
        if (is_straight(a, b, tolerance)) return;
        const double parts = std::ceil(std::sqrt(deviation(chart, from, to) / tolerance));
        const int cuts = static_cast<int>(std::min(parts, kMaxPieces));
        for (int cut = 1; cut < cuts; ++cut)
            plane.push_back(chart.to_plane(direction_of(from + static_cast<double>(cut) / cuts * (to - from))));
    });
}

/// Returns the rings in the plane of a chart. Edges common to both sides of the seam become lines that are traversed
/// twice.
std::vector<Ring> ChartBuilder::project_rings(const Chart& chart, double tolerance) const {
    std::vector<Ring> planes;
    for (const Ring& ring : rings_) {
        Ring& plane = planes.emplace_back();
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Point a = ring[i], b = ring[(i + 1) % ring.size()];
            if (is_pole(a, b)) {
                plane.push_back(chart.to_plane(direction_of(a)));
            } else if (!is_seam(a, b)) {
                project_edge(chart, tolerance, a, b, plane);
            } else {
                for_pieces_of_seam(a, b, [&](std::size_t piece, Point from, Point to) {
                    if (seam_sides_[piece] == 1) return project_edge(chart, tolerance, from, to, plane);
                    plane.push_back(chart.to_plane(direction_of(from)));
                });
            }
        }
    }
    return planes;
}

Result<std::vector<ChartedPart>> ChartBuilder::on_one_chart(const Chart& chart) const {
    const double tolerance = this->tolerance(chart);
    auto domain = Domain::enclosed_by(project_rings(chart, tolerance), stop_);
    if (!domain) return tl::unexpected(domain.error());
    std::vector<ChartedPart> parts;
    parts.push_back({chart, *std::move(domain), 0, error(tolerance), coarsest_});
    return parts;
}

/// Returns the radius in a chart's plane of the circle at an angle in radians from its centre.
double radius_of(double angle) {
    return 2 * elementary::tan(angle / 2);
}

/// Returns the corners of a circle around a chart's centre.
Ring circle(double angle) {
    constexpr int kCorners = 1'440;
    const double radius = radius_of(angle);
    Ring ring;
    for (int i = 0; i < kCorners; ++i) {
        const double turned = 2 * std::numbers::pi * i / kCorners;
        ring.push_back({radius * elementary::cos(turned), radius * elementary::sin(turned)});
    }
    return ring;
}

/// Divides the region along a circle around a point far from the border. The second part is the inside of the circle.
/// @param far  point inside the region
Result<std::vector<ChartedPart>> ChartBuilder::on_two_charts(const FarPoint& far) const {
    constexpr double kMaxAngle = 20 * kDegree, kMinAngle = kDegree;
    const double angle = std::min(kMaxAngle, far.distance - 2 * step_ - buffer_);
    if (angle < kMinAngle) {
        return failure(ErrorCode::Unusable,
                       "the polygon is strewn over all of the globe: no place is some degrees from its border");
    }
    const Chart chart(-far.direction), opposite(far.direction);
    // Seen from the centre, the circle encloses everything except the hole, which is the second part.
    const double tolerance = this->tolerance(chart);
    std::vector<Ring> rings = project_rings(chart, tolerance);
    rings.push_back(circle(std::numbers::pi - angle));
    auto most = Domain::enclosed_by(rings, stop_);
    if (!most) return tl::unexpected(most.error());
    auto rest = Domain::enclosed_by({circle(angle)}, stop_);
    if (!rest) return tl::unexpected(rest.error());
    std::vector<ChartedPart> parts;
    parts.push_back({chart, *std::move(most), radius_of(std::numbers::pi - angle), error(tolerance), coarsest_});
    parts.push_back({opposite, *std::move(rest), radius_of(angle), 0, coarsest_});
    return parts;
}

Result<Domain> ChartBuilder::project_onto(const Chart& chart, double pitch) {
    find_seam();
    return Domain::enclosed_by(project_rings(chart, kTolerance * pitch), stop_);
}

Result<std::vector<ChartedPart>> ChartBuilder::execute() {
    constexpr double kMinExtent = 1e-7;  // in degrees: a centimetre
    find_seam();
    sample_border();
    if (stop_.stop_requested()) return failure(ErrorCode::Stopped, "stopped before the polygon was charted");
    const double distance = pitch();
    if (distance * std::sqrt(sites_) < kMinExtent * kDegree)
        return failure(ErrorCode::Unusable, "the polygon is too small on the globe");
    coarsest_ = kTolerance * distance;
    const Direction in_the_pacific = direction_of({-150, -30});
    if (border_.empty()) return on_two_charts({in_the_pacific, std::numbers::pi, true});
    if (const auto chart = simple_chart()) return on_one_chart(*chart);
    const FarPoint far = far_from_border();
    return far.is_inside ? on_two_charts(far) : on_one_chart(Chart(-far.direction));
}

}  // namespace

Result<std::vector<PolygonPart>> unrolled(std::vector<PolygonPart> parts) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
        auto& [outer, holes] = parts[i];
        const std::string pointer = '/' + std::to_string(i) + '/';
        if (auto checked = check_positions(outer, pointer + '0'); !checked) return tl::unexpected(checked.error());
        unroll(outer);
        for (std::size_t k = 0; k < holes.size(); ++k) {
            if (auto checked = check_positions(holes[k], pointer + std::to_string(k + 1)); !checked)
                return tl::unexpected(checked.error());
            unroll(holes[k]);
            follow(outer, holes[k]);
        }
        put_larger_outside(parts[i]);
    }
    return parts;
}

Result<Domain> in_one_turn(const Domain& degrees, const std::stop_token& stop) {
    const Box& box = degrees.bounds();
    if (box.width() <= kTurn + kClose) return degrees;
    std::vector<Ring> rings;
    for (const Ring& unit : degrees.rings()) {
        const double first = std::floor((box.min.x + kTurn / 2) / kTurn);
        for (double turn = first; turn * kTurn - kTurn / 2 < box.max.x; ++turn) {
            Ring ring;
            for (const Point& p : unit) ring.push_back(degrees.to_user(p) - Point{turn * kTurn, 0});
            ring = cut(cut(ring, -kTurn / 2, 1), kTurn / 2, -1);
            if (!ring.empty()) rings.push_back(std::move(ring));
        }
    }
    return Domain::enclosed_by(rings, stop);
}

Result<std::vector<ChartedPart>> chart_region(const Domain& degrees, std::size_t sites, double buffer,
                                              const std::stop_token& stop) {
    return ChartBuilder(degrees, sites, buffer, stop).execute();
}

double ground_pitch(const Domain& degrees, std::size_t sites) {
    return ChartBuilder(degrees, sites, 0, {}).pitch();
}

Result<Domain> lay_on_chart(const Chart& chart, const Domain& degrees, double pitch, const std::stop_token& stop) {
    return ChartBuilder(degrees, 1, 0, stop).project_onto(chart, pitch);
}

}  // namespace ccdt
