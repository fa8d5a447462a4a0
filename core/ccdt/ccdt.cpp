#include "core/ccdt/ccdt.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/ccdt/capacity.h"
#include "core/ccdt/domain_mesh.h"
#include "core/ccdt/goals.h"
#include "core/ccdt/placement.h"
#include "core/ccdt/relaxation.h"
#include "core/ccdt/start.h"
#include "core/mesh/triangulation.h"
#include "core/polish/polish.h"

namespace ccdt {

namespace {

std::optional<Error> check(const Options& options) {
    constexpr std::size_t kMaxSites = std::size_t{1} << 28;   // half-edges are numbered in 32 bits
    constexpr std::uint64_t kSeeds = std::uint64_t{1} << 53;  // a JSON number holds them all
    const auto out_of_range = [](const char* field, const std::string& range) {
        return Error{ErrorCode::Malformed, std::string(field) + " must lie between " + range, field};
    };
    if (options.sites < 1 || options.sites > kMaxSites) {
        return out_of_range("sites", "1 and " + std::to_string(kMaxSites));
    }
    if (options.seed >= kSeeds) return out_of_range("seed", "0 and " + std::to_string(kSeeds - 1));
    if (options.iterations < 0 || options.iterations > 1000) return out_of_range("iterations", "0 and 1000");
    if (options.passes < 1 || options.passes > 100) return out_of_range("passes", "1 and 100");
    if (options.tolerance && !(*options.tolerance > 0)) {
        return Error{ErrorCode::Malformed, "tolerance must be positive", "tolerance"};
    }
    return std::nullopt;
}

tl::unexpected<Error> stopped_at_start() {
    return failure(ErrorCode::Stopped, "stopped before there was a result");
}

/// One computation of distribute().
class Run {
public:
    Run(const Domain& domain, const Density& density, const Options& options, const Control& control)
        : domain_(domain), density_(density), options_(options), control_(control), capacity_(domain, density) {}

    Result<Distribution> execute();

private:
    bool stopping() const { return control_.stop.stop_requested(); }
    Result<DomainMesh> triangulate_sites(const std::vector<Point>& first, const StartSites& start);
    std::vector<Point> even_start(const StartSites& start);
    double measure(const Triangulation& mesh);
    void iterate(Triangulation& mesh, std::vector<bool> corners);
    bool is_exact(int iteration) const;
    PolishOptions polish_options() const;
    Result<void> refine(DomainMesh& placed, const StartSites& start);
    void report() const;
    void collect(const DomainMesh& placed);

