// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/triangulation.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/geometry/pair.h"
#include "core/geometry/predicates.h"

namespace ccdt {

/// The arguments of insert_all().
struct Triangulation::Batch {
    std::span<const std::uint32_t> sites;
    const Draw& draw;
    int attempts;
    double margin;
    const std::stop_token& stop;
};

void Triangulation::fix_last(std::size_t count) {
    free_ = sites_ - count;
    blocks_ = SiteBlocks(free_);
}

Triangulation::Triangulation(std::size_t sites, const ConstrainedDelaunay& border) : sites_(sites) {
    fix_last(0);
    reserve_triangles(border.triangles.size());
    points_.reserve(sites + border.points.size());
    points_.resize(sites);
    points_.insert(points_.end(), border.points.begin(), border.points.end());
    const std::uint32_t first = whole_.last = border_triangle();
    for (const auto& given : border.triangles) {
        Triangle& triangle = triangles_.emplace_back();
        for (std::uint32_t i = 0; i < 3; ++i) {
            triangle.set_constrained(i, given.constrained[i]);
            triangle.corners[i] = static_cast<std::uint32_t>(sites + given.corners[i]);
            const std::uint32_t neighbour = given.neighbours[i];
            if (neighbour == ConstrainedDelaunay::kNone) continue;
            // The shared edge of the neighbour begins where this edge ends.
            const auto& other = border.triangles[neighbour].corners;
            const std::uint32_t end = given.corners[(i + 1) % 3];
            triangle.twins[i] = edge(first + neighbour, other[0] == end ? 0 : other[1] == end ? 1 : 2);
        }
    }
    mark_inside();
    separate(border.branches);
    mark_parts();
}

Triangulation::Triangulation(std::size_t sites, Point period)
    : sites_(sites), period_(period), points_(sites), part_of_(sites, 0), part_count_(1) {
    fix_last(0);
    reserve_triangles(0);
}

/// Reserves memory for two triangles per site and for the triangles of the border.
void Triangulation::reserve_triangles(std::size_t border) {
    Triangle unused;
    unused.flags = kOutside;
    triangles_.reserve(2 * sites_ + border);
    triangles_.resize(2 * sites_, unused);
}

/// Marks triangles outside the domain, by a flood fill. It starts from the triangles at the box, which are outside, and
/// changes sides at each segment.
void Triangulation::mark_inside() {
    std::vector<bool> seen(triangle_count(), false);
    std::vector<std::uint32_t> stack;
    const auto at_box = [](const Triangle& t) {
        return std::find(t.twins.begin(), t.twins.end(), kNone) != t.twins.end();
    };
    const auto border = triangles_.begin() + border_triangle();
    stack.push_back(static_cast<std::uint32_t>(std::find_if(border, triangles_.end(), at_box) - triangles_.begin()));
    seen[stack.front()] = true;
    triangles_[stack.front()].flags |= kOutside;
    while (!stack.empty()) {
        const Triangle& triangle = triangles_[stack.back()];
        stack.pop_back();
        for (std::uint32_t i = 0; i < 3; ++i) {
            if (triangle.twins[i] == kNone || seen[triangle_of(triangle.twins[i])]) continue;
            const std::uint32_t other = triangle_of(triangle.twins[i]);
            seen[other] = true;
            if (triangle.is_inside() == triangle.is_constrained(i)) triangles_[other].flags |= kOutside;
            stack.push_back(other);
        }
    }
}

/// Gives each fan of triangles its own vertex, where several segments begin at the same place. The vertex is the input
/// point at which a segment begins that has the fan on its left.
void Triangulation::separate(std::span<const ConstrainedDelaunay::Branch> branches) {
    if (branches.empty()) return;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> fans;  // first edge, vertex
    for (std::uint32_t t = 0; t < triangle_count(); ++t) {
        const Triangle& triangle = triangles_[t];
        for (std::uint32_t i = 0; i < 3; ++i) {
            if (!triangle.is_inside() || !triangle.is_constrained(i)) continue;
            const auto first = static_cast<std::uint32_t>(sites_);
            const Segment vertices{triangle.corners[i] - first, triangle.corners[(i + 1) % 3] - first};
            const auto at = std::ranges::lower_bound(branches, vertices, {}, &ConstrainedDelaunay::Branch::vertices);
            if (at != branches.end() && at->vertices == vertices) fans.emplace_back(edge(t, i), first + at->point);
        }
    }
    for (const auto& [begin, vertex] : fans) {
        for (std::uint32_t h = begin;; h = twin(previous(h))) {
            triangles_[triangle_of(h)].corners[h % 4] = vertex;
            if (is_constrained(previous(h))) break;
        }
    }
}

/// Numbers the connected parts of the inside and assigns the numbers to their vertices.
void Triangulation::mark_parts() {
    part_of_.assign(points_.size(), kNone);
    std::vector<bool> seen(triangle_count(), false);
    std::vector<std::uint32_t> stack;
    for (std::uint32_t first = 0; first < triangle_count(); ++first) {
        if (seen[first] || !triangles_[first].is_inside()) continue;
        const auto part = static_cast<std::uint32_t>(part_count_++);
        stack.push_back(first);
        seen[first] = true;
        while (!stack.empty()) {
            const Triangle& triangle = triangles_[stack.back()];
            stack.pop_back();
            for (std::uint32_t i = 0; i < 3; ++i) {
                part_of_[triangle.corners[i]] = part;
                const std::uint32_t other = triangle_of(triangle.twins[i]);
                if (triangle.is_constrained(i) || seen[other]) continue;
                seen[other] = true;
                stack.push_back(other);
            }
        }
    }
}

std::uint32_t Triangulation::part_at(Point p) {
    Location at{whole_.last, p, {}};
    locate(whole_, at);
    whole_.last = at.triangle;
    return triangles_[at.triangle].is_inside() ? part_of_[triangles_[at.triangle].corners[0]] : kNone;
}

/// Walks towards a place. Each step crosses an edge that has the place on its right. The edge tried first varies from
/// step to step, so that the walk cannot cycle where the triangulation is not Delaunay.
/// @param at  start of the walk on entry, its end on return
/// @returns   false if the walk left the region
bool Triangulation::locate(const Region& region, Location& at) const {
    const Point p = at.point - distance(at.shift);
    std::uint32_t entered = kNone;
    for (std::uint32_t step = 0;; ++step) {
        std::uint32_t h = edge(at.triangle, (step * 0x9e3779b9u >> 16) % 3);
        const auto places = this->places(at.triangle);
        std::uint32_t crossed = kNone;
        for (int i = 0; i < 3 && crossed == kNone; ++i, h = next(h)) {
            if (h == entered || twin(h) == kNone) continue;
            if (orientation(places[h % 4], places[next(h) % 4], at.point) < 0) crossed = h;
        }
        if (crossed == kNone) return true;
        entered = twin(crossed);
        at.triangle = triangle_of(entered);
        if (is_torus()) {
            at.shift = at.shift + lift(entered) - lift(next(crossed));
            at.point = p + distance(at.shift);
        }
        if (!region.has(origin(previous(entered)))) return false;
    }
}

/// Returns the start of a walk to a place: the given triangle, and the periodic copy of the place that is nearest to
/// the triangle.
Triangulation::Location Triangulation::way_from(std::uint32_t triangle, Point p) const {
    if (!is_torus()) return {triangle, p, {}};
    const auto periods = [](double way, double period) { return static_cast<std::int8_t>(whole(way / period + 0.5)); };
    const Point way = points_[triangles_[triangle].corners[0]] - p;
    const Shift shift{periods(way.x, period_.x), periods(way.y, period_.y)};
    return {triangle, p + distance(shift), shift};
}

void Triangulation::join(std::uint32_t edge, std::uint32_t twin) {
    set_twin(edge, twin);
    if (twin != kNone) set_twin(twin, edge);
}

/// Creates the two triangles formed by a single vertex and its periodic copies.
void Triangulation::insert_first(std::uint32_t site, Point p) {
    points_[site] = p;
    const std::uint32_t below = 2 * site, above = below + 1;
    triangles_[below] = triangles_[above] = {};
    triangles_[below].corners = triangles_[above].corners = {site, site, site};
    triangles_[below].set_shifts({1, 0}, {0, 1}, {-1, -1});
    triangles_[above].set_shifts({1, 1}, {-1, 0}, {0, -1});
    join(edge(below, 0), edge(above, 1));
    join(edge(below, 1), edge(above, 2));
    join(edge(below, 2), edge(above, 0));
}

bool Triangulation::insert(std::uint32_t site, Point p, double margin) {
    Pending pending;
    return insert(whole_, site, p, margin, pending) == Insertion::Done;
}

/// Inserts a site if its place, and all triangles that the insertion changes, lie within a region.
Triangulation::Insertion Triangulation::insert(Region& region, std::uint32_t site, Point p, double margin,
                                               Pending& pending) {
    if (is_torus()) p = snapped(p);
    if (region.last == kNone) {
        insert_first(site, p);
        region.last = 2 * site;
        return Insertion::Done;
    }
    const std::uint32_t start = pending.triangle == kNone ? region.last : pending.triangle;
    const auto has = [&](std::uint32_t vertex) { return region.has(vertex); };
    if (!std::ranges::all_of(triangles_[start].corners, has)) return Insertion::Elsewhere;
    Location at = way_from(start, p);
    if (!locate(region, at)) {
        pending.triangle = at.triangle;
        return Insertion::Elsewhere;
    }
    const std::uint32_t t = region.last = at.triangle;
    const Triangle split = triangles_[t];
    if (!split.is_inside()) return Insertion::Refused;
    const auto places = this->places(t);
    for (std::uint32_t i = 0; i < 3; ++i) {
        if (places[i] == at.point) return Insertion::Refused;
        if (!split.is_constrained(i)) continue;
        const Point a = places[i], b = places[(i + 1) % 3];
        if (orientation(a, b, p) <= 0 || cross(b - a, p - a) < margin * std::sqrt(dot(b - a, b - a)))
            return Insertion::Refused;
    }

    points_[site] = p;
    part_of_[site] = part_of_[split.corners[0]];
    const std::uint32_t u = 2 * site, v = u + 1;
    divide(site, at, u, v);
    region.stack.insert(region.stack.end(), {edge(t, 0), edge(u, 0), edge(v, 0)});
    legalise(region);
    return Insertion::Done;
}

/// Splits a triangle into three at a site.
/// @param at    the triangle, and the site relative to it
/// @param u, v  unused triangles
void Triangulation::divide(std::uint32_t site, const Location& at, std::uint32_t u, std::uint32_t v) {
    // Triangle t becomes (c0, c1, p). If p lies on an edge, one of the three triangles is flat. Its circumcircle is a
    // half-plane that contains the corner beyond the edge, so the edge is flipped.
    const std::uint32_t t = at.triangle;
    const Triangle split = triangles_[t];
    const auto& c = split.corners;
    triangles_[u] = triangles_[v] = {};
    triangles_[u].corners = {c[1], c[2], site};
    triangles_[v].corners = {c[2], c[0], site};
    if (is_torus()) {
        const Shift first = at.shift, second = at.shift - lift(edge(t, 1)), third = at.shift - lift(edge(t, 2));
        triangles_[u].set_shifts(split.shifts[1], third, Shift{} - second);
        triangles_[v].set_shifts(split.shifts[2], first, Shift{} - third);
        triangles_[t].set_shifts(split.shifts[0], second, Shift{} - first);
    }
    triangles_[t].corners[2] = site;
    triangles_[u].set_constrained(0, split.is_constrained(1));
    triangles_[v].set_constrained(0, split.is_constrained(2));
    triangles_[t].set_constrained(1, false);
    triangles_[t].set_constrained(2, false);
    join(edge(u, 0), split.twins[1]);
    join(edge(v, 0), split.twins[2]);
    join(edge(t, 1), edge(u, 2));
    join(edge(u, 1), edge(v, 2));
    join(edge(v, 1), edge(t, 2));
}

/// Processes all regions of a level in parallel. Then does the same with the regions of the next level, which inherit
/// the unfinished work.
/// @returns  the last region
template <class Work>
Triangulation::Region Triangulation::work_upwards(Regions regions, Work&& work) {
    for (std::size_t level = 0;; ++level) {
        std::vector<Region>& small = regions.levels[level];
        executor_->run(small.size(), [&](std::size_t number) { work(small[number]); });
        if (level + 1 == regions.levels.size()) return std::move(small.front());
        std::vector<Region>& large = regions.levels[level + 1];
        for (std::size_t number = 0; number < small.size(); ++number) {
            Region &from = small[number], &to = large[large.size() == 1 ? 0 : number / 4];
            if (to.last == kNone) to.last = from.last;
            to.stack.insert(to.stack.end(), from.edges.begin(), from.edges.end());
            to.sites.insert(to.sites.end(), from.sites.begin(), from.sites.end());
            to.flips += from.flips;
        }
        small = {};
    }
}

/// Creates the regions of all levels, starting with the first level whose blocks have at least `sites` sites.
Triangulation::Regions Triangulation::make_regions(std::size_t sites) const {
    Regions regions;
    while (regions.first_level < blocks_.last_level() && blocks_.sites() / blocks_.count(regions.first_level) < sites)
        ++regions.first_level;
    for (int level = regions.first_level; level < blocks_.last_level(); ++level) {
        auto& blocks = regions.levels.emplace_back(blocks_.count(level));
        const std::size_t of_each = blocks_.count(0) / blocks.size();
        for (std::size_t number = 0; number < blocks.size(); ++number) {
            blocks[number].first = blocks_.begin(number * of_each);
            blocks[number].size = blocks_.begin((number + 1) * of_each) - blocks[number].first;
        }
    }
    regions.levels.emplace_back(1);
    return regions;
}

/// Returns the region responsible for a block.
Triangulation::Region& Triangulation::Regions::of(SiteBlocks::Block block) {
    const int higher = std::max(0, first_level - block.level);
    const auto level = static_cast<std::size_t>(block.level + higher - first_level);
    return level + 1 >= levels.size() ? levels.back().front() : levels[level][block.number >> 2 * higher];
}

std::vector<std::uint32_t> Triangulation::insert_all(std::span<const std::uint32_t> sites, const Draw& draw,
                                                     int attempts, double margin, const std::stop_token& stop) {
    constexpr std::size_t kSeen = 64;      // triangles sampled per block, to find one inside each block
    constexpr std::size_t kPresent = 384;  // with fewer sites, too little of a block lies inside its rim
    if (sites.empty()) return {};
    auto regions = make_regions(kPresent * blocks_.sites() / std::max(sites.size(), kPresent));
    const std::size_t stride = std::max<std::size_t>(1, triangle_count() / (kSeen * blocks_.count(0)));
    for (std::size_t i = 0; i < triangle_count(); i += stride) {
        const auto t = static_cast<std::uint32_t>(i);
        const auto& c = triangles_[t].corners;
        if (triangles_[t].is_inside()) regions.of(blocks_.around({c[0], c[1], c[2]})).last = t;
    }
    regions.levels.back().front().last = whole_.last;
    for (std::uint32_t i = 0; i < sites.size(); ++i) regions.of({0, blocks_.of(sites[i])}).sites.push_back({i, kNone});
    const Batch batch{sites, draw, attempts, margin, stop};
    Region whole = work_upwards(std::move(regions), [&](Region& region) { insert_in(region, batch); });
    whole_.last = whole.last;
    std::vector<std::uint32_t> left;
    for (const Pending& pending : whole.sites) left.push_back(sites[pending.number]);
    return left;
}

/// Inserts those sites of a batch that lie within a region.
void Triangulation::insert_in(Region& region, const Batch& batch) {
    constexpr std::size_t kStopStride = 4096;
    legalise(region);
    if (region.last == kNone && !region.is_whole()) return;
    std::vector<Pending> left;
    for (std::size_t i = 0; i < region.sites.size(); ++i) {
        if (i % kStopStride == 0 && batch.stop.stop_requested()) return;
        Pending& pending = region.sites[i];
        const std::uint32_t site = batch.sites[pending.number];
        auto done = Insertion::Refused;
        for (int attempt = 0; attempt < batch.attempts && done == Insertion::Refused; ++attempt)
            done = insert(region, site, batch.draw(site, attempt), batch.margin, pending);
        if (done != Insertion::Done) left.push_back(pending);
    }
    region.sites = std::move(left);
}

bool Triangulation::wants_flip(std::uint32_t edge) const {
    const std::uint32_t twin = this->twin(edge);
    const Point beyond = points_[origin(previous(twin))];
    const auto [a, b, c] = places(triangle_of(edge));
    if (!crosses_seam(triangle_of(edge)) && !crosses_seam(triangle_of(twin))) return in_circle(a, b, c, beyond);
    return in_circle(a, b, c, beyond + distance(lift(edge) + shift(next(twin))));
}

/// Whether two edges are certainly both Delaunay. Applies the floating-point filter of in_circle() to both edges at
/// once.
bool Triangulation::is_certain(std::uint32_t edge, std::uint32_t other) const {
    if (twin(edge) == kNone || twin(other) == kNone) return false;
    if (is_torus() && (crosses_seam(triangle_of(edge)) || crosses_seam(triangle_of(other)) ||
                       crosses_seam(triangle_of(twin(edge))) || crosses_seam(triangle_of(twin(other))))) {
        return false;
    }
    const auto& p = triangles_[triangle_of(edge)].corners;
    const auto& q = triangles_[triangle_of(other)].corners;
    const Pair p3 = load(points_[origin(previous(twin(edge)))]), q3 = load(points_[origin(previous(twin(other)))]);
    const Pair pa = load(points_[p[0]]) - p3, pb = load(points_[p[1]]) - p3, pc = load(points_[p[2]]) - p3;
    const Pair qa = load(points_[q[0]]) - q3, qb = load(points_[q[1]]) - q3, qc = load(points_[q[2]]) - q3;
    const Pair ax = firsts(pa, qa), bx = firsts(pb, qb), cx = firsts(pc, qc);
    const Pair ay = seconds(pa, qa), by = seconds(pb, qb), cy = seconds(pc, qc);
    const Pair bc1 = bx * cy, bc2 = cx * by, ca1 = cx * ay, ca2 = ax * cy, ab1 = ax * by, ab2 = bx * ay;
    const Pair a2 = ax * ax + ay * ay, b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    const Pair det = a2 * (bc1 - bc2) + b2 * (ca1 - ca2) + c2 * (ab1 - ab2);
    const Pair permanent = (magnitude(bc1) + magnitude(bc2)) * a2 + (magnitude(ca1) + magnitude(ca2)) * b2 +
                           (magnitude(ab1) + magnitude(ab2)) * c2;
    const auto certain = det < -kInCircleBound * permanent;
    return (certain[0] & certain[1]) != 0;
}

/// Replaces the edge a-b of triangles (a, b, c) and (b, a, d) by d-c of (a, d, c) and (b, c, d).
void Triangulation::flip(std::uint32_t edge) {
    const std::uint32_t twin = this->twin(edge);
    const std::uint32_t edge_next = next(edge), twin_next = next(twin);
    const std::uint32_t c = origin(previous(edge)), d = origin(previous(twin));
    set_constrained(edge, is_constrained(twin_next));
    set_constrained(twin, is_constrained(edge_next));
    set_constrained(edge_next, false);
    set_constrained(twin_next, false);
    if (!changed_.empty()) {
        for (const std::uint32_t vertex : {origin(edge), origin(twin), c, d}) changed_[vertex] = 1;
    }
    if (crosses_seam(triangle_of(edge)) || crosses_seam(triangle_of(twin))) flip_shifts(edge);
    if (this->twin(twin_next) == edge_next) {
        join(edge, twin);  // a parallelogram around the torus with two sides joined
    } else {
        join(edge, this->twin(twin_next));
        join(twin, this->twin(edge_next));
    }
    join(edge_next, twin_next);
    triangles_[triangle_of(edge)].corners[edge_next % 4] = d;
    triangles_[triangle_of(twin)].corners[twin_next % 4] = c;
    if (edge_of_.empty()) return;
    for (const std::uint32_t triangle : {triangle_of(edge), triangle_of(twin)}) {
        for (std::uint32_t i = 0; i < 3; ++i) keep_edge(Triangulation::edge(triangle, i));
    }
}

void Triangulation::flip_shifts(std::uint32_t edge) {
    const std::uint32_t twin = this->twin(edge);
    const auto shift_of = [&](std::uint32_t h) { return shift(h); };
    const Shift ad = shift_of(next(twin)), bc = shift_of(next(edge));
    const Shift ca = shift_of(previous(edge)), db = shift_of(previous(twin));
    const auto set = [&](std::uint32_t h, Shift first, Shift second, Shift third) {
        std::array<Shift, 3> shifts;
        shifts[h % 4] = first;
        shifts[next(h) % 4] = second;
        shifts[previous(h) % 4] = third;
        triangles_[triangle_of(h)].set_shifts(shifts[0], shifts[1], shifts[2]);
    };
    set(edge, ad, Shift{} - ca - ad, ca);  // (a, d, c)
    set(twin, bc, ca + ad, db);            // (b, c, d)
}

/// Flips edges of a region until all edges are Delaunay. Edges with a vertex in another region are left for a larger
/// region.
void Triangulation::legalise(Region& region) {
    while (!region.stack.empty()) {
        const std::uint32_t h = region.stack.back();
        region.stack.pop_back();
        const std::uint32_t twin = this->twin(h);
        if (twin == kNone || is_constrained(h)) continue;
        if (!region.has(origin(previous(twin)))) {
            region.edges.push_back(h);
            continue;
        }
        if (!wants_flip(h)) continue;
        flip(h);
        ++region.flips;
        region.stack.insert(region.stack.end(), {h, previous(h), twin, previous(twin)});
    }
}

void Triangulation::wrap() {
    constexpr double kMargin = 0.25;  // in periods; keeps sites near the seam from wrapping back and forth
    constexpr std::size_t kRange = 16384;
    const auto periods = [](double place, double period) {
        const double share = place / period;
        return static_cast<std::int8_t>(share < -kMargin || share >= 1 + kMargin ? whole(share) : 0);
    };
    std::vector<Shift> left(points_.size());
    std::atomic<bool> any = false;
    for_ranges(*executor_, points_.size(), kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            left[v] = {periods(points_[v].x, period_.x), periods(points_[v].y, period_.y)};
            if (left[v] == Shift{}) continue;
            points_[v] = points_[v] - distance(left[v]);
            any = true;
        }
    });
    if (!any) return;
    for (Triangle& triangle : triangles_) {
        const auto& [a, b, c] = triangle.corners;
        const auto shifts = triangle.shifts;
        triangle.set_shifts(shifts[0] + left[b] - left[a], shifts[1] + left[c] - left[b],
                            shifts[2] + left[a] - left[c]);
        if (triangle.shifts == shifts) continue;
        for (const std::uint32_t corner : triangle.corners) changed_[corner] = 1;
    }
}

