#include "core/mesh/triangulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/pair.h"
#include "core/geometry/predicates.h"

namespace ccdt {

Triangulation::Triangulation(std::size_t sites, const ConstrainedDelaunay& border) : sites_(sites) {
    points_.resize(sites);
    points_.insert(points_.end(), border.points.begin(), border.points.end());
    triangles_.reserve(border.triangles.size() + 2 * sites);
    for (const auto& given : border.triangles) {
        Triangle& triangle = triangles_.emplace_back();
        for (std::uint32_t i = 0; i < 3; ++i) {
            triangle.set_constrained(i, given.constrained[i]);
            triangle.corners[i] = static_cast<std::uint32_t>(sites + given.corners[i]);
            const std::uint32_t neighbour = given.neighbours[i];
            if (neighbour == ConstrainedDelaunay::kNone) continue;
            // The neighbour's edge that begins where ours ends is the one we share.
            const auto& other = border.triangles[neighbour].corners;
            const std::uint32_t end = given.corners[(i + 1) % 3];
            triangle.twins[i] = edge(neighbour, other[0] == end ? 0 : other[1] == end ? 1 : 2);
        }
    }
    mark_inside();
    separate(border.branches);
    mark_parts();
}

Triangulation::Triangulation(std::size_t sites, Point period)
    : sites_(sites), period_(period), points_(sites), part_of_(sites, 0), part_count_(1) {
    triangles_.reserve(2 * sites);
}

/// Crossing a segment changes sides: fills inwards from the box, whose triangles are outside.
void Triangulation::mark_inside() {
    std::vector<bool> seen(triangle_count(), false);
    std::vector<std::uint32_t> stack;
    const auto at_box = [](const Triangle& t) {
        return std::find(t.twins.begin(), t.twins.end(), kNone) != t.twins.end();
    };
    const auto first = std::find_if(triangles_.begin(), triangles_.end(), at_box) - triangles_.begin();
    stack.push_back(static_cast<std::uint32_t>(first));
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

/// Where several segments begin in one place, so do several fans of triangles inside: each gets the point that its own
/// segment, the one that has it on its left, begins at.
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

/// Numbers the parts of the inside and gives their vertices the number.
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
    last_ = locate(p).triangle;
    return triangles_[last_].is_inside() ? part_of_[triangles_[last_].corners[0]] : kNone;
}

/// Walks towards p across edges that have it on their right. The first edge looked at changes from step to step, so
/// that the walk cannot circle for ever where the triangulation is not Delaunay.
Triangulation::Location Triangulation::locate(Point p) const {
    Location at{last_, p, {}};
    std::uint32_t entered = kNone;
    for (std::uint32_t step = 0;; ++step) {
        std::uint32_t h = edge(at.triangle, (step * 0x9e3779b9u >> 16) % 3);
        const auto places = this->places(at.triangle);
        std::uint32_t crossed = kNone;
        for (int i = 0; i < 3 && crossed == kNone; ++i, h = next(h)) {
            if (h == entered || twin(h) == kNone) continue;
            if (orientation(places[h % 4], places[next(h) % 4], at.point) < 0) crossed = h;
        }
        if (crossed == kNone) return at;
        entered = twin(crossed);
        at.triangle = triangle_of(entered);
        if (!is_torus()) continue;
        at.shift = at.shift + lift(entered) - lift(next(crossed));
        at.point = p + distance(at.shift);
    }
}

std::uint32_t Triangulation::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const auto number = static_cast<std::uint32_t>(triangles_.size());
    triangles_.emplace_back().corners = {a, b, c};
    return number;
}

void Triangulation::join(std::uint32_t edge, std::uint32_t twin) {
    set_twin(edge, twin);
    if (twin != kNone) set_twin(twin, edge);
}

