// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/globe.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/ccdt/globe/chart.h"
#include "core/ccdt/globe/clearance.h"
#include "core/ccdt/globe/inverse_projection.h"
#include "core/ccdt/globe/plane_density.h"
#include "core/ccdt/globe/region.h"
#include "core/ccdt/plane/start.h"

namespace ccdt {

namespace {

/// Divides the sites among the parts in proportion to the integrals of the parts' densities.
/// @param taken  [parts] ground that fixed points take, as a number of sites that would fit there
std::vector<std::size_t> shared_out(std::size_t sites, const std::vector<PlaneDensity>& densities,
                                    const std::vector<double>& taken) {
    double all = 0, positions = static_cast<double>(sites);
    for (const PlaneDensity& each : densities) all += each.total;
    for (const double each : taken) positions += each;
    std::vector<std::size_t> shares(densities.size());
    std::size_t remaining = sites;
    for (std::size_t i = densities.size(); i-- > 1;) {
        const double share = all > 0 ? std::max(0.0, densities[i].total / all * positions - taken[i]) : 0;
        shares[i] = std::min(remaining, static_cast<std::size_t>(std::lround(share)));
        remaining -= shares[i];
    }
    shares.front() = remaining;
    return shares;
}

/// Returns the options of each part. The numbers of sites are proportional to the ground that fixed points leave, so
/// that the density is the same in all parts.
std::vector<Options> options_of_parts(const std::vector<ChartedPart>& parts, const std::vector<PlaneDensity>& densities,
                                      const Options& options, const std::stop_token& stop) {
    constexpr int kRounds = 3;  // the ground that a fixed point takes depends weakly on the number of sites
    std::vector<Options> own(parts.size(), options);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        for (Point& p : own[i].fixed) p = parts[i].chart.to_plane(direction_of(p));
    }
    std::vector<double> taken(parts.size(), 0);
    const bool shares_ground = parts.size() > 1 && !options.fixed.empty();
    for (int round = 0;; ++round) {
        const auto shares = shared_out(options.sites, densities, taken);
        for (std::size_t i = 0; i < parts.size(); ++i) own[i].sites = shares[i];
        if (!shares_ground || round == kRounds || stop.stop_requested()) return own;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            if (!(densities[i].total > 0)) continue;
            Options some = own[i];
            some.sites = std::max<std::size_t>(1, some.sites);
            const double in_sites = StartSites(parts[i].domain, densities[i].density, some).fixed_area().sites;
            taken[i] = in_sites - static_cast<double>(some.sites);
        }
    }
}

void to_degrees(const Chart& chart, const InverseProjection& back, Distribution& placed) {
    for (Point& p : placed.points) p = back(chart, p);
    if (!placed.mesh) return;
    std::vector<Point>& vertices = placed.mesh->vertices;
    const auto sites = static_cast<std::ptrdiff_t>(placed.points.size());
    std::ranges::copy(placed.points, vertices.begin());
    for (Point& p : std::span(vertices.begin() + sites, vertices.end())) p = position_of(chart.to_direction(p));
}

/// Joins two meshes. In both meshes, and in the result, sites come before other vertices.
TriangleMesh joined(TriangleMesh a, std::size_t a_sites, const TriangleMesh& b, std::size_t b_sites) {
    const auto a_size = static_cast<std::uint32_t>(a.vertices.size());
    const auto from_a = [&](std::uint32_t v) { return v < a_sites ? v : v + static_cast<std::uint32_t>(b_sites); };
    const auto from_b = [&](std::uint32_t v) {
        return v < b_sites ? v + static_cast<std::uint32_t>(a_sites) : v + a_size;
    };
    const auto move = [](auto& lists, auto mapped) {
        for (auto& list : lists) {
            for (auto& v : list) v = mapped(v);
        }
    };
    TriangleMesh rest = b;
    move(a.triangles, from_a);
    move(a.boundary, from_a);
    move(rest.triangles, from_b);
    move(rest.boundary, from_b);
    const auto sites_of = [](std::vector<Point>& vertices, std::size_t sites) {
        return vertices.begin() + static_cast<std::ptrdiff_t>(sites);
    };
    a.vertices.insert(sites_of(a.vertices, a_sites), rest.vertices.begin(), sites_of(rest.vertices, b_sites));
    a.vertices.insert(a.vertices.end(), sites_of(rest.vertices, b_sites), rest.vertices.end());
    a.triangles.insert(a.triangles.end(), rest.triangles.begin(), rest.triangles.end());
    a.boundary.insert(a.boundary.end(), rest.boundary.begin(), rest.boundary.end());
    return a;
}

Distribution joined(Distribution a, Distribution b) {
    if (a.mesh && b.mesh) a.mesh = joined(*std::move(a.mesh), a.points.size(), *b.mesh, b.points.size());
    a.points.insert(a.points.end(), b.points.begin(), b.points.end());
    a.stopped = a.stopped || b.stopped;
    return a;
}

}  // namespace

Result<GlobeDistribution> distribute_on_globe(const Domain& region, const Density& density, const Options& options,
                                              const Distribute& distribute, double buffer, const Control& control) {
    const auto turned = in_one_turn(region, control.stop);
    if (!turned) return tl::unexpected(turned.error());
    const Domain& degrees = *turned;
    auto parts = chart_region(degrees, options.sites, buffer, control.stop);
    if (!parts) return tl::unexpected(parts.error());
    for (ChartedPart& part : *parts) {
        if (auto kept = keep_off_border(part, buffer, control.stop); !kept) return tl::unexpected(kept.error());
    }
    std::vector<PlaneDensity> densities;
    double ground = 0;
    for (const ChartedPart& part : *parts) {
        auto own = plane_density(part, degrees, density, options.sites, control.stop);
        if (!own) return tl::unexpected(own.error());
        densities.push_back(*std::move(own));
        auto bare = density.is_uniform()
                        ? Result<PlaneDensity>(densities.back())
                        : plane_density(part, degrees, Density::uniform(), options.sites, control.stop);
        if (!bare) return tl::unexpected(bare.error());
        ground += bare->total;
    }
    const auto own = options_of_parts(*parts, densities, options, control.stop);
    const InverseProjection back(degrees);
    std::optional<Distribution> all;
    for (std::size_t i = 0; i < parts->size(); ++i) {
        if (own[i].sites == 0) continue;
        const ChartedPart& part = (*parts)[i];
        auto placed = distribute(part.domain, densities[i].density, own[i], control);
        if (!placed) return tl::unexpected(placed.error());
        to_degrees(part.chart, back, *placed);
        all = all ? joined(*std::move(all), *std::move(placed)) : *std::move(placed);
    }
    return GlobeDistribution{*std::move(all), std::sqrt(ground / static_cast<double>(options.sites))};
}

}  // namespace ccdt
