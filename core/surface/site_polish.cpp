// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/surface/site_polish.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <span>
#include <utility>

#include "core/geometry/hexagonal_spacing.h"
#include "core/polish/cell_list.h"
#include "core/polish/excess_flow.h"
#include "core/polish/site_graph.h"
#include "core/surface/site_order.h"

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = SurfaceTriangulation::kNone;
constexpr std::size_t kSites = 4096;  ///< sites per task

/// Averages the errors of sites with those of their neighbours a few times. Keeps the sum of the errors.
void smooth(const SurfaceTriangulation& mesh, std::span<double> errors) {
    constexpr int kTimes = 3;
    constexpr double kShare = 0.15;  // share of the difference that flows along each edge
    std::vector<double> before(errors.size());
    for (int i = 0; i < kTimes; ++i) {
        std::ranges::copy(errors, before.begin());
        for_ranges(mesh.executor(), errors.size(), kSites, [&](std::size_t begin, std::size_t end) {
            for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v) {
                mesh.for_edges(v, [&](std::uint32_t h) {
                    const std::uint32_t to = mesh.target(h);
                    if (mesh.is_site(to)) errors[v] += kShare * (before[to] - before[v]);
                });
            }
        });
    }
}

}  // namespace

SitePolish::SitePolish(SurfaceTriangulation& mesh, const SurfaceDensity& density, double capacity,
                       SiteRelaxation& relaxation, const std::stop_token& stop)
    : mesh_(mesh),
      density_(density),
      capacity_(capacity),
      relaxation_(relaxation),
      stop_(stop),
      masses_(mesh.surface(), density, capacity),
      spacings_(mesh.site_count()),
      moves_(mesh.site_count()) {}

void SitePolish::measure_spacings() {
    constexpr double kMost = 1e3;  // relative to a density of 1; limits the spacing where the density is almost 0
    for_ranges(mesh_.executor(), spacings_.size(), kSites, [&](std::size_t begin, std::size_t end) {
        for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v)
            spacings_[v] = std::sqrt(capacity_ / std::max(density_.at(mesh_.on_surface(v)), 1 / kMost));
    });
}

void SitePolish::push(const Push& push) {
    measure_spacings();
    const double half_reach = 0.5 * push.reach * hexagonal_spacing(1);
    const auto moved_away = [&](std::uint32_t v, std::uint32_t other) {
        const Point3 away = mesh_.point(v) - mesh_.point(other);
        const double wanted = half_reach * (spacings_[v] + spacings_[other]), distance = length(away);
        if (distance >= wanted || !(distance > 0)) return Point3{};
        return push.push * (wanted - distance) / distance * away;
    };
    for_ranges(mesh_.executor(), moves_.size(), kSites, [&](std::size_t begin, std::size_t end) {
        for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v) {
            moves_[v] = {};
            mesh_.for_edges(v, [&](std::uint32_t h) {
                const std::uint32_t other = mesh_.target(h);
                if (mesh_.is_site(other)) moves_[v] = moves_[v] + moved_away(v, other);
            });
        }
    });
    for (const auto& [a, b] : facing_) {
        moves_[a] = moves_[a] + moved_away(a, b);
        moves_[b] = moves_[b] + moved_away(b, a);
    }
    apply();
}

void SitePolish::even_out() {
    if (stop_.stop_requested()) return;
    measure_spacings();
    const auto owner = owners(mesh_);
    // Sites in different components are not joined, so the excess does not cross creases.
    const auto component = [&](std::uint32_t v) { return mesh_.surface().component(mesh_.on_surface(v).face); };
    const auto edges =
        edges_between_sites(mesh_, [&](std::uint32_t a, std::uint32_t b) { return component(a) == component(b); });
    ExcessFlow flow(mesh_.site_count(), edges, mesh_.executor());
    const auto masses = masses_.measure(mesh_);
    const std::span<double> errors = flow.errors();
    std::ranges::fill(errors, 1);
    for (std::uint32_t v = 0; v < masses.size(); ++v) {
        if (owner[v] != kNone) errors[owner[v]] -= masses[v];
    }
    for (std::size_t v = mesh_.free_count(); v < mesh_.site_count(); ++v) errors[v] = 0;
    smooth(mesh_, errors);
    if (!flow.solve(stop_)) return;
    flow.moves(mesh_, spacings_, std::span<Point3>(moves_));
    apply();
}

/// Moves the sites. Sites keep half a row of distance from borders and creases.
void SitePolish::apply() {
    FirstRow row;
    row.find(mesh_);
    row.keep_off_vertices(mesh_, spacings_, kFirstRow, moves_);
    row.keep_off_edges(mesh_, spacings_, kFirstRow, moves_);
    const SiteOrder order(mesh_);
    if (stop_.stop_requested()) return;
    order.for_sites([&](std::uint32_t site) { mesh_.move(site, moves_[site]); });
}

