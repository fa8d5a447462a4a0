#include "core/ccdt/relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/geometry/pair.h"
#include "core/geometry/predicates.h"

namespace ccdt {

namespace {

// Any share > 0 keeps triangles counter-clockwise; any shape well above 1e-16, the rounding of an area, keeps their
// areas' signs sure, and well below 1 leaves the pattern alone.
constexpr double kKeptArea = 0.1;     ///< least share of its area that a move leaves a triangle
constexpr double kLeastShape = 1e-5;  ///< least doubled area that a move leaves it, over its longest edge squared
constexpr double kSmall = 1e-2;       ///< doubled area over the mean one below which a triangle takes the general path
constexpr double kSingular = 1e-12;   ///< least determinant over the product of the diagonal, above its rounding

/// Step to the minimum of the quadratic with this half Hessian and half gradient; none where it is singular.
Point minimum(double xx, double xy, double yy, Point gradient) {
    const double det = xx * yy - xy * xy;
    if (!(det > kSingular * xx * yy)) return {};
    const double inverse = 1 / det;
    return {(xy * gradient.y - yy * gradient.x) * inverse, (xy * gradient.x - xx * gradient.y) * inverse};
}

}  // namespace

/// Normal equations of one vertex about its present place: the energy's half gradient and half Hessian.
struct Relaxation::NormalEquations {
    double xx = 0, xy = 0, yy = 0;
    Point gradient;

    /// Adds a triangle (vertex, from, to), and its half of the springs along the two edges at the vertex.
    void add(Point from, Point to, const Term& term, double spring) {
        // Twice the area is cross(from, to) = a x + b y + c in the vertex's coordinates.
        const Point growth{term.weight * (from.y - to.y), term.weight * (to.x - from.x)};
        add(growth, term.weight * cross(from, to) - term.target);
        add_springs(from, to, spring * term.spring);
    }

    /// Adds a triangle whose capacity is off its target by `residual` and grows by this much per unit of the move.
    void add(Point growth, double residual) {
        xx += growth.x * growth.x;
        xy += growth.x * growth.y;
        yy += growth.y * growth.y;
        gradient = gradient + residual * growth;
    }

