#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/parallel/team.h"
#include "core/polish/settings.h"
#include "core/result.h"

namespace ccdt {

/// Ways to draw the first sites.
enum class Start {
    Stratified,  ///< a few at random in each of many cells of equal capacity
    Random,      ///< independently by the density, as in the paper
};

struct Options {
    std::size_t sites = 0;            ///< >= 1
    std::uint64_t seed = 0;           ///< [0, 2^53)
    int iterations = 5;               ///< triangulation phases, 0 to 1000; 0 returns the start
    int passes = 5;                   ///< geometry passes per iteration, 1 to 100
    std::optional<double> tolerance;  ///< > 0; ends the run once the capacity variation is below it
    Start start = Start::Stratified;
    Quality quality = Quality::Standard;
    bool keep_mesh = false;  ///< fill Distribution::mesh
    /// Points that are there already and stay, in the domain's coordinates: none of the sites, which keep clear of them
    /// as of each other, and leave each as much room as one of them has, but a cluster no more than its area and a rim.
    /// Those outside take room inside, too.
    std::vector<Point> fixed = {};
};

/// State of a computation on its way.
struct Progress {
    int iteration = 0;     ///< iterations done
    int iterations = 0;    ///< iterations asked for
    double variation = 0;  ///< capacity variation after the last of them
    int round = 0;         ///< rounds of the polish done
    int rounds = 0;        ///< of those that it takes

    /// The share of the whole, in (0, 1) and never less than before: about, as if the start took two steps, the end
    /// one, and each iteration and round one.
    double done() const { return (2.0 + iteration + round) / (3.0 + iterations + rounds); }
};

/// Means by which a caller stops, watches and speeds up a computation.
struct Control {
    std::stop_token stop;  ///< asked at least once per pass
    /// Called after the start, each iteration and each round of the polish; may be empty.
    std::function<void(const Progress&)> progress;
    Team* team = &alone();  ///< does the work; never null
};

/// The triangulation behind a distribution, in the caller's coordinates. Around a torus a triangle's corners may be
/// those of neighbouring copies.
struct TriangleMesh {
    std::vector<Point> vertices;                          ///< the sites, fixed points, then vertices on the border
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise
    std::vector<std::vector<std::uint32_t>> boundary;     ///< closed loops of vertices, the domain on their left
};

struct Distribution {
    std::vector<Point>
        points;          ///< [sites], strictly inside the domain, in its coordinates; a torus has its lower sides
    int iterations = 0;  ///< done
    std::vector<double> trace;       ///< capacity variation after each iteration [iterations + 1]; [0] is the start's
    std::optional<double> polished;  ///< capacity variation after the polish, if there was one
    bool stopped = false;  ///< ended early by the stop token: iterations and polish may be missing, and the mesh
                           ///< not be Delaunay
    std::optional<TriangleMesh> mesh;
    std::vector<std::uint32_t> ranks = {};  ///< [points] or none: the place of each in a progressive order

    /// Capacity variation of the points.
    double variation() const { return polished.value_or(trace.back()); }
};

/// Distributes sites so that all triangles of their Delaunay triangulation hold nearly the same capacity, and then,
/// unless it is a draft or of no iterations, polishes what equal triangles leave undone.
///
/// @param density  stretched over the domain's bounding box; zero outside the domain, repeated around a torus
/// @param control  a stop returns the sites as they stand, is no error; stopped during the start: Error Stopped
/// Errors: Malformed for an option out of range; Unusable if the density is zero all over the domain.
/// Same input, same bytes, by any team. O(n) per pass.
/// Source: Xu, Liu, Gotsman, Gortler 2011, section 3. The polish is not theirs.
Result<Distribution> distribute(const Domain& domain, const Density& density, const Options& options,
                                const Control& control = {});

/// Computes moves that better what is seen of the dots of all inks together.
/// @param sites  [inks] in the domain's coordinates
/// @returns      [inks][sites], for each but few hundredths of what sites of its ink are apart
using Retouch = std::function<std::vector<std::vector<Point>>(std::span<const std::vector<Point>> sites)>;

/// Distributes the dots of several inks, each as distribute() does by a density of its own, and dots of different inks
/// apart from each other where there is room: all iterate in step, and are polished together. A draft has no polish,
/// and inks that know nothing of each other.
///
/// @param densities  [inks] each stretched over the domain's bounding box; that of an ink without sites is not used
/// @param sites      [inks] >= 0, one of them at least > 0
/// @param options    but for the number of sites; the first ink that has sites takes the seed, others seeds made of it
/// @param control    progress counts iterations and rounds of all inks as one, with the largest variation; a stop
///                   returns the sites as they stand, is no error; stopped during the start: Error Stopped
/// @param retouch    called in the last rounds of the polish if there is one and several inks have sites; may be empty
/// @returns          [inks]; an ink without sites has no points, and a trace of one 0
/// Errors: as distribute(), which is this with one ink; Malformed if the densities have different grids. Same input,
/// same bytes, by any team. O(sites) per pass.
Result<std::vector<Distribution>> distribute_inks(const Domain& domain, std::span<const Density> densities,
                                                  std::span<const std::size_t> sites, const Options& options,
                                                  const Control& control = {}, const Retouch& retouch = {});

}  // namespace ccdt
