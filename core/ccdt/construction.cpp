#include "core/ccdt/construction.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/ccdt/placement.h"

namespace ccdt {

namespace {

tl::unexpected<Error> stopped_at_start() {
    return failure(ErrorCode::Stopped, "stopped before there was a result");
}

}  // namespace

Result<void> check(const Options& options) {
    constexpr std::size_t kMaxSites = std::size_t{1} << 28;   // half-edges are numbered in 32 bits
    constexpr std::uint64_t kSeeds = std::uint64_t{1} << 53;  // a JSON number holds them all
    const auto out_of_range = [](const char* field, const std::string& range) {
        return failure(ErrorCode::Malformed, std::string(field) + " must lie between " + range, field);
    };
    if (options.sites < 1 || options.sites > kMaxSites) {
        return out_of_range("sites", "1 and " + std::to_string(kMaxSites));
    }
    if (options.seed >= kSeeds) return out_of_range("seed", "0 and " + std::to_string(kSeeds - 1));
    if (options.iterations < 0 || options.iterations > 1000) return out_of_range("iterations", "0 and 1000");
    if (options.passes < 1 || options.passes > 100) return out_of_range("passes", "1 and 100");
    if (options.tolerance && !(*options.tolerance > 0)) {
        return failure(ErrorCode::Malformed, "tolerance must be positive", "tolerance");
    }
    return {};
}

bool has_polish(const Options& options) {
    return options.quality != Quality::Draft && options.iterations > 0;
}

Construction::Construction(const Domain& domain, const Density& density, const Options& options,
                           const std::stop_token& stop)
    : domain_(domain), density_(density), options_(options), stop_(stop), capacity_(domain, density) {}

Result<void> Construction::start() {
    if (!(capacity_.total() > 0)) {
        return failure(ErrorCode::Unusable, "the density is zero all over the domain", "density");
    }
    start_.emplace(domain_, density_, options_);
    if (has_polish(options_)) polish_.emplace(domain_, density_, capacity_.total(), options_.sites, stop_);
    if (stopping()) return stopped_at_start();
    auto placed = triangulate_sites(even_start());
    if (!placed) return tl::unexpected(placed.error());
    placed_ = *std::move(placed);
    result_.trace.push_back(measure(placed_->mesh));
    if (stopping()) return stopped_at_start();
    return {};
}

/// @param first  [sites] or empty: where they stand
Result<DomainMesh> Construction::triangulate_sites(const std::vector<Point>& first) {
    auto placed = empty_mesh(domain_, capacity_, options_.sites, stop_);
    if (!placed) return placed;
    if (auto error = place_sites(placed->mesh, first, *start_, options_.seed, domain_.resolution(), stop_)) {
        return tl::unexpected(*error);
    }
    if (stopping()) return stopped_at_start();
    placed->mesh.trim();
    return placed;
}

/// First sites among which long waves are gone; none where nothing is to be gained.
std::vector<Point> Construction::even_start() {
    std::vector<Point> first;
    if (!polish_ || capacity_.is_uniform() || !domain_.is_box()) return first;
    first.reserve(options_.sites);
    for (std::size_t site = 0; site < options_.sites; ++site) first.push_back(start_->draw(site, 0));
    polish_->even_out_start(first, stop_);
    return first;
}

/// @returns  the capacity variation; of no use once a stop is asked for
double Construction::measure(const Triangulation& mesh) {
    capacity_.of_triangles(mesh, capacities_, stop_);
    if (stopping()) return 0;
    return set_goals(mesh, capacity_, capacities_, goals_);
}

/// Tells whether an iteration's passes are exact. These cost more, and matter once the sites are near their places:
/// Distribute.DoesNotStallNextToWhite shows the variation before and after.
bool Construction::is_exact(int iteration) const {
    constexpr int kFirst = 4;
    return !density_.is_smooth() && (iteration >= kFirst || iteration + 1 == options_.iterations);
}

bool Construction::goes_on() const {
    if (stopping() || result_.iterations >= options_.iterations) return false;
    return !(options_.tolerance && variation() < *options_.tolerance);
}

Relaxation& Construction::relaxation() {
    if (relaxation_) return *relaxation_;
    // Rounder triangles, whose areas may vary a little more: after the polish there is less power in long waves than
    // with softer or stiffer springs, benchmark TorusPattern.
    constexpr double kPolishedSpring = 0.03;
    RelaxationOptions settings;
    if (polish_ && density_.is_smooth()) settings.spring = kPolishedSpring;
    settings.least_height = std::max(settings.least_height, domain_.resolution());
    return relaxation_.emplace(placed_->mesh, placed_->border.corner, capacity_.is_uniform(), settings);
}

bool Construction::iterate() {
    Triangulation& mesh = placed_->mesh;
    Relaxation& relaxation = this->relaxation();
    relaxation.prepare(goals_, stop_);
    for (int pass = 0; pass < options_.passes && !stopping(); ++pass) {
        if (is_exact(result_.iterations)) {
            relaxation.exact_pass(capacity_, stop_);
        } else {
            relaxation.pass();
        }
    }
    if (!stopping()) mesh.restore_delaunay(stop_);
    const double variation = measure(mesh);
    if (stopping()) return false;
    result_.trace.push_back(variation);
    ++result_.iterations;
    if (!goes_on()) relaxation_.reset();
    return true;
}

Result<void> Construction::finish() {
    if (stopping()) return {};
    Triangulation& mesh = placed_->mesh;
    mesh.restore_delaunay(stop_);
    std::vector<Point> sites(mesh.points().begin(),
                             mesh.points().begin() + static_cast<std::ptrdiff_t>(options_.sites));
    // Where other sites were in the way of one that had to leave white, all are triangulated anew.
    if (polish_->clear_gaps(sites)) {
        auto again = triangulate_sites(sites);
        if (stopping()) return {};
        if (!again) return tl::unexpected(again.error());
        *placed_ = *std::move(again);
    }
    const double variation = measure(mesh);
    if (!stopping()) result_.polished = variation;
    return {};
}

Distribution Construction::collect() {
    result_.stopped = stopping();
    result_.points = sites_to_user(domain_, placed_->mesh);
    if (options_.keep_mesh) result_.mesh = mesh_to_user(domain_, placed_->mesh, placed_->border);
    return std::move(result_);
}

}  // namespace ccdt