/// Lists the edges of triangles [begin, end) that need a flip. Each edge is given by its half-edge with the smaller
/// number.
void Triangulation::find_flips(std::size_t begin, std::size_t end, std::vector<Flip>& found) const {
    // Branchless, since the outcome is unpredictable.
    std::vector<std::uint32_t> edges(3 * (end - begin) + 1);
    std::size_t count = 0;
    for (std::size_t t = begin; t < end; ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = edge(static_cast<std::uint32_t>(t), i), twin = triangles_[t].twins[i];
            edges[count] = h;
            count += static_cast<std::size_t>(twin != kNone) & static_cast<std::size_t>(twin > h);
        }
    }
    if (count % 2 != 0) edges[count] = edges[count - 1];
    for (std::size_t i = 0; i < count; i += 2) {
        if (is_certain(edges[i], edges[i + 1])) continue;
        for (std::size_t k = i; k < std::min(i + 2, count); ++k) {
            if (!wants_flip(edges[k])) continue;
            const auto& c = triangles_[triangle_of(edges[k])].corners;
            const std::uint32_t beyond = origin(previous(twin(edges[k])));
            found.push_back({edges[k], blocks_.around({c[0], c[1], c[2], beyond})});
        }
    }
}

std::size_t Triangulation::restore_delaunay(const std::stop_token& stop) {
    constexpr std::size_t kRange = 8192;
    changed_.assign(points_.size(), 0);
    if (is_torus()) wrap();
    std::vector<std::vector<Flip>> found((triangle_count() + kRange - 1) / kRange);
    for_ranges(*executor_, triangle_count(), kRange, [&](std::size_t begin, std::size_t end) {
        if (!stop.stop_requested()) find_flips(begin, end, found[begin / kRange]);
    });
    if (stop.stop_requested()) return 0;
    auto regions = make_regions(1);
    for (const auto& flips : found) {
        for (const Flip& flip : flips) regions.of(flip.block).stack.push_back(flip.edge);
    }
    return work_upwards(std::move(regions), [this](Region& region) { legalise(region); }).flips;
}

