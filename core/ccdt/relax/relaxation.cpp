// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/relax/relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/lanes.h"
#include "core/ccdt/relax/move_equations.h"
#include "core/geometry/predicates.h"
#include "core/mesh/move_guard.h"

namespace ccdt {

namespace {

/// Least doubled area, relative to the mean, that the fast test LaneRings::fit() accepts. If a triangle would become
/// smaller, move() checks the move.
constexpr double kSmall = 1e-2;
constexpr std::size_t kRange = 8192;  ///< triangles per task

}  // namespace

inline GoalTerm Relaxation::term(std::uint32_t triangle) const {
    const TriangleGoal goal = goals_.of(triangle);
    const double scale = goal.share == 1 ? 1 : 1 / std::sqrt(goal.share);
    return {scale * goal.weight, scale * goal.target, goal.share * goal.weight, scale};
}

Relaxation::Relaxation(Triangulation& mesh, std::vector<bool> fixed, bool uniform, const RelaxationOptions& options)
    : mesh_(mesh),
      options_(options),
      magic_(mesh.is_torus() ? kSnapping : 0),
      groups_(mesh, std::move(fixed), uniform) {}

void Relaxation::prepare(TriangleGoals goals, const std::stop_token& stop) {
    goals_ = std::move(goals);
    plain_weight_ = goals_.of(0).weight;
    if (groups_.has_no_rings()) small_ = options_.small_area ? *options_.small_area : kSmall * mean_doubled_area();
    groups_.list(stop);
}

void Relaxation::prepare_exact(TriangleGoals goals, const std::stop_token& stop) {
    goals_ = std::move(goals);
    groups_.list_sites(stop);
}

TriangleGoals Relaxation::take_goals() {
    flows_ = std::vector<TriangleFlows>();
    return std::move(goals_);
}

double Relaxation::mean_doubled_area() const {
    std::vector<double> areas((mesh_.triangle_count() + kRange - 1) / kRange, 0);
    for_ranges(mesh_.executor(), mesh_.triangle_count(), kRange, [&](std::size_t begin, std::size_t end) {
        double& area = areas[begin / kRange];
        for (std::size_t t = begin; t < end; ++t) area += mesh_.doubled_area(static_cast<std::uint32_t>(t));
    });
    return std::accumulate(areas.begin(), areas.end(), 0.0) / static_cast<double>(mesh_.triangle_count());
}

void Relaxation::pass(int times, const std::stop_token& stop) {
    for_groups(times, stop, [&](std::size_t level, std::size_t number) { move_group(groups_.level(level)[number]); });
}

/// Calls move(level, number) `times` times for each group, and slides the vertices of the border as often. Each group
/// moves up to three times in a row, level by level.
template <class Move>
void Relaxation::for_groups(int times, const std::stop_token& stop, Move&& move) {
    // A larger value leaves longer waves in drafts: benchmark CountryPattern.
    constexpr int kInTurn = 3;
    for (; times > 0; times -= kInTurn) {
        const int in_turn = std::min(times, kInTurn);
        const auto repeat = [&](auto&& step) {
            for (int time = 0; time < in_turn && !stop.stop_requested(); ++time) step();
        };
        for (std::size_t level = 0; level < groups_.levels(); ++level) {
            mesh_.executor().run(groups_.level(level).size(),
                                 [&](std::size_t number) { repeat([&] { move(level, number); }); });
        }
        repeat([&] {
            for (const Fan& fan : groups_.border().all) slide(groups_.border(), fan);
        });
    }
}

/// Moves a group's sites, one kind after the other (see MoveGroups), and then the sites on the general path.
void Relaxation::move_group(const Group& group) {
    move_batch<true, 2>(group);
    move_batch<true, 3>(group);
    move_batch<true, 4>(group);
    move_batch<false, 2>(group);
    move_batch<false, 3>(group);
    move_batch<false, 4>(group);
    for (const Fan& fan : group.fans.all) move_site(group.fans, fan);
}

/// Moves the sites of a batch, alternately from four parts of the batch. Sites with successive numbers are neighbours
/// in the plane, so their moves depend on each other. In the alternating order, most successive sites can be moved at
/// once.
template <bool kPlain, std::size_t kPairs>
void Relaxation::move_batch(const Group& group) {
    constexpr std::uint8_t kKind = MoveGroups::kind_of(kPlain, kPairs);
    constexpr std::size_t kStride = MoveGroups::stride(kKind);
    constexpr std::size_t kStreams = 4;
    const std::span<const std::uint32_t> batch = group.batch(kKind);
    const std::uint32_t* const records = batch.data();
    const std::size_t count = batch.size() / kStride;
    const std::size_t length = (count + kStreams - 1) / kStreams;
    const bool by_two = options_.by_two && !options_.fence && has_two_lanes();
    for (std::size_t i = 0; i < length; ++i) {
        for (std::size_t at = i; at < count; at += length) {
            const std::uint32_t* const record = records + at * kStride;
            const std::uint32_t* const next = by_two && at + length < count ? record + length * kStride : nullptr;
            if (next != nullptr && !has_neighbour<kPairs>(record, next[0])) {
                by_two_lanes([&](auto lanes) CCDT_INLINE {
                    move_few<kPlain, kPairs, decltype(lanes)>({record, next});
                });
                at += length;
            } else {
                move_few<kPlain, kPairs, OneLane>({record});
            }
        }
    }
}

/// Whether a site is a neighbour of a record's site.
template <std::size_t kPairs>
bool Relaxation::has_neighbour(const std::uint32_t* record, std::uint32_t site) {
    bool found = false;
    for (std::size_t i = 1; i <= 2 * kPairs; ++i) found |= record[i] == site;
    return found;
}

/// Returns the normal equations of plain sites, around which all triangles have the common goal. The sums of a and b
/// (derivatives of the doubled areas) over a closed ring vanish, and so does the contribution of the common target. All
/// terms are divided by the squared weight.
template <std::size_t kPairs, class Lanes>
CCDT_INLINE inline LaneEquations<Lanes> Relaxation::plain_equations(const LaneRings<kPairs, Lanes>& rings,
                                                                    const Records<Lanes>& records) const {
    LaneEquations<Lanes> equations;
    typename Lanes::Pairs spring_x{}, spring_y{};
    for (std::size_t i = 0; i < kPairs; ++i) {
        equations.add(rings.a[i], rings.b[i], rings.area[i]);
        spring_x += rings.x[i];
        spring_y += rings.y[i];
    }
    std::array<double, Lanes::kCount> repetitions;  // the spring to a repeated first neighbour must not count
    for (std::size_t lane = 0; lane < Lanes::kCount; ++lane)
        repetitions[lane] = records[lane][2 * kPairs] == records[lane][1] ? 1 : 0;
    const auto repeated = Lanes::each(repetitions);
    const double spring = options_.spring / plain_weight_;
    equations.stiffness = spring * (2.0 * kPairs - repeated);
    equations.pull_x = spring * (Lanes::sum(spring_x) - repeated * Lanes::first(rings.x[0]));
    equations.pull_y = spring * (Lanes::sum(spring_y) - repeated * Lanes::first(rings.y[0]));
    return equations;
}

/// Returns the normal equations of sites around which the triangles have goals of their own.
template <std::size_t kPairs, class Lanes>
CCDT_INLINE inline LaneEquations<Lanes> Relaxation::weighted_equations(const LaneRings<kPairs, Lanes>& rings,
                                                                       const Records<Lanes>& records) const {
    using Pairs = typename Lanes::Pairs;
    LaneEquations<Lanes> equations;
    Pairs spring_x{}, spring_y{}, springs{};
    for (std::size_t i = 0; i < kPairs; ++i) {
        std::array<Pair, Lanes::kCount> weights, targets, strengths;
        for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) {
            const std::uint32_t* const triangles = records[lane] + 2 + 2 * kPairs;
            const GoalTerm even = term(triangles[2 * i]), odd = term(triangles[2 * i + 1]);
            weights[lane] = Pair{even.weight, odd.weight};
            targets[lane] = Pair{even.target, odd.target};
            strengths[lane] = Pair{even.spring, odd.spring};
        }
        const Pairs weight = Lanes::join(weights), spring = Lanes::join(strengths);
        equations.add(weight * rings.a[i], weight * rings.b[i], weight * rings.area[i] - Lanes::join(targets));
        spring_x += spring * (rings.x[i] + rings.next_x(i));
        spring_y += spring * (rings.y[i] + rings.next_y(i));
        springs += spring;
    }
    equations.stiffness = options_.spring * Lanes::sum(springs);
    equations.pull_x = 0.5 * options_.spring * Lanes::sum(spring_x);
    equations.pull_y = 0.5 * options_.spring * Lanes::sum(spring_y);
    return equations;
}

