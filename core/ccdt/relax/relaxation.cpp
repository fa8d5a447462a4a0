// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/relax/relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/lanes.h"
#include "core/geometry/predicates.h"
#include "core/mesh/move_guard.h"

namespace ccdt {

namespace {

/// Least doubled area, relative to the mean, that the fast test Rings::fit() accepts. If a triangle would become
/// smaller, move() checks the move.
constexpr double kSmall = 1e-2;
constexpr std::size_t kRange = 8192;  ///< triangles per task
constexpr double kSingular =
    1e-12;  ///< least determinant relative to the product of the diagonal; larger than its rounding error

/// Returns the step along x and y to the minimum of a quadratic with the given half Hessian and half gradient; a zero
/// step if the Hessian is singular. The arguments are single numbers, or vectors with one number per lane.
template <class Numbers>
CCDT_INLINE inline std::array<Numbers, 2> minimum(Numbers xx, Numbers xy, Numbers yy, Numbers x, Numbers y) {
    const Numbers det = xx * yy - xy * xy;
    const Numbers inverse = det > kSingular * xx * yy ? 1 / det : Numbers{};
    return {(xy * y - yy * x) * inverse, (xy * x - xx * y) * inverse};
}

Point minimum(double xx, double xy, double yy, Point gradient) {
    const auto [x, y] = minimum(xx, xy, yy, gradient.x, gradient.y);
    return {x, y};
}

}  // namespace

/// Contribution of a triangle to the normal equations of its corners.
struct Relaxation::Term {
    double weight;  ///< weight and target are divided by the square root of the triangle's share
    double target;
    double spring;  ///< weight * share
    double scale;   ///< 1 / sqrt(share)
};

inline Relaxation::Term Relaxation::term(std::uint32_t triangle) const {
    const TriangleGoal goal = goals_.of(triangle);
    const double scale = goal.share == 1 ? 1 : 1 / std::sqrt(goal.share);
    return {scale * goal.weight, scale * goal.target, goal.share * goal.weight, scale};
}

/// The one-rings of sites that are moved at once, one site per lane. Each vector holds the values of two triangles of
/// each site. The first neighbour is repeated to fill the last pair. The resulting flat triangle contributes nothing.
template <std::size_t kPairs, class Lanes>
struct Relaxation::Rings {
    using Pairs = typename Lanes::Pairs;

    CCDT_INLINE Rings(const Point* points, const Records<Lanes>& records) {
        const auto position = [&](std::size_t i) CCDT_INLINE {
            std::array<Pair, Lanes::kCount> positions;
            for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) positions[lane] = load(points[records[lane][i]]);
            return Lanes::join(positions);
        };
        const Pairs here = position(0);
        for (std::size_t i = 0; i < kPairs; ++i) {
            const Pairs p = position(1 + 2 * i) - here, q = position(2 + 2 * i) - here;
            x[i] = Lanes::firsts(p, q);
            y[i] = Lanes::seconds(p, q);
        }
        x[kPairs] = x[0];
        y[kPairs] = y[0];
        for (std::size_t i = 0; i < kPairs; ++i) {
            area[i] = x[i] * next_y(i) - y[i] * next_x(i);
            a[i] = y[i] - next_y(i);
            b[i] = next_x(i) - x[i];
        }
    }

    /// Returns the coordinates of the neighbours that follow the ones in x[i] and y[i], counter-clockwise.
    CCDT_INLINE Pairs next_x(std::size_t i) const { return Lanes::shifted(x[i], x[i + 1]); }
    CCDT_INLINE Pairs next_y(std::size_t i) const { return Lanes::shifted(y[i], y[i + 1]); }

    /// Whether all triangles keep enough area when the sites move by (by_x, by_y). The result has two components per
    /// lane, which must both be true.
    /// @param least  least doubled area
    CCDT_INLINE auto fit(typename Lanes::Numbers by_x, typename Lanes::Numbers by_y, double least) const {
        const Pairs move_x = Lanes::twice(by_x), move_y = Lanes::twice(by_y);
        auto fits = move_x == move_x;
        for (std::size_t i = 0; i < kPairs; ++i) {
            const Pairs moved = area[i] + a[i] * move_x + b[i] * move_y;
            fits &= (area[i] == Pairs{}) | ((moved >= kKeptShare * area[i]) & (moved >= least + Pairs{}));
        }
        return fits;
    }