    const Domain& domain_;
    const Density& density_;
    const Options& options_;
    const Control& control_;
    Capacity capacity_;
    std::optional<Polish> polish_;
    std::vector<double> capacities_;   ///< [triangles]
    std::vector<TriangleGoal> goals_;  ///< [triangles]
    Distribution result_;
};

Result<Distribution> Run::execute() {
    if (!(capacity_.total() > 0)) {
        return failure(ErrorCode::Unusable, "the density is zero all over the domain", "density");
    }
    const StartSites start(domain_, density_, options_);
    if (options_.quality != Quality::Draft && options_.iterations > 0) {
        polish_.emplace(domain_, density_, options_.sites, control_.stop);
    }
    if (stopping()) return stopped_at_start();
    auto placed = triangulate_sites(even_start(start), start);
    if (!placed) return tl::unexpected(placed.error());
    result_.trace.push_back(measure(placed->mesh));
    if (stopping()) return stopped_at_start();
    report();
    iterate(placed->mesh, placed->border.corner);
    if (polish_ && !stopping()) {
        auto polished = refine(*placed, start);
        if (!polished) return tl::unexpected(polished.error());
    }
    collect(*placed);
    return std::move(result_);
}

/// @param first  [sites] or empty: where they stand
Result<DomainMesh> Run::triangulate_sites(const std::vector<Point>& first, const StartSites& start) {
    auto placed = empty_mesh(domain_, capacity_, options_.sites, control_.stop);
    if (!placed) return placed;
    if (auto error = place_sites(placed->mesh, first, start, options_.seed, domain_.resolution(), control_.stop)) {
        return tl::unexpected(*error);
    }
    if (stopping()) return stopped_at_start();
    placed->mesh.trim();
    return placed;
}

/// First sites among which long waves are gone; none where nothing is to be gained.
std::vector<Point> Run::even_start(const StartSites& start) {
    std::vector<Point> first;
    if (!polish_ || capacity_.is_uniform() || !domain_.is_box()) return first;
    first.reserve(options_.sites);
    for (std::size_t site = 0; site < options_.sites; ++site) first.push_back(start.draw(site, 0));
    polish_->even_out(first, control_.stop);
    return first;
}

/// @returns  the capacity variation; of no use once a stop is asked for
double Run::measure(const Triangulation& mesh) {
    capacity_.of_triangles(mesh, capacities_, control_.stop);
    if (stopping()) return 0;
    return set_goals(mesh, capacity_, capacities_, goals_);
}

/// Exact passes cost more, and matter once the sites are near their places.
bool Run::is_exact(int iteration) const {
    constexpr int kFirst = 4;
    return !capacity_.is_uniform() && (iteration >= kFirst || iteration + 1 == options_.iterations);
}

void Run::iterate(Triangulation& mesh, std::vector<bool> corners) {
    constexpr double kPolishedSpring = 0.03;  // rounder triangles, whose areas may vary a little more
    RelaxationOptions settings;
    if (polish_ && capacity_.is_uniform()) settings.spring = kPolishedSpring;
    settings.least_height = std::max(settings.least_height, domain_.resolution());
    Relaxation relaxation(mesh, std::move(corners), capacity_.is_uniform(), settings);
    while (result_.iterations < options_.iterations) {
        if (options_.tolerance && result_.trace.back() < *options_.tolerance) break;
        relaxation.prepare(goals_, control_.stop);
        for (int pass = 0; pass < options_.passes && !stopping(); ++pass) {
            if (is_exact(result_.iterations)) {
                relaxation.exact_pass(capacity_, control_.stop);
            } else {
                relaxation.pass();
            }
        }
        if (!stopping()) mesh.restore_delaunay(control_.stop);
        const double variation = measure(mesh);
        if (stopping()) break;
        result_.trace.push_back(variation);
        ++result_.iterations;
        report();
    }
}

/// Measured on sets and pictures: what more rounds, or a longer reach, would gain is oscillation of the spectrum.
PolishOptions Run::polish_options() const {
    const bool best = options_.quality == Quality::Best;
    PolishOptions settings;
    if (!capacity_.is_uniform()) {
        if (best) {
            settings.rounds = 20;
            settings.even_rounds = 10;
        }
        return settings;
    }
    settings.nearest = 0.84;
    settings.near_rounds = 4;
    settings.rounds = best ? 40 : 5;
    settings.even_rounds = best ? 4 : 1;
    if (best) {
        settings.reach = 0.87;
        settings.push = 0.5;
    }
    return settings;
}

Result<void> Run::refine(DomainMesh& placed, const StartSites& start) {
    Triangulation& mesh = placed.mesh;
    polish_->refine(mesh, polish_options(), control_.stop);
    if (stopping()) return {};
    mesh.restore_delaunay(control_.stop);
    std::vector<Point> sites(mesh.points().begin(),
                             mesh.points().begin() + static_cast<std::ptrdiff_t>(options_.sites));
    // Where other sites were in the way of one that had to leave white, all are triangulated anew.
    if (polish_->clear_gaps(sites)) {
        auto again = triangulate_sites(sites, start);
        if (stopping()) return {};
        if (!again) return tl::unexpected(again.error());
        placed = *std::move(again);
    }
    const double variation = measure(mesh);
    if (!stopping()) result_.polished = variation;
    return {};
}

void Run::report() const {
    if (control_.progress) control_.progress({result_.iterations, options_.iterations, result_.trace.back()});
}

void Run::collect(const DomainMesh& placed) {
    result_.stopped = stopping();
    result_.points = sites_to_user(domain_, placed.mesh);
    if (options_.keep_mesh) result_.mesh = mesh_to_user(domain_, placed.mesh, placed.border);
}

}  // namespace

Result<Distribution> distribute(const Domain& domain, const Density& density, const Options& options,
                                const Control& control) {
    if (auto error = check(options)) return tl::unexpected(*error);
    return Run(domain, density, options, control).execute();
}

}  // namespace ccdt