/// Moves one site like move_site(), or several sites that are not neighbours. Applies the fence only with one lane.
template <bool kPlain, std::size_t kPairs, class Lanes>
CCDT_INLINE inline void Relaxation::move_few(const Records<Lanes>& records) {
    Point* const points = mesh_.points().data();
    const LaneRings<kPairs, Lanes> rings(points, records);
    const LaneEquations<Lanes> equations =
        kPlain ? plain_equations<kPairs, Lanes>(rings, records) : weighted_equations<kPairs, Lanes>(rings, records);
    const auto [to_x, to_y] = equations.minimum();
    typename Lanes::Numbers by_x = options_.relaxation * to_x, by_y = options_.relaxation * to_y;
    if constexpr (Lanes::kCount == 1) {
        const Point by = fenced(records[0][0], {by_x, by_y});
        by_x = by.x;
        by_y = by.y;
    }
    const auto fits = rings.fit(by_x, by_y, small_);
    for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) {
        const std::uint32_t vertex = records[lane][0];
        const Point by{Lanes::at(by_x, lane), Lanes::at(by_y, lane)};
        if ((fits[2 * lane] & fits[2 * lane + 1]) != 0) {
            points[vertex] = rounded(points[vertex] + by);
        } else {
            move(vertex, by, {{records[lane] + 1, 2 * kPairs}, nullptr}, 2 * kPairs);
        }
    }
}

