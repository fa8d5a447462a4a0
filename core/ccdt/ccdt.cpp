#include "core/ccdt/ccdt.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/ccdt/border.h"
#include "core/ccdt/capacity.h"
#include "core/ccdt/goals.h"
#include "core/ccdt/placement.h"
#include "core/ccdt/relaxation.h"
#include "core/ccdt/start.h"
#include "core/geometry/delaunay.h"
#include "core/mesh/triangulation.h"

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

/// One computation of distribute().
class Run {
public:
    Run(const Domain& domain, const Density& density, const Options& options, const Control& control)
        : domain_(domain), density_(density), options_(options), control_(control), capacity_(domain, density) {}

    Result<Distribution> execute();

private:
    bool stopping() const { return control_.stop.stop_requested(); }
    void measure(const Triangulation& mesh);
    void iterate(Triangulation& mesh, std::vector<bool> corners);
    void report() const;
    void collect(const Triangulation& mesh, const Border& border);

    const Domain& domain_;
    const Density& density_;
    const Options& options_;
    const Control& control_;
    Capacity capacity_;
    std::vector<double> capacities_;   ///< [triangles]
    std::vector<TriangleGoal> goals_;  ///< [triangles]
    Distribution result_;
};

Result<Distribution> Run::execute() {
    if (!(capacity_.total() > 0)) {
        return failure(ErrorCode::Unusable, "the density is zero all over the domain", "density");
    }
    Border border = make_border(domain_, capacity_, options_.sites);
    auto scaffold = triangulate(border);
    if (!scaffold) {
        // Vertices set on the edges round off them; where two edges almost touch, that can make them cross.
        border = bare_border(domain_);
        scaffold = triangulate(border);
    }
    if (!scaffold) return failure(ErrorCode::Internal, "the domain cannot be triangulated");
    Triangulation mesh(options_.sites, *scaffold);
    scaffold = ConstrainedDelaunay{};
    const StartSites start(domain_, density_, options_);
    if (auto error = place_sites(mesh, start, options_.seed, domain_.resolution(), control_.stop))
        return tl::unexpected(*error);
    mesh.trim();
    iterate(mesh, border.corner);
    collect(mesh, border);
    return std::move(result_);
}

void Run::measure(const Triangulation& mesh) {
    capacity_.of_triangles(mesh, capacities_);
    result_.trace.push_back(set_goals(mesh, capacity_, capacities_, goals_));
}

void Run::iterate(Triangulation& mesh, std::vector<bool> corners) {
    measure(mesh);
    report();
    RelaxationOptions settings;
    settings.least_height = std::max(settings.least_height, domain_.resolution());
    Relaxation relaxation(mesh, std::move(corners), capacity_.is_uniform(), settings);
    while (result_.iterations < options_.iterations) {
        if (options_.tolerance && result_.variation() < *options_.tolerance) return;
        relaxation.prepare(goals_);
        for (int pass = 0; pass < options_.passes && !result_.stopped; ++pass) {
            result_.stopped = stopping();
            if (!result_.stopped) relaxation.pass();
        }
        mesh.restore_delaunay();
        if (result_.stopped) return;
        measure(mesh);
        ++result_.iterations;
        report();
    }
}

void Run::report() const {
    if (control_.progress) control_.progress({result_.iterations, options_.iterations, result_.variation()});
}

void Run::collect(const Triangulation& mesh, const Border& border) {
    const auto user = [&](Point p) { return domain_.to_user(p); };
    result_.points.resize(options_.sites);
    std::transform(mesh.points().begin(), mesh.points().begin() + static_cast<std::ptrdiff_t>(options_.sites),
                   result_.points.begin(), user);
    if (!options_.keep_mesh) return;
    TriangleMesh& kept = result_.mesh.emplace();
    kept.vertices.resize(mesh.vertex_count());
    std::transform(mesh.points().begin(), mesh.points().end(), kept.vertices.begin(), user);
    kept.triangles.reserve(mesh.triangle_count());
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) kept.triangles.push_back(mesh.corners(t));
    auto vertex = static_cast<std::uint32_t>(options_.sites);
    for (const auto& loop : border.loops) {
        auto& indices = kept.boundary.emplace_back(loop.size());
        for (std::uint32_t& index : indices) index = vertex++;
    }
}

}  // namespace

Result<Distribution> distribute(const Domain& domain, const Density& density, const Options& options,
                                const Control& control) {
    if (auto error = check(options)) return tl::unexpected(*error);
    return Run(domain, density, options, control).execute();
}

}  // namespace ccdt
