// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/volume_construction.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "core/ccdt/volume/block_relaxation.h"
#include "core/ccdt/volume/box_domain3.h"
#include "core/ccdt/volume/near_push.h"
#include "core/ccdt/volume/solid_domain.h"
#include "core/ccdt/volume/solid_mesh.h"
#include "core/ccdt/volume/volume_mesh.h"
#include "core/ccdt/volume/volume_spacing.h"
#include "core/ccdt/volume/volume_start.h"
#include "core/ccdt/volume/volume_transport.h"

namespace ccdt {

namespace {

/// Schedule, in order of execution. A round pushes near points apart, then removes long waves.
struct Schedule {
    int wide_rounds = 0;  ///< rounds whose pushes reach all neighbours, which order the points
    int relaxations = 0;  ///< relaxations of the tetrahedra, each on a new triangulation
    int passes = 5;       ///< passes per relaxation
    int rounds = 0;       ///< rounds whose pushes reach near neighbours
    /// Reach of the pushes of `rounds`. A short reach preserves the shapes of the relaxed tetrahedra better.
    double reach = 0.87;
    int near_rounds = 0;  ///< rounds with several pushes of the nearest neighbours; the first one has no pushes
    int waves = 0;        ///< maximum number of removals of waves at the end, which stop at a negligible power

    int steps() const { return wide_rounds + relaxations + rounds + near_rounds + waves; }
};

// Benchmark VolumePattern shows the quality that these schedules reach.
Schedule schedule_of(Quality quality, bool stealthy) {
    switch (quality) {
        case Quality::Draft:
            return {.relaxations = 5};
        case Quality::Standard:
            return {.wide_rounds = 8, .relaxations = 1, .rounds = 8, .reach = 0.9, .near_rounds = 2};
        default:
            return {.wide_rounds = 24, .relaxations = 2, .rounds = 16, .near_rounds = 3, .waves = stealthy ? 20 : 0};
    }
}

// Reach of pushes, relative to the distance in the densest packing, and share of the missing distance.
constexpr double kWideReach = 1.1, kWideShare = 0.25;
constexpr double kNearReach = 0.88, kLastReach = 0.87, kShare = 0.5;
constexpr int kNearPushes = 3;   ///< pushes per near round
constexpr int kLastPushes = 10;  ///< largest number of pushes at the end
/// Pushes end when all distances are at least this large, relative to the densest packing.
constexpr double kMin = 0.855;
constexpr double kNegligiblePower = 1e-11;  ///< largest power of a wave that counts as removed

/// Returns the number of points that the bounding box would have if the density continued outside the domain.
template <class Domain>
std::size_t points_in_box(const Domain& domain, std::size_t points) {
    constexpr double kMax = 1e18;  // reached if the domain holds hardly any of the mass
    const double number = std::round(static_cast<double>(points) * domain.box().volume() / domain.volume());
    return static_cast<std::size_t>(std::min(number, kMax));
}

/// Builds one distribution, in the unit frame: the longest side is 1.
template <class Domain>
class VolumeConstruction {
public:
    VolumeConstruction(const Domain& domain, const VoxelDensity& density, const VoxelDensity& inside,
                       const VolumeOptions& options, std::span<const Point3> fixed, const Control& control)
        : domain_(domain),
          density_(density),
          control_(control),
          executor_(*control.executor),
          free_(options.sites),
          spacing_(domain.box(), density, points_in_box(domain, options.sites + fixed.size()), executor_, control.stop),
          schedule_(schedule_of(options.quality, options.quality == Quality::Stealthy && domain.periodic &&
                                                     density.is_uniform() && fixed.empty())),
          transport_(volume_transport(domain.box(), domain.volume(), inside, spacing_, options.sites + fixed.size(),
                                      schedule_.waves > 0, executor_, control.stop)),
          relaxation_(domain, density, spacing_, executor_),
          zones_(density, domain.periodic, static_cast<double>(points_in_box(domain, options.sites + fixed.size()))),
          sites_(draw_start(domain, density, inside, zones_, options.sites, fixed, options.seed, control.stop)) {}

    void execute() {
        report();
        for (int i = 0; i < schedule_.wide_rounds; ++i) round(kWideReach, kWideShare);
        transport_.release_memory();
        for (int i = 0; i < schedule_.relaxations && !stopping(); ++i) {
            double variation = 0;
            within_density([&] { variation = relaxation_.relax(sites_, free_, schedule_.passes, control_.stop); });
            if (stopping()) break;
            trace_.push_back(variation);
            finish_step();
        }
        for (int i = 0; i < schedule_.rounds; ++i) round(schedule_.reach, kShare);
        for (int i = 0; i < schedule_.near_rounds && !stopping(); ++i) {
            if (i > 0) push(kNearReach, kShare, kNearPushes);
            even_out();
            finish_step();
        }
        // If no waves are to be removed, the last step increases distances: its pushes move too few points to create
        // waves.
        if (schedule_.waves == 0 && schedule_.near_rounds > 0) push(kLastReach, kShare, kLastPushes);
        for (int i = 0; i < schedule_.waves && !stopping(); ++i) {
            if (even_out() < kNegligiblePower) break;
            finish_step();
        }
        transport_.release_memory();
    }