Relaxation::Ring Relaxation::ring_of(const Fans& fans, const Fan& fan) const {
    return {{&fans.vertices[fan.first], fan.neighbours}, &fans.lifts[fan.first]};
}

Point Relaxation::position(const Ring& ring, std::size_t i) const {
    const std::size_t at = i < ring.vertices.size() ? i : 0;
    const Point p = mesh_.point(ring.vertices[at]);
    return ring.lifts == nullptr ? p : p + ring.lifts[at];
}

/// Returns the normal equations from the triangles around a vertex.
NormalEquations Relaxation::equations_of(const Fans& fans, const Fan& fan) const {
    const Ring ring = ring_of(fans, fan);
    const Point v = mesh_.point(fan.vertex);
    NormalEquations equations;
    for (std::uint32_t i = 0; i < fan.triangles; ++i) {
        equations.add(position(ring, i) - v, position(ring, i + 1) - v, term(fans.triangles[fan.first + i]),
                      options_.spring);
    }
    return equations;
}

void Relaxation::move_site(const Fans& fans, const Fan& fan) {
    const NormalEquations equations = equations_of(fans, fan);
    const Point by = options_.relaxation * minimum(equations.xx, equations.xy, equations.yy, equations.gradient);
    move(fan.vertex, fenced(fan.vertex, by), ring_of(fans, fan), fan.triangles);
}

void Relaxation::slide(const Fans& fans, const Fan& fan) {
    const std::span<const std::uint32_t> around{&fans.vertices[fan.first], fan.neighbours};
    const std::uint32_t* triangles = &fans.triangles[fan.first];
    const Point v = mesh_.point(fan.vertex);
    NormalEquations equations = equations_of(fans, fan);
    equations.add_spring(mesh_.point(around.front()) - v, options_.border_spring * term(triangles[0]).spring);
    equations.add_spring(mesh_.point(around.back()) - v,
                         options_.border_spring * term(triangles[fan.triangles - 1]).spring);
    const Point along = mesh_.point(around.front()) - mesh_.point(around.back());
    move(fan.vertex, options_.relaxation * equations.minimum_along(along) * along, ring_of(fans, fan), fan.triangles);
}

/// Moves a vertex, but only so far that the first `triangles` triangles around it keep enough area.
void Relaxation::move(std::uint32_t vertex, Point by, const Ring& ring, std::size_t triangles) {
    if (!std::isfinite(by.x) || !std::isfinite(by.y)) return;
    // On a torus with few sites, a site can be its own neighbour. Its triangles would then move with the site.
    if (std::ranges::find(ring.vertices, vertex) != ring.vertices.end()) return;
    const Point v = mesh_.point(vertex);
    double share = 1;
    for (std::size_t i = 0; i < triangles; ++i) {
        const Point from = position(ring, i) - v, to = position(ring, i + 1) - v;
        const double area = cross(from, to);
        const double change = (from.y - to.y) * by.x + (to.x - from.x) * by.y;
        const double kept =
            std::min(area, std::max(kKeptShare * area, needle_area({}, from, to, options_.least_height)));
        if (area + share * change < kept) share = std::max(0.0, (kept - area) / change);
    }
    // Next to flat triangles, rounding could still invert a triangle.
    const Point moved = rounded(v + share * by);
    for (std::size_t i = 0; i < triangles; ++i) {
        const Point from = position(ring, i), to = position(ring, i + 1);
        if (from != to && orientation(moved, from, to) <= 0) return;
    }
    if (share < 1 && options_.fence && mesh_.is_site(vertex) && options_.fence(vertex, moved) != moved) return;
    mesh_.points()[vertex] = moved;
}

