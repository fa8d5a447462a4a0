// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/site_polish.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>

#include "core/ccdt/polish/cell_list.h"
#include "core/ccdt/polish/site_graph.h"
#include "core/ccdt/surface/site_order.h"
#include "core/geometry/hexagonal_spacing.h"

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = SurfaceTriangulation::kNone;
constexpr std::size_t kSites = 1024;  ///< sites per task
/// Least distance in space of two sites beside a sharp edge that is not very acute, relative to the hexagonal distance,
/// and the reach of pushes that achieves it. A greater distance makes capacities less equal.
constexpr double kMinStraight = 0.62, kStraightReach = 0.7;

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
    constexpr double kMax = 1e3;  // relative to a density of 1; limits the spacing where the density is almost 0
    for_ranges(mesh_.executor(), spacings_.size(), kSites, [&](std::size_t begin, std::size_t end) {
        for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v)
            spacings_[v] = std::sqrt(capacity_ / std::max(density_.at(mesh_.on_surface(v)), 1 / kMax));
    });
}

/// Whether two sites keep kStraightReach apart in space: any sharp edge between them is not very acute.
bool SitePolish::keep_apart(std::uint32_t a, std::uint32_t b) const {
    constexpr double kMinCosine = -0.5;
    return dot(mesh_.face_normal(a), mesh_.face_normal(b)) >= kMinCosine;
}

/// Whether two sites lie on different sheets, one above the other, that are nearly parallel.
bool SitePolish::are_on_parallel_sheets(const SurfacePoint& from, const SurfacePoint& to) const {
    constexpr double kMinCosine = 0.9;
    constexpr double kMaxAside = 0.2;  // of the distance; more if the line along the surface ends at a border
    const Surface& surface = mesh_.surface();
    if (surface.component(from.face) == surface.component(to.face)) return false;
    const Point3 normal = surface.normal(to.face);
    if (dot(surface.normal(from.face), normal) < kMinCosine) return false;
    const Point3 position = surface.position(to), straight = position - surface.position(from);
    const Point3 apart = position - surface.position(surface.trace(from, straight - dot(straight, normal) * normal));
    const Point3 aside = apart - dot(apart, normal) * normal;
    return dot(aside, aside) <= kMaxAside * kMaxAside * dot(straight, straight);
}