/// Lists the half-edges that leave a site, counter-clockwise.
std::vector<std::uint32_t> Triangulation::edges_around(std::uint32_t site) const {
    std::vector<std::uint32_t> edges;
    std::uint32_t h = edge_of_[site];
    do {
        edges.push_back(h);
        h = twin(previous(h));
    } while (h != edge_of_[site]);
    return edges;
}

/// Flips edges away from a site until its degree is three.
/// @returns  false if the degree stays higher because no other edge can be flipped
bool Triangulation::isolate(std::uint32_t site) {
    // An edge can be flipped if both new triangles are counter-clockwise.
    const auto can_turn = [&](std::uint32_t h) {
        const Point here = points_[site], there = points_[target(h)];
        const Point left = points_[origin(previous(h))], right = points_[origin(previous(twin(h)))];
        return orientation(here, right, left) > 0 && orientation(there, left, right) > 0;
    };
    for (auto edges = edges_around(site); edges.size() > 3; edges = edges_around(site)) {
        const auto turned = std::ranges::find_if(edges, can_turn);
        if (turned == edges.end()) return false;
        flip(*turned);
    }
    return true;
}

/// Whether a place lies inside a triangle or on its edges; not for a torus.
bool Triangulation::is_within(std::uint32_t triangle, Point p) const {
    const auto [a, b, c] = places(triangle);
    return orientation(a, b, p) >= 0 && orientation(b, c, p) >= 0 && orientation(c, a, p) >= 0;
}