    std::array<Pairs, kPairs + 1> x, y;    ///< positions of the neighbours relative to the site
    std::array<Pairs, kPairs> area, a, b;  ///< doubled areas, and their derivatives along x and y
};

/// Normal equations (see NormalEquations) of sites that are moved at once, one site per lane.
template <class Lanes>
struct Relaxation::Equations {
    using Pairs = typename Lanes::Pairs;
    using Numbers = typename Lanes::Numbers;

    /// Adds two triangles of each site.
    /// @param a, b  derivatives of the residual along x and y
    CCDT_INLINE void add(Pairs a, Pairs b, Pairs residual) {
        xx += a * a;
        xy += a * b;
        yy += b * b;
        x += residual * a;
        y += residual * b;
    }
    CCDT_INLINE std::array<Numbers, 2> minimum() const {
        return ccdt::minimum(Lanes::sum(xx) + stiffness, Lanes::sum(xy), Lanes::sum(yy) + stiffness,
                             Lanes::sum(x) - pull_x, Lanes::sum(y) - pull_y);
    }

    Pairs xx{}, xy{}, yy{}, x{}, y{};
    Numbers stiffness, pull_x, pull_y;  ///< sums over all springs
};

/// Normal equations of one vertex at its current position: half gradient and half Hessian of the energy.
struct Relaxation::NormalEquations {
    double xx = 0, xy = 0, yy = 0;
    Point gradient;

    /// Adds a triangle (vertex, from, to), and half of the springs along its two edges at the vertex.
    void add(Point from, Point to, const Term& term, double spring) {
        // Twice the area is cross(from, to) = a x + b y + c in the vertex's coordinates.
        const Point growth{term.weight * (from.y - to.y), term.weight * (to.x - from.x)};
        add(growth, term.weight * cross(from, to) - term.target);
        add_springs(from, to, spring * term.spring);
    }

    /// Adds a triangle whose residual (capacity minus target) and gradient of capacity are given.
    void add(Point growth, double residual) {
        xx += growth.x * growth.x;
        xy += growth.x * growth.y;
        yy += growth.y * growth.y;
        gradient = gradient + residual * growth;
    }

    /// Adds half of the springs along a triangle's two edges at the vertex.
    void add_springs(Point from, Point to, double stiffness) {
        add_spring(from, 0.5 * stiffness);
        add_spring(to, 0.5 * stiffness);
    }

    void add_spring(Point spoke, double stiffness) {
        xx += stiffness;
        yy += stiffness;
        gradient = gradient - stiffness * spoke;
    }

    double minimum_along(Point direction) const {
        const double curvature =
            direction.x * direction.x * xx + 2 * direction.x * direction.y * xy + direction.y * direction.y * yy;
        return curvature > 0 ? -dot(gradient, direction) / curvature : 0;
    }
};

Relaxation::Relaxation(Triangulation& mesh, std::vector<bool> fixed, bool uniform, const RelaxationOptions& options)
    : mesh_(mesh),
      fixed_(std::move(fixed)),
      uniform_(uniform),
      options_(options),
      magic_(mesh.is_torus() ? kSnapping : 0) {}

void Relaxation::prepare(TriangleGoals goals, const std::stop_token& stop) {
    goals_ = std::move(goals);
    plain_weight_ = goals_.of(0).weight;
    if (kinds_.empty()) small_ = options_.small_area ? *options_.small_area : kSmall * mean_doubled_area();
    make_groups();
    list_sites(stop);
    list_border();
}

/// Stores the level of each site, which determines its group. Stores no one-rings.
void Relaxation::prepare_exact(TriangleGoals goals, const std::stop_token& stop) {
    goals_ = std::move(goals);
    const bool first_time = levels_.empty();
    make_groups();
    kinds_ = std::vector<std::uint8_t>();
    record_memory_ = std::vector<std::uint32_t>();
    levels_.resize(mesh_.blocks().sites());
    mesh_.executor().run(groups_[0].size(), [&](std::size_t number) {
        if (!stop.stop_requested()) find_levels(number, first_time);
    });
    for (std::size_t level = 1; level < groups_.size(); ++level) {
        mesh_.executor().run(groups_[level].size(), [&](std::size_t number) { list_larger(level, number, true); });
    }
    list_border();
}