/// The two triangles that a single vertex and its copies make.
bool Triangulation::insert_first(std::uint32_t site, Point p) {
    points_[site] = p;
    const std::uint32_t below = add_triangle(site, site, site), above = add_triangle(site, site, site);
    triangles_[below].set_shifts({1, 0}, {0, 1}, {-1, -1});
    triangles_[above].set_shifts({1, 1}, {-1, 0}, {0, -1});
    join(edge(below, 0), edge(above, 1));
    join(edge(below, 1), edge(above, 2));
    join(edge(below, 2), edge(above, 0));
    return true;
}

bool Triangulation::insert(std::uint32_t site, Point p, double margin) {
    if (is_torus()) p = snapped(p);
    if (triangles_.empty()) return insert_first(site, p);
    const Location at = locate(p);
    const std::uint32_t t = last_ = at.triangle;
    const Triangle split = triangles_[t];
    if (!split.is_inside()) return false;
    const auto& c = split.corners;
    const auto places = this->places(t);
    for (std::uint32_t i = 0; i < 3; ++i) {
        if (places[i] == at.point) return false;
        if (!split.is_constrained(i)) continue;
        const Point a = places[i], b = places[(i + 1) % 3];
        if (orientation(a, b, p) <= 0 || cross(b - a, p - a) < margin * std::sqrt(dot(b - a, b - a))) return false;
    }

    // Split into three: (c0, c1, p) stays at t. Where p lies on an edge, one of them is flat; that edge then has the
    // corner beyond it in its circle, a half-plane, and is flipped away.
    points_[site] = p;
    part_of_[site] = part_of_[c[0]];
    const std::uint32_t u = add_triangle(c[1], c[2], site);
    const std::uint32_t v = add_triangle(c[2], c[0], site);
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
    stack_.insert(stack_.end(), {edge(t, 0), edge(u, 0), edge(v, 0)});
    legalise();
    return true;
}

bool Triangulation::wants_flip(std::uint32_t edge) const {
    const std::uint32_t twin = this->twin(edge);
    const Point beyond = points_[origin(previous(twin))];
    const auto [a, b, c] = places(triangle_of(edge));
    if (!crosses_seam(triangle_of(edge)) && !crosses_seam(triangle_of(twin))) return in_circle(a, b, c, beyond);
    return in_circle(a, b, c, beyond + distance(lift(edge) + shift(next(twin))));
}

/// Tells whether two edges are both Delaunay beyond doubt; what in_circle() computes first, for both at once.
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

/// Turns the edge a-b of triangles (a, b, c) and (b, a, d) into d-c of (a, d, c) and (b, c, d).
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
    if (is_torus()) flip_shifts(edge);
    if (this->twin(twin_next) == edge_next) {
        join(edge, twin);  // a parallelogram whose sides are joined, around the torus
    } else {
        join(edge, this->twin(twin_next));
        join(twin, this->twin(edge_next));
    }
    join(edge_next, twin_next);
    triangles_[triangle_of(edge)].corners[edge_next % 4] = d;
    triangles_[triangle_of(twin)].corners[twin_next % 4] = c;
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

std::size_t Triangulation::legalise() {
    std::size_t flips = 0;
    while (!stack_.empty()) {
        const std::uint32_t h = stack_.back();
        stack_.pop_back();
        if (twin(h) == kNone || is_constrained(h) || !wants_flip(h)) continue;
        const std::uint32_t twin = this->twin(h);
        flip(h);
        ++flips;
        stack_.insert(stack_.end(), {h, previous(h), twin, previous(twin)});
    }
    return flips;
}

