// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/resettlement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "core/geometry/hexagonal_spacing.h"
#include "core/mesh/move_guard.h"
#include "core/mesh/relocation.h"

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = Triangulation::kNone;

bool has_site(const Triangulation& mesh, std::uint32_t triangle) {
    return std::ranges::any_of(mesh.corners(triangle), [&](std::uint32_t v) { return mesh.is_site(v); });
}

/// Assigns each triangle without a site to a site of the nearest triangle that has one.
/// @returns  the assigned site [triangles]; kNone for triangles with sites, and in parts without sites
std::vector<std::uint32_t> owners(const Triangulation& mesh) {
    std::vector<std::uint32_t> owner(mesh.triangle_count(), kNone), reached;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        if (has_site(mesh, t)) continue;
        for (std::uint32_t i = 0; i < 3 && owner[t] == kNone; ++i) {
            const std::uint32_t twin = mesh.twin(Triangulation::edge(t, i));
            if (twin == kNone || !has_site(mesh, Triangulation::triangle_of(twin))) continue;
            owner[t] = mesh.origin(Triangulation::previous(twin));
            reached.push_back(t);
        }
    }
    for (std::size_t k = 0; k < reached.size(); ++k) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t twin = mesh.twin(Triangulation::edge(reached[k], i));
            if (twin == kNone) continue;
            const std::uint32_t other = Triangulation::triangle_of(twin);
            if (owner[other] != kNone || has_site(mesh, other)) continue;
            owner[other] = owner[reached[k]];
            reached.push_back(other);
        }
    }
    return owner;
}

/// Calls function(triangle, neighbour) for each triangle around a site, counter-clockwise. `neighbour` is the
/// triangle's vertex that follows the site.
template <class Function>
void for_fan(const Triangulation& mesh, std::uint32_t site, Function&& function) {
    const std::uint32_t first = mesh.edge_of(site);
    std::uint32_t h = first;
    do {
        function(Triangulation::triangle_of(h), mesh.target(h));
        h = mesh.twin(Triangulation::previous(h));
    } while (h != first);
}

}  // namespace

Resettlement::Resettlement(Triangulation& mesh, const TriangleGoals& goals, double least_height)
    : mesh_(mesh),
      goals_(goals),
      least_height_(least_height),
      surplus_(mesh.site_count(), 1),
      around_(mesh.site_count(), 0),
      largest_triangle_(mesh.site_count(), kNone),
      outdated_(mesh.site_count(), false) {
    share_out();
    sum_around();
}

/// Divides each triangle's capacity among its sites.
void Resettlement::share_out() {
    const auto owner = owners(mesh_);
    std::vector<double> most(mesh_.site_count(), 0);
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
        const double capacity = goals_.of(t).weight * mesh_.doubled_area(t) / 2;
        const auto give = [&](std::uint32_t site, double share) {
            surplus_[site] -= share;
            if (capacity <= most[site]) return;
            most[site] = capacity;
            largest_triangle_[site] = t;
        };
        if (owner[t] != kNone) {
            give(owner[t], capacity);
            continue;
        }
        const auto corners = mesh_.corners(t);
        const auto sites = std::ranges::count_if(corners, [&](std::uint32_t v) { return mesh_.is_site(v); });
        for (const std::uint32_t v : corners) {
            if (mesh_.is_site(v)) give(v, capacity / static_cast<double>(sites));
        }
    }
}

void Resettlement::sum_around() {
    around_ = surplus_;
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
        const auto corners = mesh_.corners(t);
        for (std::uint32_t i = 0; i < 3; ++i) {
            // Each edge between sites is visited once from each end.
            const std::uint32_t a = corners[i], b = corners[(i + 1) % 3];
            if (mesh_.is_site(a) && mesh_.is_site(b)) around_[a] += surplus_[b];
        }
    }
}

/// Lists the sites with too many or too few sites around them, by part, then by decreasing surplus or deficit.
/// @param sign  1: too many; -1: too few
std::vector<Resettlement::Candidate> Resettlement::candidates(double sign) const {
    constexpr double kMin = 0.5;  // in sites; smaller amounts are due to waves or noise
    std::vector<Candidate> found;
    for (std::uint32_t v = 0; v < surplus_.size(); ++v) {
        if (sign * around_[v] > kMin && sign * surplus_[v] > 0) found.push_back({sign * around_[v], v});
    }
    std::ranges::sort(found, {}, [&](const Candidate& candidate) {
        return std::tuple(mesh_.part_of(candidate.site), -candidate.sites, candidate.site);
    });
    return found;
}