bool Triangulation::relocate(std::uint32_t site, std::uint32_t triangle, Point p) {
    std::vector<std::uint32_t> touched;  // triangles
    for (const std::uint32_t h : edges_around(site)) touched.push_back(triangle_of(h));
    const bool isolated = isolate(site);
    if (isolated) {
        // The three triangles around the site are merged into one. The two free triangles then divide the triangle at
        // the new place.
        const auto edges = edges_around(site);
        const std::uint32_t h = edges[0], kept = triangle_of(h), u = triangle_of(edges[1]), v = triangle_of(edges[2]);
        triangles_[kept].corners[h % 4] = target(edges[2]);
        join(h, twin(next(edges[2])));
        join(previous(h), twin(next(edges[1])));
        points_[site] = p;
        if (std::ranges::find(touched, triangle) != touched.end()) {
            // The merge has changed the triangles here. So the triangle that contains the place is looked up again.
            triangle =
                *std::ranges::find_if(touched, [&](std::uint32_t t) { return t != u && t != v && is_within(t, p); });
        }
        if (!part_of_.empty()) part_of_[site] = part_of_[triangles_[triangle].corners[0]];
        divide(site, {triangle, p, {}}, u, v);
        touched.push_back(triangle);
    }
    for (const std::uint32_t t : touched) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            keep_edge(edge(t, i));
            whole_.stack.push_back(edge(t, i));
        }
    }
    legalise(whole_);
    return isolated;
}