void SitePolish::push(const Push& push) {
    measure_spacings();
    const auto pushed = [&](std::uint32_t v, std::uint32_t other, Point3 toward, double reach) {
        const double wanted = 0.5 * reach * hexagonal_spacing(1) * (spacings_[v] + spacings_[other]);
        const double distance = length(toward);
        if (distance >= wanted || !(distance > 0)) return Point3{};
        return -push.push * (wanted - distance) / distance * toward;
    };
    const auto moved_away = [&](std::uint32_t v, std::uint32_t other) {
        const Point3 straight = mesh_.point(other) - mesh_.point(v), toward = mesh_.toward(v, other);
        const Point3 move = pushed(v, other, toward, push.reach);
        if (move != Point3{} || toward == straight || !keep_apart(v, other)) return move;
        return pushed(v, other, straight, std::min(push.reach, kStraightReach));
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
    for (const auto& [sites, distance] : near_) {
        const auto [a, b] = sites;
        if (mesh_.are_joined(a, b)) continue;
        moves_[a] = moves_[a] + moved_away(a, b);
        moves_[b] = moves_[b] + moved_away(b, a);
    }
    apply();
}

void SitePolish::even_out() {
    if (stop_.stop_requested()) return;
    fewest_ = std::numeric_limits<std::size_t>::max();
    failures_ = 0;
    measure_spacings();
    if (!flow_) {
        // Sites in different components are not joined, so the excess does not cross creases.
        const auto component = [&](std::uint32_t v) { return mesh_.surface().component(mesh_.on_surface(v).face); };
        const auto edges =
            edges_between_sites(mesh_, [&](std::uint32_t a, std::uint32_t b) { return component(a) == component(b); });
        flow_.emplace(mesh_.site_count(), edges, mesh_.executor());
        owner_ = owners(mesh_);
    }
    if (stop_.stop_requested()) return;
    const auto masses = masses_.measure(mesh_);
    const std::span<double> errors = flow_->errors();
    std::ranges::fill(errors, 1);
    for (std::uint32_t v = 0; v < masses.size(); ++v) {
        if (owner_[v] != kNone) errors[owner_[v]] -= masses[v];
    }
    for (std::size_t v = mesh_.free_count(); v < mesh_.site_count(); ++v) errors[v] = 0;
    smooth(mesh_, errors);
    if (!flow_->solve(stop_)) return;
    flow_->moves([this](std::uint32_t v, std::uint32_t to) { return mesh_.toward(v, to); }, spacings_,
                 std::span<Point3>(moves_));
    apply();
}

/// Moves the sites. Sites keep half a row of distance from borders and creases.
void SitePolish::apply() {
    if (mesh_.vertex_count() > mesh_.site_count()) {
        FirstRow row;
        row.find(mesh_);
        row.keep_off_vertices(mesh_, spacings_, kFirstRow, moves_);
        row.keep_off_edges(mesh_, spacings_, kFirstRow, moves_);
    }
    const SiteOrder order(mesh_, [&](std::uint32_t site) { return moves_[site] != Point3{}; });
    order.for_sites(stop_, [&](std::uint32_t site) { mesh_.move(site, moves_[site]); });
}

bool SitePolish::is_any_nearer(double least) {
    constexpr std::size_t kMaxPairs = 16;   // limits for each site, because stacked sheets could have any number
    constexpr std::size_t kMaxSheets = 64;  // ignored pairs
    constexpr int kMaxFailures = 12;
    constexpr double kRounding = 1e-12;
    measure_spacings();
    const double reach = least * hexagonal_spacing(1);
    const std::size_t sites = mesh_.site_count();
    std::vector<Point3> positions(sites);
    for (std::uint32_t v = 0; v < sites; ++v) positions[v] = mesh_.point(v);
    cells_.emplace(positions);
    std::vector<std::vector<NearPair>> found((sites + kSites - 1) / kSites);
    for_ranges(mesh_.executor(), sites, kSites, [&](std::size_t begin, std::size_t end) {
        for (auto v = static_cast<std::uint32_t>(begin); v < end && !stop_.stop_requested(); ++v) {
            const Point3 normal = mesh_.face_normal(v);
            const double longest = reach * spacings_[v], limit = (1 + kRounding) * longest * longest;
            std::size_t pairs = 0, sheets = 0;
            cells_->for_near(positions[v], reach * spacings_[v], [&](Point3, std::uint32_t other) {
                const Point3 apart = positions[v] - positions[other];
                if (other == v || dot(apart, apart) > limit) return true;
                const double distance = 2 * length(apart) / (spacings_[v] + spacings_[other]);
                if (distance >= reach) return true;
                if (are_on_parallel_sheets(mesh_.on_surface(v), mesh_.on_surface(other))) return ++sheets < kMaxSheets;
                // The site with the larger spacing, and so with the longer reach, lists the pair.
                const bool lists = std::pair(spacings_[v], v) > std::pair(spacings_[other], other);
                const auto [a, b] = std::minmax(v, other);
                const bool near = !is_sharp(normal, mesh_.face_normal(other)) ||
                                  (distance < kMinStraight * hexagonal_spacing(1) && keep_apart(v, other));
                if (lists && mesh_.is_free(a) && near) found[begin / kSites].push_back({{a, b}, distance});
                return ++pairs < kMaxPairs;
            });
        }
    });
    before_ = std::exchange(near_, {});
    for (const auto& list : found) near_.insert(near_.end(), list.begin(), list.end());
    std::ranges::sort(near_, {}, &NearPair::sites);
    failures_ = near_.size() < fewest_ ? 0 : failures_ + 1;
    fewest_ = std::min(fewest_, near_.size());
    return !near_.empty() && failures_ < kMaxFailures;
}

/// Returns triangles between free sites near a site. Those whose middles are farthest from all other sites come first.
std::vector<std::uint32_t> SitePolish::wide_triangles(std::uint32_t site) const {
    constexpr std::size_t kVisited = 150;  // about the triangles within five spacings
    constexpr std::size_t kMax = 16;
    constexpr double kPerDistance = 0.02;  // penalty for long moves, which disturb long waves more
    // Distance from the middle of a triangle of the hexagonal pattern to its corners, in spacings. In strips of two
    // rows, triangles are narrower, and sites relocated there would stay near others.
    constexpr double kMin = 0.62;
    std::vector<std::uint32_t> visited;
    mesh_.for_edges(site, [&](std::uint32_t h) { visited.push_back(h / 4); });
    for (std::size_t i = 0; i < visited.size() && visited.size() < kVisited; ++i) {
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t twin = mesh_.twin(SurfaceTriangulation::edge(visited[i], k));
            if (twin == kNone || std::ranges::find(visited, twin / 4) != visited.end()) continue;
            visited.push_back(twin / 4);
        }
    }
    std::vector<std::pair<double, std::uint32_t>> wide;
    for (const std::uint32_t t : visited) {
        const auto& corners = mesh_.corners(t);
        if (!std::ranges::all_of(corners, [&](std::uint32_t v) { return mesh_.is_free(v); })) continue;
        const auto [a, b, c] = mesh_.positions(t);
        const Point3 middle = 1.0 / 3 * (a + b + c), normal = mesh_.doubled_normal(t);
        const double spacing = spacings_[corners[0]];
        double least = spacing;
        cells_->for_near(middle, spacing, [&](Point3, std::uint32_t v) {
            if (v != site && dot(mesh_.face_normal(v), normal) > 0)
                least = std::min(least, length(mesh_.point(v) - middle));
        });
        if (least < kMin * spacing) continue;
        wide.emplace_back((kPerDistance * length(middle - mesh_.point(site)) - least) / spacing, t);
    }
    std::ranges::sort(wide);
    std::vector<std::uint32_t> triangles;
    for (const auto& [order, t] : std::span(wide).first(std::min(wide.size(), kMax))) triangles.push_back(t);
    return triangles;
}