std::size_t Resettlement::even_out() {
    constexpr double kGain = 1.1;  // least sum of surplus and deficit; a sum of 1 would only move the error
    const auto many = candidates(1), few = candidates(-1);
    std::size_t taken = 0;
    auto to = few.begin();
    for (const Candidate& from : many) {
        if (outdated_[from.site]) continue;
        const std::uint32_t part = mesh_.part_of(from.site);
        while (to != few.end() && (mesh_.part_of(to->site) < part || outdated_[to->site])) ++to;
        if (to == few.end()) break;
        if (mesh_.part_of(to->site) != part || from.sites + to->sites < kGain) continue;
        if (relocate(from.site, to->site)) ++taken;
    }
    return taken;
}

bool Resettlement::move_away(std::uint32_t site, double least, double enough) {
    constexpr int kTries = 8;
    if (outdated_[site]) return false;
    std::uint32_t clearest = kNone;
    double most = least * least;
    std::vector<std::uint32_t> tried;
    for (int i = 0; i < kTries && (clearest == kNone || most < enough * enough); ++i) {
        std::uint32_t to = kNone;
        for (std::uint32_t v = 0; v < surplus_.size(); ++v) {
            if (v == site || outdated_[v] || mesh_.part_of(v) != mesh_.part_of(site)) continue;
            if (std::ranges::find(tried, v) != tried.end()) continue;
            if (to == kNone || surplus_[v] < surplus_[to]) to = v;
        }
        if (to == kNone) break;
        tried.push_back(to);
        const double squared = clearance_beside(to, site);
        if (squared < most) continue;
        most = squared;
        clearest = to;
    }
    return clearest != kNone && relocate(site, clearest);
}

/// Returns the squared distance that `site` would have from the nearest other site if relocate() moved it beside `to`;
/// negative if there is no position beside `to`.
double Resettlement::clearance_beside(std::uint32_t to, std::uint32_t site) const {
    const std::uint32_t triangle = triangle_beside(to, site);
    if (triangle == kNone) return -1;
    const auto [a, b, c] = mesh_.positions(triangle);
    const Point position = 1.0 / 3 * (a + b + c);
    double squared = std::numeric_limits<double>::infinity();
    for (std::uint32_t v = 0; v < mesh_.site_count(); ++v) {
        const Point apart = mesh_.point(v) - position;
        if (v != site) squared = std::min(squared, dot(apart, apart));
    }
    return squared;
}

/// Returns a site's largest triangle that does not have `other` as a corner; kNone if there is none.
std::uint32_t Resettlement::triangle_beside(std::uint32_t site, std::uint32_t other) const {
    const auto is_without = [&](std::uint32_t t) {
        return std::ranges::none_of(mesh_.corners(t), [&](std::uint32_t v) { return v == other; });
    };
    if (largest_triangle_[site] != kNone && is_without(largest_triangle_[site])) return largest_triangle_[site];
    std::uint32_t largest = kNone;
    for_fan(mesh_, site, [&](std::uint32_t t, std::uint32_t) {
        if (is_without(t) && (largest == kNone || mesh_.doubled_area(t) > mesh_.doubled_area(largest))) largest = t;
    });
    return largest;
}

bool Resettlement::relocate(std::uint32_t site, std::uint32_t beside) {
    const std::uint32_t triangle = triangle_beside(beside, site);
    mark_outdated(site);
    if (triangle == kNone) return false;
    mark_outdated(beside);
    constexpr double kThird = 1.0 / 3;
    if (!can_be_divided(triangle, kThird)) return false;
    const auto [a, b, c] = mesh_.positions(triangle);
    return relocate_site(mesh_, site, triangle, kThird * (a + b + c));
}

/// Whether a triangle is large enough to be divided.
/// @param share  share of the triangle's area that the smallest of the three new triangles gets
bool Resettlement::can_be_divided(std::uint32_t triangle, double share) const {
    const auto [a, b, c] = mesh_.positions(triangle);
    return share * mesh_.doubled_area(triangle) >= needle_area(a, b, c, least_height_);
}

const Resettlement::SmallParts& Resettlement::small_parts() {
    constexpr std::size_t kMaxSites = 16;
    if (small_parts_) return *small_parts_;
    small_parts_.emplace();
    small_parts_->sites.resize(mesh_.part_count());
    small_parts_->triangles.resize(mesh_.part_count());
    for (std::uint32_t v = 0; v < mesh_.site_count(); ++v) ++small_parts_->sites[mesh_.part_of(v)];
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
        const std::uint32_t part = mesh_.part_of(mesh_.corners(t)[0]);
        if (small_parts_->sites[part] <= kMaxSites) small_parts_->triangles[part].push_back(t);
    }
    return *small_parts_;
}