std::vector<std::array<Point, 3>> Triangulation::inside_triangles(std::uint32_t part) const {
    std::vector<std::array<Point, 3>> inside;
    for (std::uint32_t t = 0; t < triangle_count(); ++t) {
        if (!triangles_[t].is_inside()) continue;
        if (part == kNone || part_of_[triangles_[t].corners[0]] == part) inside.push_back(places(t));
    }
    return inside;
}

void Triangulation::trim() {
    constexpr std::size_t kRange = 16384;
    for_ranges(*executor_, triangle_count(), kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            for (std::uint32_t i = 0; i < 3; ++i) {
                if (triangles_[t].is_constrained(i)) triangles_[t].twins[i] = kNone;
            }
            triangles_[t].flags &= static_cast<std::uint8_t>(~kConstrained);
        }
    });
    drop_outside();
    if (!is_torus()) points_.resize(points_.size() - 4);  // the corners of the box
    part_of_.resize(points_.size());
    if (part_count_ == 1) part_of_ = std::vector<std::uint32_t>();
    number_along_sites();
    find_edges();
    changed_.assign(points_.size(), 0);
}

/// Drops triangles outside the domain. All triangles of sites lie inside, so only triangles of the border are
/// renumbered.
void Triangulation::drop_outside() {
    std::uint32_t next = border_triangle();
    for (std::uint32_t t = next; t < triangle_count(); ++t) {
        if (!triangles_[t].is_inside()) continue;
        triangles_[next] = triangles_[t];
        for (std::uint32_t i = 0; i < 3; ++i) join(edge(next, i), triangles_[t].twins[i]);
        ++next;
    }
    triangles_.resize(next);
}