void Relaxation::measure(const CapacityIntegral& capacity, const std::stop_token& stop) {
    const double sites = options_.site_share ? 1 / *options_.site_share : static_cast<double>(mesh_.site_count());
    unit_ = 2 * sites / capacity.total();
    capacity.of_edges(mesh_, flows_, stop);
}

void Relaxation::exact_pass(int times, const std::stop_token& stop) {
    for_groups(times, stop, [&](std::size_t level, std::size_t number) { move_group_exactly(level, number); });
}

void Relaxation::move_group_exactly(std::size_t level, std::size_t number) {
    ExactRing ring;
    groups_.for_sites(level, number, [&](std::uint32_t site) { move_exactly(site, ring); });
}

/// Moves a site according to the true capacities. A triangle (site, from, to) gains the capacity that its edge
/// site-from sweeps to the right of the edge, and loses the capacity that site-to sweeps.
void Relaxation::move_exactly(std::uint32_t site, ExactRing& ring) {
    ring.triangles.clear();
    NormalEquations equations;
    const std::uint32_t first = mesh_.edge_of(site);
    std::uint32_t h = first;
    do {
        const std::uint32_t triangle = Triangulation::triangle_of(h);
        const std::uint32_t after = mesh_.twin(Triangulation::previous(h));
        const Point from = mesh_.along(h), to = mesh_.along(after);
        const double first_swept = swept(h), last_swept = swept(after);
        const Point gradient{unit_ * (first_swept * from.y - last_swept * to.y),
                             unit_ * (last_swept * to.x - first_swept * from.x)};
        const GoalTerm term = this->term(triangle);
        equations.add(term.scale * gradient, term.scale * unit_ * flows_[triangle].capacity - term.target);
        equations.add_springs(from, to, options_.spring * term.spring);
        ring.triangles.push_back({triangle, mesh_.target(h), from, gradient});
        h = after;
    } while (h != first);
    const Point before = mesh_.point(site);
    const Point by = fenced(site, minimum(equations.xx, equations.xy, equations.yy, equations.gradient));
    if (surely_fits(site, by, ring)) {
        mesh_.points()[site] = rounded(before + by);
    } else {
        ring.fans.clear();
        groups_.add_fan(site, ring.fans);
        const Fan& fan = ring.fans.all.front();
        move(site, by, ring_of(ring.fans, fan), fan.triangles);
    }
    const Point moved = mesh_.point(site) - before;
    for (const ExactTriangle& t : ring.triangles) flows_[t.triangle].capacity += dot(t.gradient, moved) / unit_;
}

/// Tests quickly whether move() would make a move in full. Returns false in uncertain cases.
inline bool Relaxation::surely_fits(std::uint32_t site, Point by, const ExactRing& ring) const {
    const std::size_t count = ring.triangles.size();
    const double flattest = options_.least_height * options_.least_height;
    bool fits = true;
    for (std::size_t i = 0; i < count; ++i) {
        const Point from = ring.triangles[i].from, to = ring.triangles[i + 1 < count ? i + 1 : 0].from;
        const double area = cross(from, to);
        const double moved = area + ((from.y - to.y) * by.x + (to.x - from.x) * by.y);
        const double longest = 2 * (dot(from, from) + dot(to, to));  // squared upper bound of all edge lengths
        fits &= moved >= kKeptShare * area && moved >= kMinShape * longest && moved * moved >= flattest * longest &&
                ring.triangles[i].vertex != site;
    }
    return fits;
}

double Relaxation::energy() const {
    double energy = 0;
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
        const GoalTerm term = this->term(t);
        const double residual = term.weight * mesh_.doubled_area(t) - term.target;
        energy += residual * residual;
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Triangulation::edge(t, i);
            const Point length = mesh_.along(h);
            const bool border = mesh_.twin(h) == Triangulation::kNone;
            const double spring = 0.5 * options_.spring + (border ? options_.border_spring : 0);
            energy += spring * term.spring * dot(length, length);
        }
    }
    return energy;
}

}  // namespace ccdt