bool SitePolish::is_near(std::uint32_t a, std::uint32_t b, double reach) const {
    const Point3 off = mesh_.point(a) - mesh_.point(b);
    const double wanted = reach * (spacings_[a] + spacings_[b]) / 2;
    return dot(off, off) < wanted * wanted;
}

bool SitePolish::is_any_nearer(double least) {
    measure_spacings();
    const double reach = least * hexagonal_spacing(1);
    const std::size_t sites = mesh_.site_count();
    std::vector<Point3> places(sites), normals(sites);
    for (std::uint32_t v = 0; v < sites; ++v) {
        places[v] = mesh_.point(v);
        normals[v] = mesh_.surface().smooth_normal(mesh_.on_surface(v));
    }
    const BasicCellList<Point3> cells(places);
    constexpr std::size_t kMostFacing = 8;  // pairs of a site; stacked sheets could have any number
    struct Found {
        std::vector<std::array<std::uint32_t, 2>> joined, facing;
    };
    std::vector<Found> found((sites + kSites - 1) / kSites);
    for_ranges(mesh_.executor(), sites, kSites, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> joined;
        Found& near = found[begin / kSites];
        auto &near_joined = near.joined, &near_facing = near.facing;
        for (auto v = static_cast<std::uint32_t>(begin); v < end && !stop_.stop_requested(); ++v) {
            const std::size_t most = near_facing.size() + kMostFacing;
            joined.clear();
            mesh_.for_edges(v, [&](std::uint32_t h) { joined.push_back(mesh_.target(h)); });
            cells.for_near(places[v], 2 * reach * spacings_[v], [&](Point3, std::uint32_t other) {
                if (other <= v || !mesh_.is_free(v) || !is_near(v, other, reach)) return;
                const bool is_joined = std::ranges::find(joined, other) != joined.end();
                if (!is_joined && !(dot(normals[v], normals[other]) > 0)) return;
                if (is_joined)
                    near_joined.push_back({v, other});
                else if (near_facing.size() < most)
                    near_facing.push_back({v, other});
            });
        }
        std::ranges::sort(near_joined);
        std::ranges::sort(near_facing);
    });
    joined_.clear();
    facing_.clear();
    for (const auto& [near_joined, near_facing] : found) {
        joined_.insert(joined_.end(), near_joined.begin(), near_joined.end());
        facing_.insert(facing_.end(), near_facing.begin(), near_facing.end());
    }
    return !joined_.empty() || !facing_.empty();
}

/// Returns triangles between free sites near a site, in descending order of capacity.
std::vector<std::uint32_t> SitePolish::wide_triangles(std::uint32_t site) const {
    constexpr std::size_t kVisited = 300;  // about the triangles within seven spacings
    constexpr std::size_t kMost = 16;
    std::vector<std::uint32_t> visited;
    mesh_.for_edges(site, [&](std::uint32_t h) { visited.push_back(h / 4); });
    for (std::size_t i = 0; i < visited.size() && visited.size() < kVisited; ++i) {
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t twin = mesh_.twin(SurfaceTriangulation::edge(visited[i], k));
            if (twin == kNone || std::ranges::find(visited, twin / 4) != visited.end()) continue;
            visited.push_back(twin / 4);
        }
    }
    std::erase_if(visited, [&](std::uint32_t t) {
        return !std::ranges::all_of(mesh_.corners(t), [&](std::uint32_t v) { return mesh_.is_free(v); });
    });
    std::ranges::stable_sort(visited, std::greater{}, [&](std::uint32_t t) {
        const double spacing = spacings_[mesh_.corners(t)[0]];
        return mesh_.doubled_area(t) / (spacing * spacing);
    });
    visited.resize(std::min(visited.size(), kMost));
    return visited;
}

void SitePolish::separate(double least) {
    constexpr double kStuck = 0.85;  // share of the least distance; pushes move other pairs apart
    constexpr int kMaxTimes = 4;     // afterwards, pushes move relocated sites away from their new neighbours
    if (++separations_ > kMaxTimes) return;
    // Largest number of pairs, which few surfaces exceed: those that are too rough for the spacing of the sites.
    const std::size_t most = 16 + mesh_.site_count() / 256;
    auto pairs = joined_;
    pairs.insert(pairs.end(), facing_.begin(), facing_.end());
    std::erase_if(pairs,
                  [&](const auto& pair) { return !is_near(pair[0], pair[1], kStuck * least * hexagonal_spacing(1)); });
    std::vector<std::uint8_t> is_relocated(mesh_.site_count(), 0);
    for (const auto& [a, b] : std::span(pairs).first(std::min(pairs.size(), most))) {
        if (is_relocated[a] != 0 || is_relocated[b] != 0) continue;
        for (const std::uint32_t site : {a, b}) {
            if (!mesh_.is_free(site) || !mesh_.relocate(site, wide_triangles(site))) continue;
            is_relocated[site] = 1;
            break;
        }
    }
    facing_.clear();
    masses_.forget();
}

}  // namespace ccdt