void SitePolish::separate(double least) {
    constexpr double kStuck = 0.85;   // share of the least distance
    constexpr double kGrowth = 0.01;  // in spacings
    const std::size_t most = 16 + mesh_.site_count() / 256;
    if (++separations_ % 2 == 0) return;  // pushes move relocated sites away from their new neighbours
    std::vector<NearPair> stuck;
    for (const NearPair& pair : near_) {
        if (is_sharp(mesh_.face_normal(pair.sites[0]), mesh_.face_normal(pair.sites[1]))) continue;
        const auto before = std::ranges::lower_bound(before_, pair.sites, {}, &NearPair::sites);
        const bool was_near = before != before_.end() && before->sites == pair.sites;
        if (pair.distance < kStuck * least * hexagonal_spacing(1) ||
            (was_near && pair.distance < before->distance + kGrowth))
            stuck.push_back(pair);
    }
    std::ranges::stable_sort(stuck, {}, &NearPair::distance);
    std::vector<std::uint8_t> is_relocated(mesh_.site_count(), 0);
    const auto touches = [&](const NearPair& pair) {
        return is_relocated[pair.sites[0]] != 0 || is_relocated[pair.sites[1]] != 0;
    };
    for (const NearPair& pair : std::span(stuck).first(std::min(stuck.size(), most))) {
        for (const std::uint32_t site : pair.sites) {
            if (touches(pair) || !mesh_.is_free(site)) continue;
            is_relocated[site] = mesh_.relocate(site, wide_triangles(site)) ? 1 : 0;
        }
    }
    if (std::erase_if(near_, touches) == 0) return;
    masses_.forget();
    flow_.reset();
}

/// Whether a triangle at a site touches a border or crease.
bool SitePolish::is_beside_border(std::uint32_t site) const {
    bool found = false;
    mesh_.for_edges(site, [&](std::uint32_t h) {
        if (mesh_.is_site(mesh_.target(h))) return;
        mesh_.for_edges(mesh_.target(h), [&](std::uint32_t edge) { found = found || mesh_.twin(edge) == kNone; });
    });
    return found;
}

