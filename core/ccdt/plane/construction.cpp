// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/construction.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/ccdt/plane/fixed_choice.h"
#include "core/ccdt/plane/narrow_places.h"
#include "core/ccdt/plane/narrow_rows.h"
#include "core/ccdt/plane/placement.h"
#include "core/ccdt/plane/resettlement.h"
#include "core/ccdt/relax/border.h"
#include "core/mesh/flips.h"
#include "core/mesh/insertion.h"
#include "core/mesh/inside.h"

namespace ccdt {

namespace {

/// Returns the number of sites in the whole grid of a density whose zones sites must not leave; none if they may.
std::optional<double> zoned_sites(const Density& density, const Options& options, const CapacityIntegral& capacity) {
    // In the paper, sites are drawn independently; so with Start::Random, sites are not divided among zones.
    if (!options.keep_steps || options.start == Start::Random || density.is_smooth()) return std::nullopt;
    return static_cast<double>(options.sites) * density.total() / capacity.total();
}

tl::unexpected<Error> stopped_at_start() {
    return failure(ErrorCode::Stopped, "stopped before there was a result");
}

}  // namespace

Result<void> check(const Options& options) {
    constexpr std::size_t kMaxSites = std::size_t{1} << 28;   // half-edges have 32-bit numbers
    constexpr std::uint64_t kSeeds = std::uint64_t{1} << 53;  // a JSON number represents all of them exactly
    const auto check_range = [](const char* field, auto value, auto min, auto max) -> Result<void> {
        if (value >= min && value <= max) return {};
        return failure(ErrorCode::Malformed,
                       std::string(field) + " is " + std::to_string(value) + ", but must be from " +
                           std::to_string(min) + " to " + std::to_string(max),
                       field);
    };
    if (auto sites = check_range("sites", options.sites, std::size_t{1}, kMaxSites); !sites) return sites;
    if (auto seed = check_range("seed", options.seed, std::uint64_t{0}, kSeeds - 1); !seed) return seed;
    if (auto iterations = check_range("iterations", options.iterations, 0, 1000); !iterations) return iterations;
    if (auto passes = check_range("passes", options.passes, 1, 100); !passes) return passes;
    if (options.tolerance && !(*options.tolerance > 0)) {
        return failure(ErrorCode::Malformed, "tolerance must be positive", "tolerance");
    }
    return {};
}

bool has_polish(const Options& options) {
    return options.quality != Quality::Draft && options.iterations > 0;
}

Construction::Construction(const Domain& domain, const Density& density, const Options& options, const Control& control)
    : domain_(domain),
      density_(density),
      options_(options),
      stop_(control.stop),
      executor_(*control.executor),
      capacity_(domain, density),
      support_(domain, density, zoned_sites(density, options, capacity_)) {}

Result<void> Construction::start() {
    if (!(capacity_.total() > 0)) {
        return failure(ErrorCode::Unusable, "the density is zero all over the domain", "density");
    }
    if (auto chosen = choose_fixed(); !chosen) return chosen;
    auto first = even_start();
    if (stopping()) return stopped_at_start();
    auto placed = triangulate_sites(std::move(first));
    if (!placed) return tl::unexpected(placed.error());
    placed_ = *std::move(placed);
    result_.trace.push_back(measure(placed_->mesh));
    if (stopping()) return stopped_at_start();
    return {};
}

/// Returns the share of the domain's capacity that each site should have.
double Construction::site_share() const {
    return 1 / (fixed_.sites > 0 ? fixed_.sites : static_cast<double>(options_.sites));
}

Result<void> Construction::choose_fixed() {
    const std::vector<Point>& points = start_sites().fixed();
    if (points.empty()) return {};
    fixed_.sites = start_->fixed_area().sites;
    double densest = capacity_.total() / domain_.unit_area();
    for (const Point& p : points) densest = std::max(densest, capacity_.at(p));
    const double spacing = std::sqrt(capacity_.total() * site_share() / densest);
    auto trial = mesh_for(points.size());
    if (!trial) return tl::unexpected(trial.error());
    const double sites = fixed_.sites;
    fixed_ = ccdt::choose_fixed(domain_, points, start_->fixed_area().weights, spacing, trial->mesh);
    fixed_.sites = sites;
    return {};
}

/// Returns the mesh of the border, to which the sites and `fixed` further vertices can be added.
Result<DomainMesh> Construction::mesh_for(std::size_t fixed) const {
    if (fixed == 0 || domain_.is_torus()) return empty_mesh(domain_, capacity_, options_.sites + fixed, stop_);
    const auto all = static_cast<std::size_t>(std::ceil(1 / site_share()));
    return empty_mesh(domain_, make_border(domain_, capacity_, all), options_.sites + fixed, stop_);
}

/// Triangulates the border, the fixed points and the sites.
/// @param first  [sites] preferred positions; empty if all positions are drawn
Result<DomainMesh> Construction::triangulate_sites(std::vector<Point> first) {
    auto placed = mesh_for(fixed_.positions.size());
    if (!placed) return placed;
    placed->mesh.set_executor(executor_);
    placed->mesh.fix_last(fixed_.positions.size());
    for (std::size_t i = 0; i < fixed_.positions.size(); ++i)
        insert_site(placed->mesh, static_cast<std::uint32_t>(options_.sites + i), fixed_.positions[i]);
    // In the paper, sites are drawn independently; so with Start::Random, sites are not divided among parts.
    const bool shares_out =
        placed->mesh.part_count() > 1 && options_.start != Start::Random && first.empty() && fixed_.sites == 0;
    auto vacancies = shares_out ? sites_of_parts(*placed, capacity_) : std::vector<std::size_t>{};
    if (auto error = place_sites(placed->mesh, first, start_sites(), std::move(vacancies), options_.seed,
                                 domain_.resolution(), stop_)) {
        return tl::unexpected(*error);
    }
    if (stopping()) return stopped_at_start();
    first = std::vector<Point>();
    start_.reset();
    trim(placed->mesh);
    return placed;
}

const StartSites& Construction::start_sites() {
    return start_ ? *start_ : start_.emplace(domain_, density_, options_, &support_);
}

MeshPolish& Construction::polish() {
    return polish_ ? *polish_
                   : polish_.emplace(domain_, density_, capacity_.total(), options_.sites, support_, fixed_, stop_,
                                     executor_);
}

/// Returns initial sites without long waves of density error; empty in polygons, at uniform density or without polish.
std::vector<Point> Construction::even_start() {
    std::vector<Point> first;
    if (!has_polish(options_) || capacity_.is_uniform() || !domain_.is_box()) return first;
    constexpr std::size_t kSites = 4096;  // sites per task
    const StartSites& start = start_sites();
    first.resize(options_.sites);
    for_ranges(executor_, options_.sites, kSites, [&](std::size_t begin, std::size_t end) {
        for (std::size_t site = begin; site < end; ++site) first[site] = start.draw(site, 0);
    });
    polish().even_out_start(first, stop_);
    polish().release_memory();
    return first;
}

/// Measures capacities, sets goals, and returns the capacity variation. After a stop, the result must not be used.
double Construction::measure(const Triangulation& mesh) {
    const double total = fixed_.sites > 0 ? site_share() * static_cast<double>(mesh.site_count()) * capacity_.total()
                                          : capacity_.total();
    if (capacity_.is_uniform()) return set_even_goals(mesh, total, goals_, in_row_);
    std::vector<double> capacities = goals_.release_weights();
    capacity_.of_triangles(mesh, capacities, stop_);
    if (stopping()) return 0;
    return set_goals(mesh, total, capacity_.densest(), std::move(capacities), goals_, in_row_);
}

/// Whether an iteration uses exact passes. Exact passes cost more, and help only once the sites are near their final
/// positions: test Distribute.DoesNotStallNextToWhite.
bool Construction::is_exact(int iteration) const {
    constexpr int kFirst = 4;
    return !density_.is_smooth() && (iteration >= kFirst || iteration + 1 == options_.iterations);
}

bool Construction::has_next_iteration() const {
    if (stopping() || result_.iterations >= options_.iterations) return false;
    return !(options_.tolerance && variation() < *options_.tolerance);
}

Relaxation& Construction::relaxation() {
    if (relaxation_) return *relaxation_;
    // Longer moves give more equal triangles and less power in long waves, but worse tone where the density varies.
    constexpr double kSmoothRelaxation = 1.3;
    RelaxationOptions settings;
    if (density_.is_smooth()) {
        settings.relaxation = kSmoothRelaxation;
        if (has_polish(options_)) settings.spring = kPolishedSpring;
    }
    if (fixed_.sites > 0) settings.site_share = site_share();
    settings.least_height = std::max(settings.least_height, domain_.resolution());
    if (support_.zones() > 1) {
        settings.fence = [this](std::uint32_t site, Point to) {
            return support_.nearest_in_zone(placed_->mesh.point(site), to);
        };
    }
    return relaxation_.emplace(placed_->mesh, placed_->border.corner, capacity_.is_uniform(), settings);
}

bool Construction::iterate() {
    Triangulation& mesh = placed_->mesh;
    Relaxation& relaxation = this->relaxation();
    if (is_exact(result_.iterations)) {
        relaxation.prepare_exact(std::move(goals_), stop_);
        pass_exactly(relaxation);
    } else {
        relaxation.prepare(std::move(goals_), stop_);
        relaxation.pass(options_.passes, stop_);
    }
    goals_ = relaxation.take_goals();
    if (!stopping()) restore_delaunay(mesh, stop_);
    double variation = measure(mesh);
    if (stopping()) return false;
    if (resettles() && Resettlement(mesh, goals_, domain_.resolution()).even_out() > 0) {
        relaxation_.reset();
        variation = measure(mesh);
    }
    result_.trace.push_back(variation);
    ++result_.iterations;
    if (has_next_iteration()) return true;
    relaxation_.reset();
    goals_ = {};
    return true;
}

void Construction::pass_exactly(Relaxation& relaxation) {
    // Measuring before every pass, instead of every third, gives the same variation and tone: benchmark PictureTone.
    constexpr int kMeasured = 3;  // passes between measurements
    for (int pass = 0; pass < options_.passes; pass += kMeasured) {
        relaxation.measure(capacity_, stop_);
        if (stopping()) return;
        relaxation.exact_pass(std::min(kMeasured, options_.passes - pass), stop_);
    }
}

/// Whether single sites are relocated after the current iteration. In polygons, this is done after the third iteration,
/// or the last one if there are fewer. Before the third iteration, a local surplus of sites can be due to sites that
/// are still moving. After the third iteration, there are usually further iterations to correct the capacities.
bool Construction::resettles() const {
    constexpr int kIteration = 2;
    return result_.iterations == std::min(kIteration, options_.iterations - 1) && has_polish(options_) &&
           density_.is_smooth() && !domain_.is_box() && fixed_.sites == 0;
}

void Construction::separate(std::span<const std::array<std::uint32_t, 2>> pairs) {
    if (support_.zones() > 1) return;  // a relocated site could leave its zone
    Triangulation& mesh = placed_->mesh;
    restore_delaunay(mesh, stop_);
    measure(mesh);
    if (stopping()) return;
    Resettlement resettlement(mesh, goals_, domain_.resolution());
    for (const auto& pair : pairs) resettlement.separate(pair);
}

void Construction::equalise(int passes) {
    Triangulation& mesh = placed_->mesh;
    restore_delaunay(mesh, stop_);
    measure(mesh);
    if (stopping()) return;
    relaxation().prepare(std::move(goals_), stop_);
    relaxation().pass(passes, stop_);
    relaxation_.reset();
}

Result<void> Construction::finish() {
    if (stopping()) return {};
    polish_.reset();
    const bool polished = has_polish(options_);
    if (polished) restore_delaunay(placed_->mesh, stop_);
    const auto moved = move_single_sites();
    if (!moved) return tl::unexpected(moved.error());
    if (stopping() || !(polished || *moved)) return {};
    const double variation = measure(placed_->mesh);
    goals_ = {};
    if (stopping()) return {};
    (polished ? result_.polished.emplace() : result_.trace.back()) = variation;
    return {};
}

/// Evens out sites where the domain is narrower than their spacing, and moves sites from positions of density zero to
/// the nearest position with a positive density. If any site moves, triangulates all sites anew.
/// @returns  whether any site moved
Result<bool> Construction::move_single_sites() {
    constexpr double kAnywhere = 1;  // covers the box
    const bool is_narrow =
        !domain_.is_torus() && fixed_.sites == 0 && options_.iterations > 0 && has_narrow_places(placed_->mesh);
    const bool clears_gaps = support_.has_gaps() && (has_polish(options_) || options_.keep_steps);
    if (!is_narrow && !clears_gaps) return false;
    const auto all = placed_->mesh.points().begin();
    std::vector<Point> sites(all, all + static_cast<std::ptrdiff_t>(options_.sites));
    bool moved = false;
    if (is_narrow) {
        in_row_ = even_out_narrow_places(domain_, capacity_, sites, capacity_.total() * site_share(), stop_);
        moved = !in_row_.empty();
    }
    if (clears_gaps) {
        for (Point& site : sites) {
            const Point corner = support_.box_corner(site), position = site - corner;
            const Point to = support_.nearest(position, kAnywhere);
            if (to == position) continue;
            site = domain_.is_torus() ? snapped(corner + to) : to;
            moved = true;
        }
    }
    if (!moved || stopping()) return false;
    auto again = triangulate_sites(std::move(sites));
    if (stopping()) return false;
    if (!again) return tl::unexpected(again.error());
    *placed_ = *std::move(again);
    return true;
}

Distribution Construction::collect() {
    result_.stopped = stopping();
    result_.points = sites_to_user(domain_, placed_->mesh);
    result_.points.resize(options_.sites);
    if (options_.keep_mesh) result_.mesh = mesh_to_user(domain_, placed_->mesh, placed_->border);
    return std::move(result_);
}

}  // namespace ccdt
