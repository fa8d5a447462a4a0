// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/odt.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/baselines/site_mesh.h"
#include "core/mesh/flips.h"
#include "core/mesh/move_guard.h"

namespace ccdt {

namespace {

/// Moves each site to the weighted mean of the circumcentres of the triangles around it, pass by pass.
class Circumcentres {
public:
    Circumcentres(SiteMesh& sites, const std::stop_token& stop)
        : sites_(sites), mesh_(sites.mesh()), stop_(stop), least_height_(std::max(1e-9, sites.domain().resolution())) {}

    /// @returns  false if no site moves
    bool step();

private:
    /// A triangle at the site: vectors to its other corners, counter-clockwise, and the weight of its area.
    struct Corner {
        Point from, to;
        double weight;
    };

    void weigh();
    bool touches_border(std::uint32_t triangle) const;
    void look_around(std::uint32_t site);
    Point way_to_mean() const;
    bool fits(Point by) const;
    bool move(std::uint32_t site);

    SiteMesh& sites_;
    Triangulation& mesh_;
    const std::stop_token& stop_;
    double least_height_;
    std::vector<double> capacities_;  ///< [triangles]
    std::vector<double> weights_;     ///< [triangles] weight of each triangle's area
    std::vector<Corner> around_;
    bool is_alone_ = false;  ///< whether the site is its own neighbour, as on a torus with few sites
};

bool Circumcentres::step() {
    constexpr std::uint32_t kStopStride = 65536;
    weigh();
    bool moves = false;
    for (std::uint32_t site = 0; site < mesh_.site_count(); ++site) {
        if (site % kStopStride == 0 && stop_.stop_requested()) break;
        moves |= move(site);
    }
    restore_delaunay(mesh_);
    return moves;
}

void Circumcentres::weigh() {
    // Benchmark OdtBorderPattern: with 1.5, there are too few sites within one and a half spacings of the border; with
    // 3, there are too many within one spacing.
    constexpr double kBorderWeight = 2;
    const CapacityIntegral& capacity = sites_.capacity();
    if (!capacity.is_uniform()) capacity.of_triangles(mesh_, capacities_);
    weights_.assign(mesh_.triangle_count(), 1);
    for (std::uint32_t t = 0; t < weights_.size(); ++t) {
        if (!capacity.is_uniform()) {
            const double most = 0.5 * mesh_.doubled_area(t) * capacity.densest();
            // A flat triangle contributes nothing.
            const double mean = most > 0 ? std::max(0.0, capacities_[t]) / most : 1;
            weights_[t] = mean * std::sqrt(mean);
        }
        if (touches_border(t)) weights_[t] *= kBorderWeight;
    }
}

bool Circumcentres::touches_border(std::uint32_t triangle) const {
    return std::ranges::any_of(mesh_.corners(triangle), [this](std::uint32_t v) { return !mesh_.is_site(v); });
}

void Circumcentres::look_around(std::uint32_t site) {
    around_.clear();
    is_alone_ = false;
    const std::uint32_t first = mesh_.edge_of(site);
    std::uint32_t h = first;
    do {
        const std::uint32_t last = Triangulation::previous(h);
        is_alone_ |= mesh_.target(h) == site;
        around_.push_back({mesh_.along(h), Point{} - mesh_.along(last), weights_[Triangulation::triangle_of(h)]});
        h = mesh_.twin(last);
    } while (h != first);
}

/// Returns the vector from the site to the weighted mean of the circumcentres. The product of a triangle's circumcentre
/// and its area is a polynomial in its corners, so no division per triangle is needed.
Point Circumcentres::way_to_mean() const {
    double area = 0;
    Point moment;
    for (const auto& [p, q, weight] : around_) {
        const double pp = dot(p, p), qq = dot(q, q);
        area += weight * 2 * cross(p, q);
        moment = moment + weight * Point{q.y * pp - p.y * qq, p.x * qq - q.x * pp};
    }
    return area > 0 ? 1 / area * moment : Point{};
}

/// Whether every triangle keeps at least a tenth of its area and does not become a needle.
bool Circumcentres::fits(Point by) const {
    return std::ranges::all_of(around_, [&](const Corner& corner) {
        const Point from = corner.from - by, to = corner.to - by;
        const double before = cross(corner.from, corner.to);
        return cross(from, to) >=
               std::max(kKeptShare * before, std::min(needle_area({}, from, to, least_height_), before));
    });
}

bool Circumcentres::move(std::uint32_t site) {
    constexpr int kHalvings = 8;
    constexpr double kRest = 1e-12;  // in the unit frame; smaller moves are rounding errors
    look_around(site);
    if (is_alone_) return false;
    Point by = way_to_mean();
    for (int i = 0; i < kHalvings; ++i, by = 0.5 * by) {
        const Point from = mesh_.point(site);
        const Point to = mesh_.is_torus() ? snapped(from + by) : from + by;
        if (dot(to - from, to - from) < kRest * kRest) return false;
        if (!fits(to - from)) continue;
        mesh_.points()[site] = to;
        return true;
    }
    return false;
}

}  // namespace

Result<Distribution> odt(const Domain& domain, const Density& density, const Options& options, const Control& control) {
    auto sites = SiteMesh::create(domain, density, options, control.stop);
    if (!sites) return tl::unexpected(sites.error());
    Circumcentres circumcentres(*sites, control.stop);
    return sites->iterate(options, control, [&] { return circumcentres.step(); });
}

}  // namespace ccdt