TriangleGoals Relaxation::take_goals() {
    flows_ = std::vector<TriangleFlows>();
    return std::move(goals_);
}

void Relaxation::list_border() {
    border_.clear();
    const auto sites = static_cast<std::uint32_t>(mesh_.site_count());
    for (std::uint32_t v = sites; v < mesh_.vertex_count(); ++v) {
        if (!fixed_[v - sites]) add_fan(v, border_);
    }
}

void Relaxation::make_groups() {
    const SiteBlocks& blocks = mesh_.blocks();
    groups_.resize(static_cast<std::size_t>(blocks.levels()));
    for (int level = 0; level < blocks.levels(); ++level)
        groups_[static_cast<std::size_t>(level)].resize(blocks.count(level));
}

/// Sorts the free sites into groups that can be moved in parallel.
void Relaxation::list_sites(const std::stop_token& stop) {
    const SiteBlocks& blocks = mesh_.blocks();
    const bool first_time = kinds_.empty();
    record_memory_.resize(record_memory_of(blocks.sites()));
    kinds_.resize(blocks.sites(), kFanKind);
    levels_.resize(blocks.sites());
    mesh_.executor().run(blocks.count(0), [&](std::size_t number) {
        if (!stop.stop_requested()) list_block(number, first_time);
    });
    for (std::size_t level = 1; level < groups_.size(); ++level) {
        mesh_.executor().run(groups_[level].size(), [&](std::size_t number) { list_larger(level, number, false); });
    }
}

void Relaxation::Fans::clear() {
    all.clear();
    vertices.clear();
    lifts.clear();
    triangles.clear();
}

/// Clears everything but the records.
void Relaxation::Group::clear() {
    fans.clear();
    sites.clear();
    others.clear();
}

/// Stores new records: in `memory` if they fit, else in the group.
void Relaxation::Group::store(const Batches& batches, std::span<std::uint32_t> memory) {
    for (std::size_t kind = 0; kind < kKinds; ++kind)
        begins[kind + 1] = begins[kind] + static_cast<std::uint32_t>(batches[kind].size());
    std::uint32_t* to = memory.data();
    if (begins.back() > memory.size()) {
        own.resize(begins.back());
        to = own.data();
    }
    for (std::size_t kind = 0; kind < kKinds; ++kind) std::ranges::copy(batches[kind], to + begins[kind]);
    records = to;
}

/// Returns the number of 32-bit words reserved for the records of `sites` sites. The mean number of neighbours is 6,
/// and the last pair of a record may be half empty. A block that needs more stores its records itself.
std::size_t Relaxation::record_memory_of(std::size_t sites) const {
    constexpr double kSpare = 1.06;
    const double neighbours = 6.5, plain = 2 + neighbours, general = plain + neighbours;
    return static_cast<std::size_t>(kSpare * (uniform_ ? plain : general) * static_cast<double>(sites));
}

/// Lists the sites of a block whose free neighbours are all in the block, and collects the other sites in
/// Group::others. Records of sites with unchanged neighbours, which are most, are copied from the old batches.
void Relaxation::list_block(std::size_t number, bool first_time) {
    const SiteBlocks& blocks = mesh_.blocks();
    const std::uint32_t begin = blocks.begin(number), end = blocks.begin(number + 1);
    Group& group = groups_[0][number];
    Batches batches;
    for (std::uint8_t kind = 0; kind < kKinds; ++kind) {
        const std::size_t size = group.batch(kind).size();
        batches[kind].reserve(size + size / 16);  // most sites keep their kind
    }
    group.clear();
    std::array<std::size_t, kKinds> taken{};
    for (std::uint32_t v = begin; v < end; ++v) {
        const bool kept = !first_time && !mesh_.has_changed(v);
        const std::uint8_t kind = first_time || levels_[v] > 0 ? kFanKind : kinds_[v];
        if (kind != kFanKind) {
            const std::uint32_t* const record = group.batch(kind).data() + taken[kind];
            taken[kind] += stride(kind);
            if (kept) {
                batches[kind].insert(batches[kind].end(), record, record + stride(kind));
                continue;
            }
        }
        if (kept && levels_[v] > 0) {
            group.others.push_back(v);
        } else if (add_site(v, batches, group.fans, begin, end - begin)) {
            levels_[v] = 0;
        } else {
            levels_[v] = level_of(v);
            group.others.push_back(v);
        }
    }
    group.store(
        batches,
        std::span(record_memory_).subspan(record_memory_of(begin), record_memory_of(end) - record_memory_of(begin)));
}

