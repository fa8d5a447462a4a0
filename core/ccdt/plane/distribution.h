// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/ccdt/polish/settings.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Ways to draw the initial sites.
enum class Start {
    Stratified,  ///< a few at random in each of many cells of equal capacity
    Random,      ///< independently, with the density as probability, as in the paper
};

struct Options {
    std::size_t sites = 0;            ///< >= 1
    std::uint64_t seed = 0;           ///< [0, 2^53)
    int iterations = 5;               ///< 0 to 1000; with 0, the initial sites are the result
    int passes = 5;                   ///< passes per iteration, 1 to 100
    std::optional<double> tolerance;  ///< > 0; ends the run once the capacity variation is below this
    Start start = Start::Stratified;
    Quality quality = Quality::Standard;
    bool keep_mesh = false;  ///< whether to fill Distribution::mesh
    /// Whether each side of a step of the density gets its exact share of sites, and no site stays where the density is
    /// zero, also in a draft. If false, only the mean of the density around each position counts, as in halftones.
    bool keep_steps = true;
    /// Existing points, in the domain's coordinates, that do not move and are not among the sites. Sites keep the same
    /// distance from fixed points as from each other. Each fixed point takes as much area as a site. A cluster of fixed
    /// points takes only the area that it covers and a rim around it. Points outside the domain can take area inside.
    std::vector<Point> fixed = {};
};

/// State of a running computation.
struct Progress {
    int iteration = 0;   ///< iterations completed
    int iterations = 0;  ///< iterations requested
    /// Capacity variation after the last completed iteration. None before the start is completed.
    std::optional<double> variation = {};
    int round = 0;   ///< rounds of the polish completed
    int rounds = 0;  ///< number of rounds of the polish
    /// Completed share of a computation that also has other steps, such as decoding. None: there are no other steps.
    std::optional<double> share = {};

    /// Returns the completed share of the work, in (0, 1) and never decreasing. The share is an estimate: the start
    /// counts as two steps, the end as one, and each iteration and each round as one.
    double done() const { return share.value_or((2.0 + iteration + round) / (3.0 + iterations + rounds)); }
};

/// Lets a caller stop, observe and parallelise a computation.
struct Control {
    std::stop_token stop;  ///< polled at least once per pass
    /// Called after the start, each iteration and each round of the polish; may be empty.
    std::function<void(const Progress&)> progress;
    Executor* executor = &inline_executor();  ///< runs the tasks; never null
};

/// The triangulation behind a distribution, in the caller's coordinates. On a torus, corners of a triangle may belong
/// to neighbouring periodic copies.
struct TriangleMesh {
    std::vector<Point> vertices;                          ///< sites, fixed points, then vertices on the border
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise
    std::vector<std::vector<std::uint32_t>> boundary;     ///< closed loops of vertices, with the domain on their left
};

/// Result of a computation in the plane or on a surface.
template <class P, class Mesh>
struct BasicDistribution {
    std::vector<P> points;  ///< [sites]
    int iterations = 0;     ///< number of completed iterations
    /// Capacity variation after each iteration [iterations + 1]; entry 0 is the variation of the start.
    std::vector<double> trace;
    std::optional<double> polished;  ///< capacity variation after the polish; none without polish
    /// Whether a stop ended the computation early. Iterations and polish may then be incomplete, and the mesh not
    /// Delaunay.
    bool stopped = false;
    std::optional<Mesh> mesh;
    std::vector<std::uint32_t> ranks = {};  ///< [points] rank of each point in a progressive order; may be empty

    /// Returns the capacity variation of the points.
    double variation() const { return polished.value_or(trace.back()); }
};

/// Points lie strictly inside the domain, in the domain's coordinates. A torus includes its lower and left sides.
using Distribution = BasicDistribution<Point, TriangleMesh>;

}  // namespace ccdt
