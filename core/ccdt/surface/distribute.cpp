// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/distribute.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/ccdt/plane/narrow_rows.h"
#include "core/ccdt/polish/cell_list.h"
#include "core/ccdt/polish/schedule.h"
#include "core/ccdt/polish/settings.h"
#include "core/ccdt/surface/crease_vertices.h"
#include "core/ccdt/surface/initial_sites.h"
#include "core/ccdt/surface/narrow_strips.h"
#include "core/ccdt/surface/site_polish.h"
#include "core/ccdt/surface/site_relaxation.h"
#include "core/ccdt/surface/surface_triangulation.h"
#include "core/geometry/hexagonal_spacing.h"

namespace ccdt {

namespace {

/// Distance of two fixed points, relative to the hexagonal distance, below which only the first one is used.
constexpr double kSameFixed = 0.25;
/// Distance of two fixed points, relative to the hexagonal distance, below which they share the area of one site.
constexpr double kClusteredFixed = 0.7;

double total_mass(const Surface& surface, const SurfaceDensity& density) {
    double mass = 0;
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) mass += density.mass(surface, f);
    return mass;
}

/// A distribution that is being computed.
class Distributor {
public:
    Distributor(const Surface& surface, const SurfaceDensity& density, const SurfaceOptions& options,
                const Control& control)
        : surface_(surface), density_(density), options_(options), control_(control) {}

    Result<SurfaceDistribution> execute() {
        const double mass = total_mass(surface_, density_);
        if (!(mass > 0)) return failure(ErrorCode::Unusable, "the density is 0 everywhere on the surface", "density");
        start(mass);
        if (stopping()) return failure(ErrorCode::Stopped, "stopped before the first result");
        SiteRelaxation relaxation(*mesh_, density_, capacity_);
        result_.trace.push_back(relaxation.variation());
        report();
        while (result_.iterations < options_.iterations && !stopping()) {
            relaxation.pass(options_.passes, control_.stop);
            mesh_->restore_delaunay(control_.stop);
            if (stopping()) break;
            ++result_.iterations;
            result_.trace.push_back(relaxation.variation());
            report();
        }
        NarrowSites narrow = narrow_sites();
        // Where all sites lie in rows, they are final.
        if (settings_ && !stopping() && !narrow.are_all_moved()) {
            if (auto spread = polish(relaxation)) replace_mesh(*std::move(spread));
            result_.polished = relaxation.variation();
            narrow = narrow_sites();
        }
        strips_.reset();
        if (narrow.is_any_moved() && replace_mesh(std::move(narrow.points))) {
            (settings_ ? result_.polished.emplace() : result_.trace.back()) = relaxation.variation(narrow.moved);
            report();
        }
        result_.stopped = stopping();
        collect();
        return std::move(result_);
    }

private:
    bool stopping() const { return control_.stop.stop_requested(); }

    /// Draws and triangulates the initial sites.
    void start(double mass) {
        if (options_.quality != Quality::Draft && options_.iterations > 0)
            settings_ = surface_settings(options_.quality);
        const double all = static_cast<double>(options_.sites + options_.fixed.size());
        auto fixed = thinned_fixed(mass / all);
        // A cluster of fixed points has the area of one site, so that it leaves the other sites their areas.
        const std::size_t shares = options_.sites + apart(fixed, kClusteredFixed, mass / all).size();
        capacity_ = mass / static_cast<double>(shares);
        auto sites = without_nearest(initial_sites(surface_, density_, shares, options_.seed), fixed);
        sites.insert(sites.end(), fixed.begin(), fixed.end());
        if (stopping()) return;
        mesh_.emplace(triangulated(std::move(sites), fixed.size()));
    }

    SurfaceTriangulation triangulated(std::vector<SurfacePoint> sites, std::size_t fixed) const {
        const auto creases = choose_crease_vertices(surface_, spacings_at_vertices(), options_.sites);
        return {
            surface_, std::move(sites),   fixed,        [this](const SurfacePoint& p) { return spacing(p, capacity_); },
            creases,  *control_.executor, control_.stop};
    }

    /// @returns  new points of all sites, if some sites could be moved apart only without the triangulation
    std::optional<std::vector<SurfacePoint>> polish(SiteRelaxation& relaxation) {
        SitePolish steps(*mesh_, density_, capacity_, relaxation, control_.stop);
        const double least = settings_->least;
        // Where the surface is folded, pushes cannot move all pairs apart, so sites are relocated. The rounds of the
        // polish then remove the error of density that the relocation causes.
        if (steps.is_any_nearer(least)) steps.separate(least);
        run_schedule(*settings_, steps, control_.stop, [this] { ++round_, report(); });
        mesh_->restore_delaunay(control_.stop);
        steps.is_any_nearer(least);
        return stopping() ? std::nullopt : steps.spread(least);
    }

    /// Sites that are evened out where the surface is narrower than their spacing.
    struct NarrowSites {
        std::vector<SurfacePoint> points;  ///< [sites]
        std::vector<std::uint8_t> moved;   ///< [sites] whether each one moves; empty: none does

        bool is_any_moved() const { return !moved.empty(); }
        bool are_all_moved() const { return is_any_moved() && std::ranges::find(moved, 0) == moved.end(); }
    };

    NarrowSites narrow_sites() {
        if (options_.iterations == 0 || stopping() || !options_.fixed.empty() || !has_narrow_places(*mesh_)) return {};
        NarrowSites sites;
        for (std::uint32_t v = 0; v < options_.sites; ++v) sites.points.push_back(mesh_->on_surface(v));
        if (!strips_) {
            strips_.emplace(surface_, density_, capacity_, spacings_at_vertices(), options_.sites, *control_.executor,
                            control_.stop);
        }
        sites.moved = strips_->even_out(sites.points, control_.stop);
        return sites;
    }