/// Determines the level of each site of a level-0 block (see levels_). Keeps levels that are known, if the neighbours
/// of the site are unchanged. Lists the sites above level 0, which move with a larger block.
void Relaxation::find_levels(std::size_t number, bool first_time) {
    const SiteBlocks& blocks = mesh_.blocks();
    Group& group = groups_[0][number];
    group = {};
    for (std::uint32_t v = blocks.begin(number); v < blocks.begin(number + 1); ++v) {
        if (first_time || mesh_.has_changed(v)) levels_[v] = level_of(v);
        if (levels_[v] > 0) group.others.push_back(v);
    }
}

/// Lists the sites for which a block above level 0 is the smallest one that contains them and their free neighbours.
/// @param exact  whether to list the sites alone, without records
void Relaxation::list_larger(std::size_t level, std::size_t number, bool exact) {
    Group& group = groups_[level][number];
    group.clear();
    Batches batches;
    const auto& smaller = groups_[level - 1];
    const std::size_t first = groups_[level].size() == 1 ? 0 : 4 * number;
    const std::size_t last = groups_[level].size() == 1 ? smaller.size() : first + 4;
    for (std::size_t block = first; block < last; ++block) {
        for (const std::uint32_t v : smaller[block].others) {
            if (levels_[v] > level) {
                group.others.push_back(v);
            } else {
                group.sites.push_back(v);
                if (!exact) add_site(v, batches, group.fans, 0, Triangulation::kNone);
            }
        }
    }
    group.store(batches, {});
}

/// Returns the level of the smallest block that contains a site and all its free neighbours.
std::uint8_t Relaxation::level_of(std::uint32_t site) const {
    const SiteBlocks& blocks = mesh_.blocks();
    const std::uint32_t own = blocks.of(site), first = mesh_.edge_of(site);
    std::uint32_t apart = 0, h = first;
    do {
        const std::uint32_t other = mesh_.target(h);
        if (mesh_.is_free(other)) apart |= blocks.of(other) ^ own;
        h = mesh_.twin(Triangulation::previous(h));
    } while (h != first);
    return static_cast<std::uint8_t>(blocks.block(own, apart).level);
}

double Relaxation::mean_doubled_area() const {
    std::vector<double> areas((mesh_.triangle_count() + kRange - 1) / kRange, 0);
    for_ranges(mesh_.executor(), mesh_.triangle_count(), kRange, [&](std::size_t begin, std::size_t end) {
        double& area = areas[begin / kRange];
        for (std::size_t t = begin; t < end; ++t) area += mesh_.doubled_area(static_cast<std::uint32_t>(t));
    });
    return std::accumulate(areas.begin(), areas.end(), 0.0) / static_cast<double>(mesh_.triangle_count());
}

/// Adds a site to a batch of records or, for the general path, to the fans.
/// @param first, size  range of sites in the group
/// @returns            false, without any change, if the site has free neighbours outside the group
bool Relaxation::add_site(std::uint32_t site, Batches& batches, Fans& fans, std::uint32_t first, std::uint32_t size) {
    constexpr std::size_t kMax = 2 * kMaxPairs;
    std::array<std::uint32_t, 2 + 2 * kMax> record;
    std::array<std::uint32_t, kMax> triangles;
    std::uint32_t* around = &record[1];
    std::size_t count = 0;
    std::uint32_t largest = 0;
    bool fits = true;
    const std::uint32_t begin = mesh_.edge_of(site);
    std::uint32_t h = begin;
    do {
        const std::uint32_t other = mesh_.target(h), triangle = Triangulation::triangle_of(h);
        if (other - first >= size && mesh_.is_free(other)) return false;
        fits = fits && count < kMax && !mesh_.crosses_seam(triangle);
        if (fits) {
            largest = std::max(largest, around[count] = other);
            triangles[count++] = triangle;
        }
        h = mesh_.twin(Triangulation::previous(h));
    } while (h != begin);
    if (!fits) {
        kinds_[site] = kFanKind;
        add_fan(site, fans);
        return true;
    }

    const std::size_t pairs = std::max((count + 1) / 2, kMinPairs);
    const bool plain = uniform_ && mesh_.is_free(largest);
    record[0] = site;
    for (std::size_t i = count; i <= 2 * pairs; ++i) around[i] = around[0];
    kinds_[site] = kind_of(plain, pairs);
    Batch& batch = batches[kinds_[site]];
    batch.insert(batch.end(), record.begin(), record.begin() + 2 + 2 * static_cast<std::ptrdiff_t>(pairs));
    if (plain) return true;
    for (std::size_t i = count; i < 2 * pairs; ++i) triangles[i] = Triangulation::kNone;
    batch.insert(batch.end(), triangles.begin(), triangles.begin() + 2 * static_cast<std::ptrdiff_t>(pairs));
    return true;
}