void Triangulation::wrap() {
    constexpr double kMargin = 0.25;  // periods; sites at the seam shall not go to and fro
    const auto periods = [](double place, double period) {
        const double share = place / period;
        return static_cast<std::int8_t>(share < -kMargin || share >= 1 + kMargin ? whole(share) : 0);
    };
    std::vector<Shift> left(points_.size());
    bool any = false;
    for (std::size_t v = 0; v < points_.size(); ++v) {
        left[v] = {periods(points_[v].x, period_.x), periods(points_[v].y, period_.y)};
        if (left[v] == Shift{}) continue;
        points_[v] = points_[v] - distance(left[v]);
        any = true;
    }
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

std::size_t Triangulation::restore_delaunay(const std::stop_token& stop) {
    constexpr std::size_t kStopStride = 65536;
    // Both halves of an edge are one edge: keep those with the smaller number, without branches that cannot be
    // foretold.
    sweep_.resize(3 * triangle_count() + 1);
    std::size_t count = 0;
    for (std::uint32_t t = 0; t < triangle_count(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = edge(t, i), twin = triangles_[t].twins[i];
            sweep_[count] = h;
            count += static_cast<std::size_t>(twin != kNone) & static_cast<std::size_t>(twin > h);
        }
    }
    // An edge whose surroundings a flip has changed since is looked at again by that flip.
    changed_.assign(points_.size(), 0);
    if (is_torus()) wrap();
    if (count % 2 != 0) sweep_[count++] = sweep_[0];
    std::size_t flips = 0;
    for (std::size_t i = 0; i < count; i += 2) {
        if (i % kStopStride == 0 && stop.stop_requested()) break;
        if (is_certain(sweep_[i], sweep_[i + 1])) continue;
        for (const std::uint32_t h : {sweep_[i], sweep_[i + 1]}) {
            stack_.push_back(h);
            flips += legalise();
        }
    }
    if (flips > 0) find_edges();
    return flips;
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
    for (Triangle& triangle : triangles_) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            if (triangle.is_constrained(i)) triangle.twins[i] = kNone;
        }
        triangle.flags &= static_cast<std::uint8_t>(~kConstrained);
    }
    if (!is_torus()) points_.resize(points_.size() - 4);  // the box
    part_of_.resize(points_.size());
    number_along_sites();
    changed_.assign(points_.size(), 0);
    find_edges();
}

/// Triangles in the order of their first site: neighbours in the plane become neighbours in memory.
void Triangulation::number_along_sites() {
    edge_of_.assign(points_.size(), kNone);
    for (std::uint32_t t = 0; t < triangle_count(); ++t) {
        if (!triangles_[t].is_inside()) continue;
        for (std::uint32_t i = 0; i < 3; ++i) edge_of_[triangles_[t].corners[i]] = edge(t, i);
    }
    std::vector<std::uint32_t> number(triangle_count(), kNone);
    std::vector<std::uint32_t> order;
    order.reserve(triangle_count());
    const auto visit = [&](std::uint32_t t) {
        if (number[t] != kNone) return;
        number[t] = static_cast<std::uint32_t>(order.size());
        order.push_back(t);
    };
    for (std::uint32_t v = 0; v < sites_; ++v) {
        std::uint32_t h = edge_of_[v];
        do {
            visit(triangle_of(h));
            h = twin(previous(h));
        } while (h != edge_of_[v]);
    }
    for (std::uint32_t t = 0; t < triangle_count(); ++t) {
        if (triangles_[t].is_inside()) visit(t);
    }
    std::vector<Triangle> sorted;
    sorted.reserve(order.size());
    for (const std::uint32_t t : order) {
        Triangle& triangle = sorted.emplace_back(triangles_[t]);
        for (std::uint32_t& twin : triangle.twins) {
            if (twin != kNone) twin = edge(number[triangle_of(twin)], twin % 4);
        }
    }
    triangles_ = std::move(sorted);
}

void Triangulation::find_edges() {
    edge_of_.resize(points_.size());
    for (std::uint32_t t = 0; t < triangle_count(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) edge_of_[triangles_[t].corners[i]] = edge(t, i);
    }
    for (std::uint32_t t = 0; t < triangle_count(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            if (triangles_[t].twins[i] == kNone) edge_of_[triangles_[t].corners[i]] = edge(t, i);
        }
    }
}

}  // namespace ccdt