bool Resettlement::is_in_small_part(std::uint32_t site) {
    return !small_parts().triangles[mesh_.part_of(site)].empty();
}

/// Returns the position that is farthest from all other sites, in the small part where `site` lies. Distances count
/// only up to the least distance that two sites should have. Of equally far positions, returns one in the largest
/// triangle.
Resettlement::Position Resettlement::farthest_position(std::uint32_t site) {
    constexpr double kThird = 1.0 / 3, kSixth = 1.0 / 6;
    constexpr std::array<std::array<double, 3>, 4> kPositions{{{kThird, kThird, kThird},
                                                               {4 * kSixth, kSixth, kSixth},
                                                               {kSixth, 4 * kSixth, kSixth},
                                                               {kSixth, kSixth, 4 * kSixth}}};
    const auto& triangles = small_parts().triangles[mesh_.part_of(site)];
    const double enough = enough_squared(site);
    const auto near = sites_near(triangles, site, std::sqrt(enough));
    Position best;
    double best_area = 0;
    for (const std::uint32_t t : triangles) {
        if (!can_be_divided(t, kSixth)) continue;
        const auto [a, b, c] = mesh_.positions(t);
        const double area = mesh_.doubled_area(t);
        for (const auto& [u, v, w] : kPositions) {
            const Point p = u * a + v * b + w * c;
            double squared = enough;
            for (const Point other : near) squared = std::min(squared, dot(p - other, p - other));
            if (std::pair(squared, area) <= std::pair(best.squared, best_area)) continue;
            best = {squared, t, p};
            best_area = area;
        }
    }
    return best;
}

/// Returns the square of the least distance that two sites should have at the density near `site`.
double Resettlement::enough_squared(std::uint32_t site) const {
    constexpr double kEnough = 0.84;  // of the hexagonal distance, as in the last near pushes: ccdt/polish/settings.cpp
    const double least = kEnough * hexagonal_spacing(goals_.of(Triangulation::triangle_of(mesh_.edge_of(site))).weight);
    return least * least;
}

/// Returns the positions of all sites, except `but`, that are within `reach` of a box. The box bounds some triangles
/// and the site `but`.
std::vector<Point> Resettlement::sites_near(std::span<const std::uint32_t> triangles, std::uint32_t but,
                                            double reach) const {
    Box box{mesh_.point(but), mesh_.point(but)};
    for (const std::uint32_t t : triangles) {
        for (const Point corner : mesh_.positions(t)) box.include(corner);
    }
    std::vector<Point> near;
    for (std::uint32_t v = 0; v < mesh_.site_count(); ++v) {
        const Point p = mesh_.point(v);
        if (v != but && p.x >= box.min.x - reach && p.x <= box.max.x + reach && p.y >= box.min.y - reach &&
            p.y <= box.max.y + reach)
            near.push_back(p);
    }
    return near;
}

bool Resettlement::separate(std::array<std::uint32_t, 2> pair) {
    const Point apart = mesh_.point(pair[1]) - mesh_.point(pair[0]);
    const double enough = std::min(enough_squared(pair[0]), enough_squared(pair[1]));
    if (dot(apart, apart) >= enough) return false;
    Position best{dot(apart, apart), kNone, {}};
    std::uint32_t moved = kNone;
    for (const std::uint32_t site : pair) {
        if (!is_in_small_part(site)) continue;
        const Position position = farthest_position(site);
        if (position.squared <= best.squared) continue;
        best = position;
        moved = site;
    }
    if (best.squared < enough) {
        // Relative to the distance that two sites should have. In a hexagonal grid, the distance from the centre of a
        // triangle to its corners is 0.69.
        constexpr double kClear = 0.6;
        const double least = std::sqrt(dot(apart, apart)), clear = kClear * std::sqrt(enough);
        for (const std::uint32_t site : pair) {
            if (!is_in_small_part(site) && move_away(site, least, clear)) return true;
        }
    }
    return moved != kNone && relocate_site(mesh_, moved, best.triangle, best.point);
}

/// Marks the data of a site, of its neighbours and of their neighbours as outdated.
void Resettlement::mark_outdated(std::uint32_t site) {
    for_fan(mesh_, site, [&](std::uint32_t, std::uint32_t near) {
        outdated_[site] = true;
        if (!mesh_.is_site(near)) return;
        for_fan(mesh_, near, [&](std::uint32_t, std::uint32_t next) {
            outdated_[near] = true;
            if (mesh_.is_site(next)) outdated_[next] = true;
        });
    });
}

}  // namespace ccdt
