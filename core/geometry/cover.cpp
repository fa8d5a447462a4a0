// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/cover.h"

#include <algorithm>
#include <cmath>

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = Arrangement::kNone;

double distance(Point a, Point b) {
    return std::sqrt(dot(b - a, b - a));
}

}  // namespace

Cover::Cover(const Chains& chains, const Arrangement& map, std::span<const Kind> kinds, double resolution,
             const std::stop_token& stop)
    : chains_(chains), map_(map), kinds_(kinds), resolution_(resolution), first_of_(kinds.size(), kNone) {
    for (auto point = static_cast<std::uint32_t>(chains.points.size()); point-- > 0;) {
        first_of_[chains.group[point]] = point;
    }
    for (const auto step : {&Cover::find_shared_points, &Cover::find_faces, &Cover::walk, &Cover::settle_thin_faces,
                            &Cover::find_flat_rings, &Cover::find_meetings, &Cover::find_cut_parts}) {
        if (stop.stop_requested()) return;
        (this->*step)();
    }
}

double Cover::area(std::uint32_t triangle) const {
    const Point a = corner(triangle, 0);
    return ccdt::cross(corner(triangle, 1) - a, corner(triangle, 2) - a) / 2;
}

bool Cover::has_segment(std::uint32_t triangle, std::size_t edge) const {
    const std::uint32_t set = map_.triangles[triangle].sets[edge];
    return set != kNone && !map_.groups_of(set).empty();
}

/// Collects input points that coincide, and reports those of the same ring.
void Cover::find_shared_points() {
    std::vector<bool> is_shared(map_.points.size(), false);
    for (std::uint32_t i = 0; i < map_.vertex_of.size(); ++i) {
        if (map_.vertex_of[i] != i) is_shared[map_.vertex_of[i]] = true;
    }
    for (std::uint32_t i = 0; i < map_.vertex_of.size(); ++i) {
        if (is_shared[map_.vertex_of[i]]) shared_.push_back({map_.vertex_of[i], chains_.group[i], i});
    }
    std::ranges::sort(shared_);
    for (std::size_t i = 1; i < shared_.size(); ++i) {
        const auto& [vertex, group, point] = shared_[i];
        if (vertex != shared_[i - 1].vertex || group != shared_[i - 1].group) continue;
        add(Fault::Touches, group, group, point, chains_.points[point]);
    }
}

void Cover::find_faces() {
    face_of_.assign(map_.triangles.size(), kNone);
    std::vector<std::uint32_t> stack;
    for (std::uint32_t first = 0; first < map_.triangles.size(); ++first) {
        if (face_of_[first] != kNone) continue;
        const auto number = static_cast<std::uint32_t>(faces_.size());
        Face& face = faces_.emplace_back();
        face_of_[first] = number;
        stack.push_back(first);
        while (!stack.empty()) {
            const std::uint32_t t = stack.back();
            stack.pop_back();
            face.area += area(t);
            for (std::size_t i = 0; i < 3; ++i) {
                const std::uint32_t next = map_.triangles[t].neighbours[i];
                if (next == kNone) continue;
                if (has_segment(t, i)) {
                    face.border += distance(corner(t, i), corner(t, i + 1));
                } else if (face_of_[next] == kNone) {
                    face_of_[next] = number;
                    stack.push_back(next);
                }
            }
        }
        face.is_thin = face.area <= resolution_ * face.border;
    }
}

