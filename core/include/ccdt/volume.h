// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "ccdt/abi.h"
#include "ccdt/control.h"
#include "ccdt/sample.h"

namespace ccdt::v2 {

/// A point in space.
struct Point3 {
    double x = 0;
    double y = 0;
    double z = 0;

    friend bool operator==(const Point3&, const Point3&) = default;
};

/// The box [0, width] x [0, height] x [0, depth]. The sides must be positive and finite.
struct Box3 {
    double width = 0;
    double height = 0;
    double depth = 0;
};

/// A box whose opposite faces are joined, so that copies of a pattern in it fill space.
struct Torus3 {
    double width = 0;
    double height = 0;
    double depth = 0;
};

/// The inside of a closed surface: all points around which the surface winds, in either direction. Several shells may
/// be nested, also as cavities with the opposite orientation, and may overlap. Coordinates must be finite.
struct Solid {
    std::vector<Point3> vertices;
    /// Indices of vertices. The triangles of a shell need not have the same orientation: the orientation of the
    /// majority counts.
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// A domain in space.
using VolumeDomain = std::variant<Box3, Torus3, Solid>;

/// The wanted density of points, relative to other places, on a grid of equal voxels that is stretched over the
/// bounding box of the domain. The density is constant in each voxel.
struct VoxelGrid {
    std::size_t width = 0, height = 0, depth = 0;  ///< voxels along x, y and z
    std::vector<double> values;                    ///< [depth][height][width] finite, >= 0
};

/// Options of sample_volume(). The defaults are those of the service.
struct VolumeOptions {
    std::optional<VoxelGrid> density = {};  ///< none: uniform
    /// Existing points in the domain, which do not move and are not part of the result. Points keep the same distance
    /// from them as from each other.
    std::vector<Point3> fixed = {};
    std::uint64_t seed = 0;  ///< 0 to 2^53 - 1
    /// Quality::Stealthy needs a torus, a uniform density and no fixed points. Otherwise, it is the same as Best.
    Quality quality = Quality::Standard;
    bool progressive = false;      ///< whether to order the points such that, for any k, the first k are evenly spread
    bool keep_tetrahedra = false;  ///< whether to fill VolumeSample::tetrahedra
    bool partial = false;          ///< whether a stop returns the current points instead of an error
};

/// Tetrahedra that fill a domain. They are made from a Delaunay triangulation by enlarging small dihedral angles. On a
/// torus, the corners of a tetrahedron may belong to neighbouring periodic copies.
struct Tetrahedra {
    /// A vertex for each point, each fixed point, then vertices on the border. The vertices of points can be up to half
    /// a spacing away from the points.
    std::vector<Point3> vertices;
    std::vector<std::array<std::uint32_t, 4>> corners;  ///< indices of vertices
};

/// Points in space.
struct VolumeSample {
    std::vector<Point3> points;  ///< [sites] in the domain
    std::vector<double> trace;   ///< capacity variation, standard deviation over mean, before each iteration
    bool stopped = false;        ///< whether a stop ended the computation early; only with VolumeOptions::partial
    /// Only with VolumeOptions::keep_tetrahedra; none if a stop came before they were computed.
    std::optional<Tetrahedra> tetrahedra;
};

/// Distributes points evenly in space.
///
/// @param sites  number of points, 1 to 2^30 with the fixed points; the result has exactly this number
///
/// Errors: Malformed for an option out of range, a number of density values other than that of the voxels, a side that
/// is below 1e-300 or not finite, a vertex that is not finite, an index without a vertex, and a fixed point outside the
/// domain; Unusable for a surface that is open or encloses no volume, and a density that is zero everywhere in the
/// domain; LimitExceeded for more than 2^30 triangles; Stopped. The same arguments give the same points, whatever the
/// number of threads. O(n log n) for n = sites + triangles, and O(voxels).
CCDT_EXPORT VolumeSample sample_volume(const VolumeDomain& domain, std::size_t sites, const VolumeOptions& options = {},
                                       const Control& control = {});

}  // namespace ccdt::v2
