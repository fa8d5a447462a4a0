#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/result.h"

namespace ccdt {

/// How the first sites are drawn.
enum class Start {
    Stratified,  ///< a few at random in each of many cells of equal capacity
    Random,      ///< independently by the density, as in the paper
};

/// What is done for the pattern.
enum class Quality {
    Draft,     ///< triangles of equal capacity, as in the paper
    Standard,  ///< then near neighbours are pushed apart and long waves evened out
    Best,      ///< the same for longer: a few times the time
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
};

/// How far a computation is.
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

/// What the caller keeps in hand while core computes.
struct Control {
    std::stop_token stop;  ///< asked at least once per pass
    /// Called after the start, each iteration and each round of the polish; may be empty.
    std::function<void(const Progress&)> progress;
};

/// The triangulation behind a distribution, in the caller's coordinates. Around a torus a triangle's corners may be
/// those of neighbouring copies.
struct TriangleMesh {
    std::vector<Point> vertices;                          ///< the sites, then vertices on the border
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

    /// Capacity variation of the points.
    double variation() const { return polished.value_or(trace.back()); }
};

/// Distributes sites so that all triangles of their Delaunay triangulation hold nearly the same capacity, and then,
/// unless it is a draft or of no iterations, polishes what equal triangles leave undone.
///
/// @param density  stretched over the domain's bounding box; zero outside the domain, repeated around a torus
/// @param control  a stop returns the sites as they stand, is no error; stopped during the start: Error Stopped
/// Errors: Malformed for an option out of range; Unusable if the density is zero all over the domain.
/// Same input, same bytes, on any number of threads (it uses one). O(n) per pass.
/// Source: Xu, Liu, Gotsman, Gortler 2011, section 3. The polish is not theirs.
Result<Distribution> distribute(const Domain& domain, const Density& density, const Options& options,
                                const Control& control = {});

}  // namespace ccdt