/// Visits all triangles depth first, from a side of the box inwards, and returns along the same path. Each crossing of
/// a ring toggles whether that ring is open, i.e. contains the current triangle.
void Cover::walk() {
    struct Step {
        std::uint32_t triangle;
        std::uint32_t set;       ///< the set of groups crossed to enter the triangle
        std::uint32_t edge = 0;  ///< the next edge to visit
    };
    is_open_.assign(kinds_.size(), false);
    thick_in_.assign(kinds_.size(), 0);
    for (std::uint32_t g = 0; g < kinds_.size(); ++g) {
        parts_.resize(std::max(parts_.size(), kinds_[g].part + 1));
        if (!kinds_[g].is_hole) parts_[kinds_[g].part].outer = g;
    }
    std::vector<bool> seen(map_.triangles.size(), false);
    const auto at_box = [](const auto& triangle) { return std::ranges::count(triangle.neighbours, kNone) > 0; };
    const auto first = std::ranges::find_if(map_.triangles, at_box) - map_.triangles.begin();
    std::vector<Step> way{{static_cast<std::uint32_t>(first), kNone}};
    seen[way.back().triangle] = true;
    enter(way.back().triangle, kNone);
    while (!way.empty()) {
        const std::uint32_t from = way.back().triangle, edge = way.back().edge++;
        if (edge == 3) {
            cross(way.back().set);
            way.pop_back();
            continue;
        }
        const std::uint32_t next = map_.triangles[from].neighbours[edge], set = map_.triangles[from].sets[edge];
        if (next == kNone || seen[next]) continue;
        seen[next] = true;
        cross(set);
        if (set != kNone && !faces_[face_of_[next]].is_thin) examine(set, corner(from, edge));
        enter(next, set);
        way.push_back({next, set});
    }
}

/// @param set  the set of groups crossed to enter the triangle
void Cover::enter(std::uint32_t triangle, std::uint32_t set) {
    Face& face = faces_[face_of_[triangle]];
    if (!face.is_thin) ++passed_;
    if (face.is_known) return;
    face.is_known = true;
    face.is_covered = covering_ > 0;
    if (covering_ != 1 || face.is_thin || set == kNone) return;
    for (const std::uint32_t group : map_.groups_of(set)) {
        Part& part = parts_[kinds_[group].part];
        if (covers(part)) ++part.faces;
    }
}

void Cover::cross(std::uint32_t set) {
    if (set == kNone) return;
    for (const std::uint32_t group : map_.groups_of(set)) toggle(group);
}

void Cover::toggle(std::uint32_t group) {
    Part& part = parts_[kinds_[group].part];
    const bool before = covers(part), opens = !is_open_[group];
    is_open_[group] = opens;
    if (kinds_[group].is_hole) part.holes += opens ? 1 : std::size_t(-1);
    covering_ += static_cast<std::size_t>(covers(part)) - static_cast<std::size_t>(before);
    thick_in_[group] += opens ? -passed_ : passed_;
    if (opens) {
        open_.push_back(group);
    } else {
        open_.erase(std::next(std::find(open_.rbegin(), open_.rend(), group)).base());
    }
}

/// Reports a hole outside its part, a hole in another hole of its part, and parts that overlap.
/// @param set  the set of groups just crossed
void Cover::examine(std::uint32_t set, Point position) {
    const auto last_open = [&](auto is_wanted) {
        const auto found = std::find_if(open_.rbegin(), open_.rend(), is_wanted);
        return found == open_.rend() ? kNone : *found;
    };
    const auto is_hole_in = [&](std::size_t part, std::uint32_t group) {
        return kinds_[group].is_hole && kinds_[group].part == part;
    };
    for (const std::uint32_t group : map_.groups_of(set)) {
        const std::size_t part = kinds_[group].part;
        const bool is_hole = kinds_[group].is_hole;
        const std::size_t holes = parts_[part].holes;
        if (holes == 0 || (is_hole && !is_open_[group])) continue;
        const std::uint32_t outer = parts_[part].outer;
        const std::uint32_t hole = is_hole ? group : last_open([&](std::uint32_t g) { return is_hole_in(part, g); });
        if (!is_open_[outer]) {
            add(Fault::LiesOutside, hole, outer, kNone, position);
        } else if (is_hole && holes > 1) {
            add(Fault::Overlaps, hole, last_open([&](std::uint32_t g) { return g != group && is_hole_in(part, g); }),
                kNone, position);
        }
    }
    if (covering_ < 2) return;
    const auto covers_as_outer = [&](std::uint32_t g) { return !kinds_[g].is_hole && covers(parts_[kinds_[g].part]); };
    const std::uint32_t one = last_open(covers_as_outer);
    add(Fault::Overlaps, one, last_open([&](std::uint32_t g) { return g != one && covers_as_outer(g); }), kNone,
        position);
}

