// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ccdt/abi.h"
#include "ccdt/control.h"
#include "ccdt/domain.h"

namespace ccdt::v2 {

/// Amount of work spent on the pattern after the triangles' capacities are equal.
enum class Quality {
    Draft,     ///< triangles of equal capacity, as in the paper
    Standard,  ///< also pushes near neighbours apart and removes density errors of long wavelength
    Best,      ///< the same in more rounds: takes a few times as long
    /// Also removes all power from the low frequencies. This needs a torus, a uniform density, no fixed points, and at
    /// least four rows of points. Otherwise, it is the same as Best.
    Stealthy,
};

/// The wanted density of points, relative to other places, on a grid of equal cells that is stretched over the bounding
/// box of the domain. The density is constant in each cell.
struct DensityGrid {
    int width = 0;               ///< cells
    int height = 0;              ///< cells
    std::vector<double> values;  ///< [width * height] row by row, the first row at the smallest y; finite, >= 0
};

/// Options of sample(). The defaults are those of the service.
struct SampleOptions {
    std::optional<DensityGrid> density = {};  ///< none: uniform
    /// Existing points that do not move and are not part of the result; finite. New points keep the same distance from
    /// them as from each other.
    std::vector<Point> fixed = {};
    std::uint64_t seed = 0;  ///< 0 to 2^53 - 1
    Quality quality = Quality::Standard;
    int iterations = 5;                    ///< 0 to 1000; with 0, the initial points are the result
    int passes = 5;                        ///< passes per iteration, 1 to 100
    std::optional<double> tolerance = {};  ///< > 0; ends the iterations once the capacity variation is below this
    bool repair = true;                    ///< whether to repair invalid polygons; if not, they are an error
    bool keep_triangulation = false;       ///< whether to fill Sample::triangulation
    bool partial = false;                  ///< whether a stop returns the current points instead of an error
};

/// The triangulation of a sample, in the coordinates of the domain. It is Delaunay within the domain. On a torus, the
/// corners of a triangle may belong to neighbouring periodic copies.
struct Triangulation {
    std::vector<Point> vertices;                          ///< points, fixed points, then vertices on the border
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of vertices, counter-clockwise
    std::vector<std::vector<std::uint32_t>> boundary;     ///< closed loops of vertices, with the domain on their left
};

/// Points in a domain.
struct Sample {
    std::vector<Point> points;  ///< [sites] strictly inside the domain; a torus includes its lower and left sides
    double variation = 0;       ///< standard deviation of the triangles' capacities over their targets
    std::vector<double> trace;  ///< [completed iterations + 1] variation of the start, and after each iteration
    bool stopped = false;       ///< whether a stop ended the computation early; only with SampleOptions::partial
    std::vector<std::string> repairs;  ///< descriptions of the faults of polygons that were repaired
    std::optional<Triangulation> triangulation;
};

/// Distributes points evenly: by capacity-constrained Delaunay triangulation and a polish of the pattern.
///
/// @param sites  number of points, 1 to 2^28; the result has exactly this number
///
/// Errors: Malformed for an option out of range, and for a side that is not positive or not finite; Unusable for a
/// domain whose extent or ratio of sides is out of range (see Domain and Torus), for a polygon without area or, with
/// `repair` off, for any polygon that OGC Simple Features does not allow, and for a density that is zero everywhere in
/// the domain; Stopped. The field of an error about a polygon is a JSON Pointer /polygon/ring/corner, with ring 0 the
/// outer one. The same arguments give the same points, whatever the number of threads. O(sites) per pass.
///
/// Source: Xu, Liu, Gotsman, Gortler, "Capacity-Constrained Delaunay Triangulation for point distributions", 2011. The
/// polish is not part of their method.
CCDT_EXPORT Sample sample(const Domain& domain, std::size_t sites, const SampleOptions& options = {},
                          const Control& control = {});

/// Orders points progressively: for any k, the first k points are spread as evenly as possible, with the same relative
/// density as all points.
///
/// @param domain   domain of the points; on a torus, distances are periodic
/// @param points   [n], n < 2^32, in the bounding box of the domain; may coincide
/// @param uniform  whether the points have the same density everywhere in the domain. Otherwise, the density
///                 is measured from the points.
/// @returns        [n] indices of the points in the new order
///
/// Errors: those of sample() about the domain; Unusable for a point outside the bounding box; Stopped.
/// Deterministic for any number of threads. O(n log n).
CCDT_EXPORT std::vector<std::uint32_t> progressive_order(const Domain& domain, std::span<const Point> points,
                                                         bool uniform = false, const Control& control = {});

}  // namespace ccdt::v2