/// Whether the surface around a site is thinner than the spacing: a short line leads to its other side.
bool SitePolish::is_thin_around(std::uint32_t site) const {
    constexpr std::array kLengths{0.5, 1.0, 1.5};  // spacings
    constexpr double kOtherSide = -0.3;            // cosine between normals, which is 0 at the edges of a cube
    const Surface& surface = mesh_.surface();
    const SurfacePoint& from = mesh_.on_surface(site);
    const Point3 normal = surface.normal(from.face);
    for (int way = 0; way < 27; ++way) {
        const Point3 along{way % 3 - 1.0, way / 3 % 3 - 1.0, way / 9 - 1.0};
        for (const double spacings : kLengths) {
            const double reach = spacings * spacings_[site] / std::max(length(along), 1.0);
            const SurfacePoint end = surface.trace(from, reach * along);
            if (dot(normal, surface.normal(end.face)) < kOtherSide) return true;
        }
    }
    return false;
}

std::optional<std::vector<SurfacePoint>> SitePolish::spread(double least) const {
    constexpr double kNear = 0.7;    // relative to the hexagonal distance; sites that are nearer are very near
    constexpr double kAround = 6;    // spacings from a near pair to the farthest sites that move
    constexpr double kReach = 1.05;  // of pushes, relative to `least`
    constexpr int kRounds = 100;
    const double spacing = hexagonal_spacing(1);
    std::vector<NearPair> pairs = near_;
    std::erase_if(pairs, [&](const NearPair& pair) {
        return !(pair.distance < kNear * spacing && is_thin_around(pair.sites[0]));
    });
    if (pairs.empty()) return {};
    const Surface& surface = mesh_.surface();
    std::vector<SurfacePoint> points;
    for (std::uint32_t v = 0; v < mesh_.site_count(); ++v) points.push_back(mesh_.on_surface(v));
    // Sites around the near pairs, and those beyond which only push.
    std::vector<std::uint8_t> role(points.size(), 0);
    for (const NearPair& pair : pairs) {
        const std::uint32_t site = pair.sites[0];
        const double around = kAround * spacings_[site];
        cells_->for_near(mesh_.point(site), around + 2 * spacings_[site], [&](Point3 position, std::uint32_t v) {
            const bool is_near = std::ranges::find(pair.sites, v) != pair.sites.end();
            const bool moves =
                length(position - mesh_.point(site)) < around && mesh_.is_free(v) && (is_near || !is_beside_border(v));
            role[v] = std::max<std::uint8_t>(role[v], moves ? 2 : 1);
        });
    }
    if (std::ranges::find(role, 2) == role.end()) return {};
    std::vector<std::uint32_t> sites;
    for (std::uint32_t v = 0; v < role.size(); ++v) {
        if (role[v] > 0) sites.push_back(v);
    }
    bool is_any_near = true;
    for (int round = 0; round < kRounds && is_any_near && !stop_.stop_requested(); ++round) {
        is_any_near = false;
        std::vector<Point3> positions, moves(sites.size());
        for (const std::uint32_t v : sites) positions.push_back(surface.position(points[v]));
        const CellList3 cells(positions);
        for (std::uint32_t i = 0; i < sites.size(); ++i) {
            const std::uint32_t v = sites[i];
            if (role[v] < 2) continue;
            const Point3 normal = surface.normal(points[v].face);
            cells.for_near(
                positions[i], kReach * least * spacing * spacings_[v], [&](Point3 position, std::uint32_t k) {
                    const Point3 apart = positions[i] - position;
                    const double distance = length(apart);
                    const double wanted = least * spacing * (spacings_[v] + spacings_[sites[k]]) / 2;
                    if (k == i || !(distance > 0) || distance >= kReach * wanted) return;
                    const SurfacePoint& other = points[sites[k]];
                    if (is_sharp(normal, surface.normal(other.face)) || are_on_parallel_sheets(points[v], other))
                        return;
                    is_any_near = is_any_near || distance < wanted;
                    moves[i] = moves[i] + (kReach * wanted - distance) / (2 * distance) * apart;
                });
        }
        for (std::uint32_t i = 0; i < sites.size(); ++i) points[sites[i]] = surface.trace(points[sites[i]], moves[i]);
    }
    return points;
}

}  // namespace ccdt