/// Decides which thin faces are covered. If all neighbours of a thin face are in the opposite state, it takes their
/// state.
void Cover::settle_thin_faces() {
    std::vector<bool> has_like(faces_.size(), false);
    for (std::uint32_t t = 0; t < map_.triangles.size(); ++t) {
        const Face& face = faces_[face_of_[t]];
        if (!face.is_thin) continue;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t next = map_.triangles[t].neighbours[i];
            if (next == kNone || face_of_[next] == face_of_[t]) continue;
            if (is_covered(next) == face.is_covered) has_like[face_of_[t]] = true;
        }
    }
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        if (faces_[f].is_thin && !has_like[f]) faces_[f].is_covered = !faces_[f].is_covered;
    }
}

void Cover::find_flat_rings() {
    for (std::uint32_t g = 0; g < kinds_.size(); ++g) {
        if (thick_in_[g] > 0) continue;
        add(Fault::HasNoArea, g, g, kNone, first_of_[g] == kNone ? Point{} : chains_.points[first_of_[g]]);
    }
}

void Cover::find_meetings() {
    using Meeting = Arrangement::Meeting;
    for (const auto& met : map_.meetings) {
        const std::uint32_t group = chains_.group[met.segment];
        if (met.kind != Meeting::Kind::Touch) {
            add(met.kind == Meeting::Kind::Cross ? Fault::Crosses : Fault::RunsAlong, group, met.group, met.segment,
                met.position);
        } else if (met.vertex == kNone ? met.group == group : is_at(met.vertex, group)) {
            add(Fault::Touches, group, group, met.segment, met.position);
        }
    }
}

/// Reports parts whose inside is not connected. Rings of a part may touch, but must not divide its inside.
void Cover::find_cut_parts() {
    for (std::size_t p = 0; p < parts_.size(); ++p) {
        const std::uint32_t outer = parts_[p].outer;
        if (parts_[p].faces < 2) continue;
        bool is_told = false;
        for (std::uint32_t g = outer; g < kinds_.size() && kinds_[g].part == p; ++g) is_told |= faults_.concerns(g);
        const auto is_ours = [&](const Shared& each) { return kinds_[each.group].part == p; };
        const auto at = std::ranges::adjacent_find(shared_, [&](const Shared& a, const Shared& b) {
            return a.vertex == b.vertex && is_ours(a) && is_ours(b);
        });
        const Point position = at == shared_.end() ? chains_.points[first_of_[outer]] : map_.points[at->vertex];
        if (!is_told) add(Fault::IsCut, outer, outer, kNone, position);
    }
}

bool Cover::is_at(std::uint32_t vertex, std::uint32_t group) const {
    if (vertex < chains_.points.size() && chains_.group[vertex] == group) return true;
    const auto at = std::ranges::lower_bound(shared_, Shared{vertex, group, 0});
    return at != shared_.end() && at->vertex == vertex && at->group == group;
}

void Cover::add(Fault fault, std::uint32_t ring, std::uint32_t other, std::uint32_t point, Point position) {
    faults_.add(fault, ring, other, point == kNone ? Faults::kNoCorner : point - first_of_[ring], position);
}

bool Cover::is_border(std::uint32_t triangle, std::size_t edge) const {
    const std::uint32_t next = map_.triangles[triangle].neighbours[edge];
    return is_covered(triangle) && !(next != kNone && is_covered(next));
}

std::vector<Ring> Cover::trace() const {
    std::vector<Ring> rings;
    std::vector<bool> is_done(3 * map_.triangles.size(), false);
    for (std::uint32_t first = 0; first < map_.triangles.size(); ++first) {
        for (std::size_t side = 0; side < 3; ++side) {
            if (is_done[3 * first + side] || !is_border(first, side)) continue;
            Ring& ring = rings.emplace_back();
            std::uint32_t t = first;
            std::size_t i = side;
            while (!is_done[3 * t + i]) {
                is_done[3 * t + i] = true;
                ring.push_back(corner(t, i));
                // Finds the next edge of the border by turning around the end point of this edge.
                i = (i + 1) % 3;
                while (!is_border(t, i)) {
                    const std::uint32_t around = map_.triangles[t].corners[i];
                    t = map_.triangles[t].neighbours[i];
                    const auto& corners = map_.triangles[t].corners;
                    i = static_cast<std::size_t>(std::ranges::find(corners, around) - corners.begin());
                }
            }
        }
    }
    return rings;
}

}  // namespace ccdt