void Relaxation::add_fan(std::uint32_t vertex, Fans& fans) const {
    Fan fan{vertex, static_cast<std::uint32_t>(fans.vertices.size()), 0, 0};
    const std::uint32_t first = mesh_.edge_of(vertex);
    std::uint32_t h = first;
    do {
        fans.vertices.push_back(mesh_.target(h));
        fans.lifts.push_back(mesh_.distance(mesh_.shift(h)));
        fans.triangles.push_back(Triangulation::triangle_of(h));
        ++fan.triangles;
        const std::uint32_t last = Triangulation::previous(h);
        h = mesh_.twin(last);
        if (h != Triangulation::kNone) continue;
        fans.vertices.push_back(mesh_.origin(last));
        fans.lifts.push_back({});
        fans.triangles.push_back(Triangulation::kNone);
    } while (h != Triangulation::kNone && h != first);
    fan.neighbours = static_cast<std::uint32_t>(fans.vertices.size()) - fan.first;
    fans.all.push_back(fan);
}

void Relaxation::pass(int times, const std::stop_token& stop) {
    for_groups(times, stop, [&](std::size_t level, std::size_t number) { move_group(groups_[level][number]); });
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
        for (std::size_t level = 0; level < groups_.size(); ++level) {
            mesh_.executor().run(groups_[level].size(),
                                 [&](std::size_t number) { repeat([&] { move(level, number); }); });
        }
        repeat([&] {
            for (const Fan& fan : border_.all) slide(border_, fan);
        });
    }
}

/// Moves a group's sites, one kind after the other (see kind_of), and then the sites on the general path.
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
    constexpr std::uint8_t kKind = kind_of(kPlain, kPairs);
    constexpr std::size_t kStride = stride(kKind);
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
CCDT_INLINE inline Relaxation::Equations<Lanes> Relaxation::plain_equations(const Rings<kPairs, Lanes>& rings,
                                                                            const Records<Lanes>& records) const {
    Equations<Lanes> equations;
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
CCDT_INLINE inline Relaxation::Equations<Lanes> Relaxation::weighted_equations(const Rings<kPairs, Lanes>& rings,
                                                                               const Records<Lanes>& records) const {
    using Pairs = typename Lanes::Pairs;
    Equations<Lanes> equations;
    Pairs spring_x{}, spring_y{}, springs{};
    for (std::size_t i = 0; i < kPairs; ++i) {
        std::array<Pair, Lanes::kCount> weights, targets, strengths;
        for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) {
            const std::uint32_t* const triangles = records[lane] + 2 + 2 * kPairs;
            const Term even = term(triangles[2 * i]), odd = term(triangles[2 * i + 1]);
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
    const Rings<kPairs, Lanes> rings(points, records);
    const Equations<Lanes> equations =
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
Relaxation::NormalEquations Relaxation::equations_of(const Fans& fans, const Fan& fan) const {
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
    for (const std::uint32_t site : groups_[level][number].sites) move_exactly(site, ring);
    if (level > 0) return;
    const std::uint32_t end = mesh_.blocks().begin(number + 1);
    for (std::uint32_t site = mesh_.blocks().begin(number); site < end; ++site) {
        if (levels_[site] == 0) move_exactly(site, ring);
    }
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
        const Term term = this->term(triangle);
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
        add_fan(site, ring.fans);
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
        const Term term = this->term(t);
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