/// Sorts triangles by their first vertex, so that neighbours in the plane are neighbours in memory.
void Triangulation::number_along_sites() {
    constexpr std::size_t kRange = 8192;
    const std::size_t count = triangle_count();
    const auto first_of = [&](std::size_t t) { return std::ranges::min(triangles_[t].corners); };
    // End of each vertex' triangles in the new order.
    std::vector<std::uint32_t> ends(points_.size() + 1, 0);
    for_ranges(*executor_, count, kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t)
            std::atomic_ref(ends[first_of(t) + 1]).fetch_add(1, std::memory_order_relaxed);
    });
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    std::vector<std::uint32_t> order(count), number(count);
    for_ranges(*executor_, count, kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t)
            order[std::atomic_ref(ends[first_of(t)]).fetch_add(1, std::memory_order_relaxed)] =
                static_cast<std::uint32_t>(t);
    });
    for_ranges(*executor_, points_.size(), kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const std::uint32_t first = v == 0 ? 0 : ends[v - 1];
            // Before this sort, the order of the vertex' triangles depends on the schedule of the tasks.
            std::sort(order.begin() + first, order.begin() + ends[v]);
            for (std::uint32_t i = first; i < ends[v]; ++i) number[order[i]] = i;
        }
    });
    std::vector<Triangle> sorted(count);
    for_ranges(*executor_, count, kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            sorted[i] = triangles_[order[i]];
            for (std::uint32_t& twin : sorted[i].twins) {
                if (twin != kNone) twin = edge(number[triangle_of(twin)], twin % 4);
            }
        }
    });
    triangles_ = std::move(sorted);
}

void Triangulation::find_edges() {
    edge_of_.resize(points_.size());
    for (std::uint32_t t = 0; t < triangle_count(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) keep_edge(edge(t, i));
    }
}

/// Sets the stored edge of its origin to this edge. Changes a vertex of the border only if the edge lies on the border.
void Triangulation::keep_edge(std::uint32_t edge) {
    const std::uint32_t vertex = origin(edge);
    if (is_site(vertex) || twin(edge) == kNone) edge_of_[vertex] = edge;
}

}  // namespace ccdt
