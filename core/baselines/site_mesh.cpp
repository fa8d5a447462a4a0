// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/site_mesh.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "core/baselines/periodic_images.h"
#include "core/ccdt/plane/placement.h"
#include "core/ccdt/plane/start.h"
#include "core/mesh/flips.h"
#include "core/mesh/insertion.h"
#include "core/mesh/insertion_steps.h"
#include "core/mesh/inside.h"

namespace ccdt {

namespace {

std::optional<Error> check(const Options& options) {
    constexpr std::size_t kMaxSites = std::size_t{1} << 28;  // half-edges have 32-bit numbers
    if (options.sites < 1 || options.sites > kMaxSites) {
        return Error{ErrorCode::Malformed, "sites must lie between 1 and " + std::to_string(kMaxSites), "sites"};
    }
    if (options.iterations < 0) return Error{ErrorCode::Malformed, "iterations must not be negative", "iterations"};
    if (options.tolerance && !(*options.tolerance > 0)) {
        return Error{ErrorCode::Malformed, "tolerance must be positive", "tolerance"};
    }
    return std::nullopt;
}

}  // namespace

SiteMesh::SiteMesh(const Domain& domain, const Density& density, DomainMesh empty)
    : domain_(&domain), density_(&density), capacity_(domain, density), empty_(std::move(empty)), mesh_(empty_.mesh) {}

Result<SiteMesh> SiteMesh::create(const Domain& domain, const Density& density, const Options& options,
                                  const std::stop_token& stop) {
    if (auto error = check(options)) return tl::unexpected(*error);
    const CapacityIntegral capacity(domain, density);
    if (!(capacity.total() > 0)) {
        return failure(ErrorCode::Unusable, "the density is zero all over the domain", "density");
    }
    auto empty = empty_mesh(domain, capacity, options.sites, stop);
    if (!empty) return tl::unexpected(empty.error());
    SiteMesh sites(domain, density, *std::move(empty));
    const StartSites start(domain, density, options);
    if (auto error = place_sites(sites.mesh_, {}, start, {}, options.seed, domain.resolution(), stop)) {
        return tl::unexpected(*error);
    }
    trim(sites.mesh_);
    return sites;
}

bool SiteMesh::move(std::span<const Point> wanted) {
    const Triangulation before = mesh_;
    const std::span<const Point> from{before.points().data(), wanted.size()};
    for (std::size_t i = 0; i < wanted.size(); ++i) mesh_.points()[i] = end_of_way(from[i], wanted[i]);
    if (is_sound()) {
        restore_delaunay(mesh_);
        if (keeps_margin()) return true;
    }
    if (insert_all(from, wanted)) return true;
    mesh_ = before;
    return false;
}

/// Returns `to`; on a torus, the periodic copy of `to` that is nearest to `from`.
Point SiteMesh::end_of_way(Point from, Point to) const {
    if (!mesh_.is_torus()) return to;
    const PeriodicImages images(*domain_);
    return snapped(from + images.shortest(images.in_box(to) - images.in_box(from)));
}

/// Whether no triangle is inverted, flat, or outside the range in which positions on a torus are exact.
bool SiteMesh::is_sound() const {
    constexpr double kMinShape = 1e-6;  // doubled area relative to the longest edge squared
    constexpr double kMaxCoordinate = 1.25;
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
        const auto [a, b, c] = mesh_.positions(t);
        const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
        if (!(cross(b - a, c - a) > kMinShape * longest)) return false;
    }
    const auto far = [](Point p) { return std::max(std::abs(p.x), std::abs(p.y)) > kMaxCoordinate; };
    return std::ranges::none_of(sites(), far);
}

/// Whether the sites nearest to the border keep the margin. In a Delaunay triangulation, these sites are opposite to
/// the edges of the border.
bool SiteMesh::keeps_margin() const {
    const double margin = domain_->resolution();
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            if (mesh_.twin(Triangulation::edge(t, i)) != Triangulation::kNone) continue;
            const Point edge = mesh_.along(Triangulation::edge(t, i));
            if (mesh_.doubled_area(t) < margin * std::sqrt(dot(edge, edge))) return false;
        }
    }
    return true;
}

/// Triangulates all sites from scratch. Each site is placed at the end of its move. If there is no space, its move is
/// shortened.
/// @returns  false if there is no space for a site
bool SiteMesh::insert_all(std::span<const Point> from, std::span<const Point> to) {
    Triangulation mesh = empty_.mesh;
    const auto insert_step = [&](std::span<const std::uint32_t> step) {
        return std::ranges::all_of(step, [&](auto site) { return insert(mesh, site, from[site], to[site]); });
    };
    if (!for_insertion_steps(to.size(), insert_step)) return false;
    trim(mesh);
    mesh_ = std::move(mesh);
    return true;
}

bool SiteMesh::insert(Triangulation& mesh, std::uint32_t site, Point from, Point to) const {
    constexpr int kHalvings = 60;
    const PeriodicImages images(*domain_);
    const Point way = end_of_way(from, to) - from;
    double share = 1;
    for (int i = 0; i < kHalvings; ++i, share /= 2) {
        if (insert_site(mesh, site, images.in_box(from + share * way), domain_->resolution())) return true;
    }
    return false;
}

double SiteMesh::measure() {
    capacity_.of_triangles(mesh_, capacities_);
    return set_goals(mesh_, capacity_, capacities_, goals_);
}

Distribution SiteMesh::iterate(const Options& options, const Control& control, const std::function<bool()>& step) {
    Distribution result;
    const auto measured = [&] {
        result.trace.push_back(measure());
        if (control.progress) control.progress({result.iterations, options.iterations, result.variation()});
    };
    measured();
    while (result.iterations < options.iterations) {
        if (options.tolerance && result.variation() < *options.tolerance) break;
        const bool moved = !control.stop.stop_requested() && step();
        result.stopped = control.stop.stop_requested();  // a step interrupted by a stop returns false, too
        if (result.stopped || !moved) break;
        ++result.iterations;
        measured();
    }
    result.points = sites_to_user(*domain_, mesh_);
    if (options.keep_mesh) result.mesh = mesh_to_user(*domain_, mesh_, empty_.border);
    return result;
}

}  // namespace ccdt