    /// Adds a triangle's half of the springs along a triangle's two edges at the vertex.
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

void Relaxation::prepare(std::span<const TriangleGoal> goals, const std::stop_token& stop) {
    if (kinds_.empty()) small_ = options_.small_area ? *options_.small_area : kSmall * mean_doubled_area();
    set_terms(goals);
    old_batches_.swap(batches_);
    clear_lists();
    list_sites(stop);
    const auto sites = static_cast<std::uint32_t>(mesh_.site_count());
    for (std::uint32_t v = sites; v < mesh_.vertex_count(); ++v) {
        if (!fixed_[v - sites]) add_fan(v, border_fans_);
    }
}

void Relaxation::set_terms(std::span<const TriangleGoal> goals) {
    plain_weight_ = goals[0].weight;
    terms_.clear();
    for (const TriangleGoal& goal : goals) {
        const double scale = goal.share == 1 ? 1 : 1 / std::sqrt(goal.share);
        terms_.push_back({scale * goal.weight, scale * goal.target, goal.share * goal.weight, scale});
    }
    terms_.emplace_back();
}

void Relaxation::clear_lists() {
    for (Batch& batch : batches_) batch.clear();
    for (auto& starts : block_starts_) starts.clear();
    site_fans_.clear();
    border_fans_.clear();
    fan_vertices_.clear();
    fan_lifts_.clear();
    fan_triangles_.clear();
}

/// Adds each free site to a batch or, for the general path, to the fans. Most have kept their neighbours: their records
/// are taken over from the old batches, in the same order.
void Relaxation::list_sites(const std::stop_token& stop) {
    const bool first_time = kinds_.empty();
    const auto sites = static_cast<std::uint32_t>(mesh_.free_count());
    kinds_.resize(sites, kFanKind);
    std::array<std::size_t, kKinds> taken{};
    for (std::uint32_t v = 0; v < sites; ++v) {
        if (v % kBlock == 0) {
            if (stop.stop_requested()) return;
            for (std::size_t kind = 0; kind < kKinds; ++kind) block_starts_[kind].push_back(batches_[kind].size());
        }
        const std::uint8_t kind = kinds_[v];
        if (kind != kFanKind) {
            const auto record = old_batches_[kind].begin() + static_cast<std::ptrdiff_t>(taken[kind]);
            taken[kind] += stride(kind);
            if (!mesh_.has_changed(v)) {
                batches_[kind].insert(batches_[kind].end(), record, record + static_cast<std::ptrdiff_t>(stride(kind)));
                continue;
            }
        }
        if ((!first_time && kind == kFanKind && !mesh_.has_changed(v)) || !add_to_batch(v)) {
            kinds_[v] = kFanKind;
            add_fan(v, site_fans_);
        }
    }
    for (std::size_t kind = 0; kind < kKinds; ++kind) block_starts_[kind].push_back(batches_[kind].size());
}

double Relaxation::mean_doubled_area() const {
    double area = 0;
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) area += mesh_.doubled_area(t);
    return area / static_cast<double>(mesh_.triangle_count());
}

/// @returns false, and nothing changes, where the site has too many neighbours
bool Relaxation::add_to_batch(std::uint32_t site) {
    constexpr std::size_t kMost = 2 * kMostPairs;
    std::array<std::uint32_t, 2 + 2 * kMost> record;
    std::array<std::uint32_t, kMost> triangles;
    std::uint32_t* around = &record[1];
    std::size_t count = 0;
    std::uint32_t largest = 0;
    const std::uint32_t first = mesh_.edge_of(site);
    std::uint32_t h = first;
    do {
        if (count == kMost || mesh_.crosses_seam(Triangulation::triangle_of(h))) return false;
        largest = std::max(largest, around[count] = mesh_.target(h));
        triangles[count++] = Triangulation::triangle_of(h);
        h = mesh_.twin(Triangulation::previous(h));
    } while (h != first);

    const std::size_t pairs = std::max((count + 1) / 2, kFewestPairs);
    const bool plain = uniform_ && mesh_.is_free(largest);
    record[0] = site;
    for (std::size_t i = count; i <= 2 * pairs; ++i) around[i] = around[0];
    kinds_[site] = kind_of(plain, pairs);
    Batch& batch = batches_[kinds_[site]];
    batch.insert(batch.end(), record.begin(), record.begin() + 2 + 2 * static_cast<std::ptrdiff_t>(pairs));
    if (plain) return true;
    for (std::size_t i = count; i < 2 * pairs; ++i) triangles[i] = static_cast<std::uint32_t>(terms_.size() - 1);
    batch.insert(batch.end(), triangles.begin(), triangles.begin() + 2 * static_cast<std::ptrdiff_t>(pairs));
    return true;
}

void Relaxation::add_fan(std::uint32_t vertex, std::vector<Fan>& fans) {
    Fan fan{vertex, static_cast<std::uint32_t>(fan_vertices_.size()), 0, 0};
    const std::uint32_t first = mesh_.edge_of(vertex);
    std::uint32_t h = first;
    do {
        fan_vertices_.push_back(mesh_.target(h));
        fan_lifts_.push_back(mesh_.distance(mesh_.shift(h)));
        fan_triangles_.push_back(Triangulation::triangle_of(h));
        ++fan.triangles;
        const std::uint32_t last = Triangulation::previous(h);
        h = mesh_.twin(last);
        if (h != Triangulation::kNone) continue;
        fan_vertices_.push_back(mesh_.origin(last));
        fan_lifts_.push_back({});
        fan_triangles_.push_back(Triangulation::kNone);
    } while (h != Triangulation::kNone && h != first);
    fan.neighbours = static_cast<std::uint32_t>(fan_vertices_.size()) - fan.first;
    fans.push_back(fan);
}

void Relaxation::pass() {
    // Block by block: what a block needs stays in the cache from kind to kind.
    for (std::size_t block = 0; block + 1 < block_starts_[0].size(); ++block) {
        move_batch<true, 2>(block);
        move_batch<true, 3>(block);
        move_batch<true, 4>(block);
        move_batch<false, 2>(block);
        move_batch<false, 3>(block);
        move_batch<false, 4>(block);
    }
    for (const Fan& fan : site_fans_) move_site(fan);
    for (const Fan& fan : border_fans_) slide(fan);
}

/// Moves the sites of a batch. Takes them from several places of the block in turn: neighbours in number are neighbours
/// in the plane, and each would have to wait for the one before.
template <bool kPlain, std::size_t kPairs>
void Relaxation::move_batch(std::size_t block) {
    constexpr std::uint8_t kKind = kind_of(kPlain, kPairs);
    constexpr std::size_t kStride = stride(kKind);
    constexpr std::size_t kStreams = 4;
    const std::size_t begin = block_starts_[kKind][block];
    const std::uint32_t* records = batches_[kKind].data() + begin;
    const std::size_t count = (block_starts_[kKind][block + 1] - begin) / kStride;
    const std::size_t length = (count + kStreams - 1) / kStreams;
    for (std::size_t i = 0; i < length; ++i) {
        for (std::size_t at = i; at < count; at += length) move_few<kPlain, kPairs>(records + at * kStride);
    }
}

/// Moves a site as move_site() does, two triangles at a time. A triangle between a neighbour and its repetition is flat
/// and adds nothing. Plain: around a closed ring the sums of a and b vanish, and with them the common target.
template <bool kPlain, std::size_t kPairs>
void Relaxation::move_few(const std::uint32_t* record) {
    const std::uint32_t vertex = record[0];
    const std::uint32_t* around = record + 1;
    const std::uint32_t* triangles = around + 2 * kPairs + 1;
    Point* points = mesh_.points().data();
    const Pair here = load(points[vertex]);

    std::array<Pair, kPairs + 1> x, y;  // of the neighbours, seen from the vertex
    for (std::size_t i = 0; i < kPairs; ++i) {
        const Pair p = load(points[around[2 * i]]) - here;
        const Pair q = load(points[around[2 * i + 1]]) - here;
        x[i] = firsts(p, q);
        y[i] = seconds(p, q);
    }
    x[kPairs] = x[0];
    y[kPairs] = y[0];

    Pair xx{}, xy{}, yy{}, gx{}, gy{}, spring_x{}, spring_y{}, springs{};
    std::array<Pair, kPairs> area, a, b;
    for (std::size_t i = 0; i < kPairs; ++i) {
        const Pair to_x = shifted(x[i], x[i + 1]), to_y = shifted(y[i], y[i + 1]);
        area[i] = x[i] * to_y - y[i] * to_x;
        a[i] = y[i] - to_y;
        b[i] = to_x - x[i];
        if constexpr (kPlain) {
            xx += a[i] * a[i];
            xy += a[i] * b[i];
            yy += b[i] * b[i];
            gx += area[i] * a[i];
            gy += area[i] * b[i];
            spring_x += x[i];
            spring_y += y[i];
        } else {
            const Term &even = terms_[triangles[2 * i]], &odd = terms_[triangles[2 * i + 1]];
            const Pair weight{even.weight, odd.weight}, target{even.target, odd.target};
            const Pair spring{even.spring, odd.spring};
            const Pair wa = weight * a[i], wb = weight * b[i];
            const Pair residual = weight * area[i] - target;
            xx += wa * wa;
            xy += wa * wb;
            yy += wb * wb;
            gx += residual * wa;
            gy += residual * wb;
            spring_x += spring * (x[i] + to_x);
            spring_y += spring * (y[i] + to_y);
            springs += spring;
        }
    }
    double stiffness = 0;  // of all springs together
    Point pull;            // of all springs together
    if constexpr (kPlain) {
        // All terms are over the squared weight. A repetition of the first neighbour must not pull.
        const double spring = options_.spring / plain_weight_;
        const double repeated = around[2 * kPairs - 1] == around[0] ? 1 : 0;
        stiffness = spring * (2 * kPairs - repeated);
        pull = {spring * (sum(spring_x) - repeated * x[0][0]), spring * (sum(spring_y) - repeated * y[0][0])};
    } else {
        stiffness = options_.spring * sum(springs);
        pull = {0.5 * options_.spring * sum(spring_x), 0.5 * options_.spring * sum(spring_y)};
    }
    const Point gradient{sum(gx) - pull.x, sum(gy) - pull.y};
    const Point by =
        fenced(vertex, options_.relaxation * minimum(sum(xx) + stiffness, sum(xy), sum(yy) + stiffness, gradient));

    const Pair move_x{by.x, by.x}, move_y{by.y, by.y};
    const Pair small{small_, small_};
    using Mask = decltype(small < move_x);
    Mask fits{-1, -1};
    for (std::size_t i = 0; i < kPairs; ++i) {
        const Pair moved = area[i] + a[i] * move_x + b[i] * move_y;
        fits &= (area[i] == Pair{}) | ((moved >= kKeptArea * area[i]) & (moved >= small));
    }
    if ((fits[0] & fits[1]) != 0) {
        points[vertex] = rounded(points[vertex] + by);
    } else {
        move(vertex, by, {{around, 2 * kPairs}, nullptr}, 2 * kPairs);
    }
}

Relaxation::Ring Relaxation::ring_of(const Fan& fan) const {
    return {{&fan_vertices_[fan.first], fan.neighbours}, &fan_lifts_[fan.first]};
}

Point Relaxation::place(const Ring& ring, std::size_t i) const {
    const std::size_t at = i < ring.vertices.size() ? i : 0;
    const Point p = mesh_.point(ring.vertices[at]);
    return ring.lifts == nullptr ? p : p + ring.lifts[at];
}

/// Normal equations from the triangles around a vertex.
Relaxation::NormalEquations Relaxation::equations_of(const Fan& fan) const {
    const Ring ring = ring_of(fan);
    const Point v = mesh_.point(fan.vertex);
    NormalEquations equations;
    for (std::uint32_t i = 0; i < fan.triangles; ++i) {
        equations.add(place(ring, i) - v, place(ring, i + 1) - v, terms_[fan_triangles_[fan.first + i]],
                      options_.spring);
    }
    return equations;
}

void Relaxation::move_site(const Fan& fan) {
    const NormalEquations equations = equations_of(fan);
    const Point by = options_.relaxation * minimum(equations.xx, equations.xy, equations.yy, equations.gradient);
    move(fan.vertex, fenced(fan.vertex, by), ring_of(fan), fan.triangles);
}

void Relaxation::slide(const Fan& fan) {
    const std::span<const std::uint32_t> around{&fan_vertices_[fan.first], fan.neighbours};
    const std::uint32_t* triangles = &fan_triangles_[fan.first];
    const Point v = mesh_.point(fan.vertex);
    NormalEquations equations = equations_of(fan);
    equations.add_spring(mesh_.point(around.front()) - v, options_.border_spring * terms_[triangles[0]].spring);
    equations.add_spring(mesh_.point(around.back()) - v,
                         options_.border_spring * terms_[triangles[fan.triangles - 1]].spring);
    const Point along = mesh_.point(around.front()) - mesh_.point(around.back());
    move(fan.vertex, options_.relaxation * equations.minimum_along(along) * along, ring_of(fan), fan.triangles);
}

/// Moves a vertex as far as leaves the first so many triangles around it enough of their area.
void Relaxation::move(std::uint32_t vertex, Point by, const Ring& ring, std::size_t triangles) {
    if (!std::isfinite(by.x) || !std::isfinite(by.y)) return;
    // Around a torus with few sites one may be its own neighbour, and the triangles would move along.
    if (std::ranges::find(ring.vertices, vertex) != ring.vertices.end()) return;
    const Point v = mesh_.point(vertex);
    double share = 1;
    for (std::size_t i = 0; i < triangles; ++i) {
        const Point from = place(ring, i) - v, to = place(ring, i + 1) - v;
        const double area = cross(from, to);
        const double change = (from.y - to.y) * by.x + (to.x - from.x) * by.y;
        const double longest = std::max({dot(from, from), dot(to, to), dot(to - from, to - from)});
        const double least = std::max(kLeastShape * longest, options_.least_height * std::sqrt(longest));
        const double kept = std::min(area, std::max(kKeptArea * area, least));
        if (area + share * change < kept) share = std::max(0.0, (kept - area) / change);
    }
    // Next to flat triangles rounding could still turn one over.
    const Point moved = rounded(v + share * by);
    for (std::size_t i = 0; i < triangles; ++i) {
        const Point from = place(ring, i), to = place(ring, i + 1);
        if (from != to && orientation(moved, from, to) <= 0) return;
    }
    if (share < 1 && options_.fence && mesh_.is_site(vertex) && options_.fence(vertex, moved) != moved) return;
    mesh_.points()[vertex] = moved;
}

void Relaxation::exact_pass(const CapacityIntegral& capacity, const std::stop_token& stop) {
    capacity.of_edges(mesh_, capacities_, sweeps_, stop);
    if (stop.stop_requested()) return;
    const double sites = options_.site_share ? 1 / *options_.site_share : static_cast<double>(mesh_.site_count());
    const double unit = 2 * sites / capacity.total();
    for (std::uint32_t site = 0; site < mesh_.free_count(); ++site) move_exactly(site, unit);
    for (const Fan& fan : border_fans_) slide(fan);
}

/// Moves a site by the true capacities. A triangle (v, from, to) gains what its edge v-from sweeps on its right, and
/// loses what v-to sweeps.
void Relaxation::move_exactly(std::uint32_t site, double unit) {
    ring_vertices_.clear();
    ring_lifts_.clear();
    ring_gradients_.clear();
    NormalEquations equations;
    const std::uint32_t first = mesh_.edge_of(site);
    std::uint32_t h = first;
    do {
        const std::uint32_t triangle = Triangulation::triangle_of(h);
        const std::uint32_t after = mesh_.twin(Triangulation::previous(h));
        const Point from = mesh_.along(h), to = mesh_.along(after);
        const Point gradient{unit * (sweeps_[h] * from.y - sweeps_[after] * to.y),
                             unit * (sweeps_[after] * to.x - sweeps_[h] * from.x)};
        const Term& term = terms_[triangle];
        equations.add(term.scale * gradient, term.scale * unit * capacities_[triangle] - term.target);
        equations.add_springs(from, to, options_.spring * term.spring);
        ring_vertices_.push_back(mesh_.target(h));
        ring_lifts_.push_back(mesh_.distance(mesh_.shift(h)));
        ring_gradients_.push_back(gradient);
        h = after;
    } while (h != first);
    const Point before = mesh_.point(site);
    move(site, fenced(site, minimum(equations.xx, equations.xy, equations.yy, equations.gradient)),
         {ring_vertices_, ring_lifts_.data()}, ring_vertices_.size());
    const Point by = mesh_.point(site) - before;
    for (const Point gradient : ring_gradients_) {
        capacities_[Triangulation::triangle_of(h)] += dot(gradient, by) / unit;
        h = mesh_.twin(Triangulation::previous(h));
    }
}

double Relaxation::energy() const {
    double energy = 0;
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
        const double residual = terms_[t].weight * mesh_.doubled_area(t) - terms_[t].target;
        energy += residual * residual;
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Triangulation::edge(t, i);
            const Point length = mesh_.along(h);
            const bool border = mesh_.twin(h) == Triangulation::kNone;
            const double spring = 0.5 * options_.spring + (border ? options_.border_spring : 0);
            energy += spring * terms_[t].spring * dot(length, length);
        }
    }
    return energy;
}

}  // namespace ccdt