    VolumeDistribution result(bool keep_mesh) {
        VolumeDistribution result;
        if (keep_mesh && !stopping()) result.mesh = volume_mesh(domain_, spacing_, sites_, free_, control_.stop);
        result.stopped = stopping();
        if (result.stopped) result.mesh.reset();
        result.trace = std::move(trace_);
        sites_.resize(free_);
        result.points = std::move(sites_);
        return result;
    }

private:
    bool stopping() const { return control_.stop.stop_requested(); }

    void push(double reach, double share, int times) {
        transport_.release_memory();  // a push needs as much memory itself
        for (int i = 0; i < times && !stopping(); ++i) {
            double least = 0;
            within_density(
                [&] { least = push_apart(domain_, spacing_, sites_, free_, reach, share, executor_, control_.stop); });
            if (least >= kMin) return;
        }
    }
    /// Removes long waves. Returns the largest power of a wave before the removal; 0 if the schedule has no `waves`, or
    /// after a stop.
    double even_out() {
        constexpr std::size_t kSites = 512;  // per task
        if (!transport_.measure(sites_, {}, control_.stop)) return 0;
        const double power = schedule_.waves > 0 ? transport_.largest_power(static_cast<double>(sites_.size())) : 0;
        std::vector<Point3> moves(free_);
        const auto spacing = [&](Point3 p) { return spacing_.side(p); };
        const std::span<const Point3> free = std::span(sites_).first(free_);
        if (!transport_.find_moves(free, moves, spacing, control_.stop)) return 0;
        within_density([&] {
            for_ranges(executor_, free_, kSites, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) sites_[i] = domain_.moved(sites_[i], sites_[i] + moves[i]);
            });
        });
        return power;
    }

    /// Moves sites. Shortens the moves that end where the density is 0 or in another zone of the density.
    template <class Move>
    void within_density(Move&& move) {
        constexpr int kHalvings = 3;
        if (!density_.has_gaps() && zones_.count() == 1) return move();
        const std::vector<Point3> before = sites_;
        move();
        for (std::size_t i = 0; i < free_; ++i) {
            const std::uint32_t zone = zones_.at(in_box(before[i]));
            const auto is_allowed = [&](Point3 p) {
                return density_.is_positive(in_box(p)) && zones_.at(in_box(p)) == zone;
            };
            Point3 way = sites_[i] - before[i];
            if (domain_.periodic) way = shortest(way);
            for (int halving = 0; !is_allowed(sites_[i]); ++halving) {
                way = 0.5 * way;
                sites_[i] = halving < kHalvings ? domain_.moved(before[i], before[i] + way) : before[i];
                if (halving == kHalvings) break;
            }
        }
    }
    /// Returns a position relative to the sides of the bounding box.
    Point3 in_box(Point3 p) const {
        return by_axis<Point3>([&](std::size_t axis) { return along(p, axis) / along(domain_.sides, axis); });
    }
    /// Returns the shortest of the vectors that lead to the periodic copies of a point.
    Point3 shortest(Point3 way) const {
        return by_axis<Point3>([&](std::size_t axis) {
            const double side = along(domain_.sides, axis);
            return along(way, axis) - side * std::round(along(way, axis) / side);
        });
    }

    void round(double reach, double share) {
        if (stopping()) return;
        push(reach, share, 1);
        even_out();
        finish_step();
    }

    void finish_step() {
        if (stopping()) return;
        ++done_;
        report();
    }
    void report() const {
        if (!control_.progress) return;
        const auto variation = trace_.empty() ? std::nullopt : std::optional(trace_.back());
        const int relaxed = static_cast<int>(trace_.size());
        control_.progress(
            {relaxed, schedule_.relaxations, variation, done_ - relaxed, schedule_.steps() - schedule_.relaxations});
    }

    Domain domain_;
    const VoxelDensity& density_;
    const Control& control_;
    Executor& executor_;
    std::size_t free_;
    VolumeSpacing spacing_;
    Schedule schedule_;
    OctaveTransport<Point3> transport_;
    BlockRelaxation<Domain> relaxation_;
    VoxelZones zones_;
    std::vector<Point3> sites_;  ///< sites, then fixed points
    std::vector<double> trace_;
    int done_ = 0;  ///< number of completed steps
};

}  // namespace

Result<void> check_sites(const VolumeOptions& options) {
    constexpr std::size_t kMax = VolumeOptions::kMaxPoints;
    if (options.sites >= 1 && options.sites <= kMax && options.fixed.size() <= kMax - options.sites) return {};
    return failure(ErrorCode::Malformed,
                   "the number of points must be at least 1 and, together with the fixed points, at most 2^30",
                   "sites");
}

template <class Domain>
Result<VolumeDistribution> construct_volume(const Domain& domain, const VoxelDensity& density,
                                            std::optional<VoxelDensity> inside, const VolumeOptions& options,
                                            std::span<const Point3> fixed, const Control& control) {
    VolumeConstruction construction(domain, density, inside ? *inside : density, options, fixed, control);
    if (control.stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped before there was a result");
    inside.reset();
    construction.execute();
    return construction.result(options.keep_mesh);
}

template Result<VolumeDistribution> construct_volume(const BoxDomain3&, const VoxelDensity&,
                                                     std::optional<VoxelDensity>, const VolumeOptions&,
                                                     std::span<const Point3>, const Control&);
template Result<VolumeDistribution> construct_volume(const SolidDomain&, const VoxelDensity&,
                                                     std::optional<VoxelDensity>, const VolumeOptions&,
                                                     std::span<const Point3>, const Control&);

}  // namespace ccdt