    /// Triangulates sites anew.
    /// @returns  false after a stop, without any change
    bool replace_mesh(std::vector<SurfacePoint> sites) {
        SurfaceTriangulation mesh = triangulated(std::move(sites), mesh_->site_count() - mesh_->free_count());
        if (!stopping()) *mesh_ = std::move(mesh);
        return !stopping();
    }

    double spacing(const SurfacePoint& point, double capacity) const {
        constexpr double kMax = 1e6;  // more, even infinity, is due to a density of almost 0
        const double density = density_.at(point);
        return density > 0 ? std::min(hexagonal_spacing(density / capacity), kMax) : std::sqrt(surface_.total_area());
    }

    std::vector<double> spacings_at_vertices() const {
        std::vector<double> spacings(surface_.vertex_count(), 0);
        for (std::uint32_t f = 0; f < surface_.face_count(); ++f) {
            for (std::uint32_t i = 0; i < 3; ++i) {
                double& least = spacings[surface_.corners(f)[i]];
                const double here = spacing(SurfacePoint::corner(f, i), capacity_);
                least = least > 0 ? std::min(least, here) : here;
            }
        }
        return spacings;
    }

    /// Returns points that are at least `least` apart, relative to the hexagonal distance: each point that is far
    /// enough from the points chosen before it.
    std::vector<SurfacePoint> apart(const std::vector<SurfacePoint>& points, double least, double capacity) const {
        std::vector<SurfacePoint> chosen;
        if (points.empty()) return chosen;
        std::vector<Point3> positions;
        positions.reserve(points.size());
        for (const SurfacePoint& point : points) positions.push_back(surface_.position(point));
        const BasicCellList<Point3> cells(positions);
        std::vector<std::uint8_t> is_chosen(points.size(), 0);
        for (std::uint32_t i = 0; i < points.size(); ++i) {
            const double reach = least * spacing(points[i], capacity);
            bool is_near = false;
            cells.for_near(positions[i], reach, [&](Point3 position, std::uint32_t other) {
                is_near = is_near || (is_chosen[other] != 0 && length(position - positions[i]) < reach);
            });
            if (is_near) continue;
            is_chosen[i] = 1;
            chosen.push_back(points[i]);
        }
        return chosen;
    }

    std::vector<SurfacePoint> thinned_fixed(double capacity) const {
        std::vector<SurfacePoint> points;
        for (const Point3& each : options_.fixed) {
            if (stopping()) break;
            points.push_back(surface_.nearest(surface_.from_input(each)));
        }
        return apart(points, kSameFixed, capacity);
    }

    /// Removes the initial site that is nearest to each fixed point, until the wanted number of sites is left.
    std::vector<SurfacePoint> without_nearest(std::vector<SurfacePoint> sites,
                                              const std::vector<SurfacePoint>& fixed) const {
        if (sites.size() == options_.sites) return sites;
        std::vector<Point3> positions;
        positions.reserve(sites.size());
        for (const SurfacePoint& site : sites) positions.push_back(surface_.position(site));
        const BasicCellList<Point3> cells(positions);
        std::vector<std::uint8_t> is_removed(sites.size(), 0);
        std::size_t remaining = sites.size() - options_.sites;
        for (std::size_t i = 0; i < fixed.size() && remaining > 0; ++i) {
            const Point3 position = surface_.position(fixed[i]);
            std::uint32_t nearest = Surface::kNone;
            double least = 0;
            for (double reach = spacing(fixed[i], capacity_); nearest == Surface::kNone && reach < 64; reach *= 2) {
                cells.for_near(position, reach, [&](Point3 other, std::uint32_t number) {
                    const double distance = length(other - position);
                    if (is_removed[number] != 0 || (nearest != Surface::kNone && distance >= least)) return;
                    nearest = number;
                    least = distance;
                });
            }
            if (nearest == Surface::kNone) break;
            is_removed[nearest] = 1;
            --remaining;
        }
        std::vector<SurfacePoint> kept;
        for (std::size_t i = 0; i < sites.size(); ++i) {
            if (is_removed[i] == 0 && kept.size() < options_.sites) kept.push_back(sites[i]);
        }
        return kept;
    }

    void report() const {
        if (!control_.progress) return;
        control_.progress({result_.iterations, options_.iterations, result_.variation(), round_,
                           settings_ ? settings_->all_rounds() : 0});
    }

    void collect() {
        for (std::uint32_t v = 0; v < options_.sites; ++v) result_.points.push_back(mesh_->on_surface(v));
        if (!options_.keep_mesh) return;
        SurfaceMesh& made = result_.mesh.emplace();
        for (std::uint32_t v = 0; v < mesh_->vertex_count(); ++v)
            made.vertices.push_back(surface_.to_input(mesh_->point(v)));
        for (std::uint32_t t = 0; t < mesh_->triangle_count(); ++t) made.triangles.push_back(mesh_->corners(t));
    }

    const Surface& surface_;
    const SurfaceDensity& density_;
    const SurfaceOptions& options_;
    const Control& control_;
    std::optional<PolishSettings> settings_;  ///< none if there is no polish
    double capacity_ = 0;                     ///< integral of the density that belongs to each site
    std::optional<SurfaceTriangulation> mesh_;
    std::optional<NarrowStrips> strips_;  ///< made when they are needed
    SurfaceDistribution result_;
    int round_ = 0;
};

}  // namespace

Result<SurfaceDistribution> distribute_on_surface(const Surface& surface, const SurfaceDensity& density,
                                                  const SurfaceOptions& options, const Control& control) {
    return Distributor(surface, density, options, control).execute();
}

}  // namespace ccdt
