// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/surface/surface.h"

namespace ccdt {

/// Wanted density of points on a surface, up to a factor. It is linear in each face, or in each piece of a face that a
/// picture covers: such a face is divided into side^2 congruent triangles.
class SurfaceDensity {
public:
    static constexpr double kContrast = 8;  ///< default of of_curvature()

    static SurfaceDensity uniform() { return {}; }

    /// Makes a density with given values at the vertices.
    /// @param values  [vertices of the soup] densities, >= 0 and finite
    /// Errors: Malformed if the number of values is wrong ("density"), or a value is negative or not finite
    /// ("density/N").
    static Result<SurfaceDensity> of_vertices(const Surface& surface, const TriangleSoup& soup,
                                              std::span<const double> values);

    /// Makes a density by darkness, (1 - luminance) * alpha, of the colours of vertices, materials and pictures.
    /// @param spacing  mean distance of points, in the unit frame; detail of pictures at scales below about half of it
    ///                 is averaged
    /// Errors: Unusable if the soup has no colours ("density"); Stopped. O(faces + sites): on average, there are at
    /// most 64 pieces per site, with 4 to 16 samples each.
    static Result<SurfaceDensity> of_colours(const Surface& surface, const TriangleSoup& soup, double spacing,
                                             const std::stop_token& stop = {});

    /// Makes a density by curvature, smoothed over a distance: bent regions get up to `contrast` times as many points
    /// per area as flat ones. With the principal curvatures k and l, the density is 1 + (contrast - 1) * c / (c + m),
    /// where c = k^2 + l^2 and m is the mean of c over the surface. Edges of any angle are bent regions.
    /// @param spacing   mean distance of points, in the unit frame; curvature at smaller scales is smoothed
    /// @param contrast  >= 1
    /// @param stop      polled in each step; after a stop, the density must not be used
    ///
    /// c is the squared gradient of the normal. For it, vertex normals are smoothed by one implicit step of diffusion
    /// and interpolated linearly in each face. O(faces) per step of conjugate gradients, of which there are about
    /// spacing divided by the length of edges, and at most 100. Source: Desbrun, Meyer, Schroeder, Barr, Implicit
    /// fairing of irregular meshes using diffusion and curvature flow (1999), for the diffusion; here it smooths
    /// normals instead of positions.
    static SurfaceDensity of_curvature(const Surface& surface, double spacing, double contrast = kContrast,
                                       const std::stop_token& stop = {});

    bool is_uniform() const { return values_.empty(); }
    /// Returns the number of pieces along each side of a face.
    std::uint32_t side(std::uint32_t face) const { return grids_.empty() ? 1 : grids_[face].side; }
    double at(const SurfacePoint& point) const;
    /// Returns the density at a corner (0, 1 or 2) of a face.
    double at_corner(std::uint32_t face, std::uint32_t corner) const { return at(SurfacePoint::corner(face, corner)); }
    /// Returns the largest value in a face.
    double largest(std::uint32_t face) const;
    /// Returns an upper bound for the density in a triangle within a face: its largest value in the pieces nearby.
    /// @param corners  barycentric coordinates
    /// O(pieces of the face in the triangle).
    double largest(std::uint32_t face, const std::array<std::array<double, 3>, 3>& corners) const;
    /// Returns the integral over a face.
    double mass(const Surface& surface, std::uint32_t face) const {
        if (values_.empty()) return surface.area(face);
        if (!grids_.empty()) return surface.area(face) * grids_[face].mean;
        const double* v = &values_[3 * std::size_t{face}];
        return surface.area(face) * (v[0] + v[1] + v[2]) / 3;
    }

private:
    /// Values at the corners of the pieces of a face. The first ones are on the side from the first to the second
    /// corner of the face.
    struct Grid {
        std::size_t first = 0;  ///< index in values_
        std::uint32_t side = 1;
        double mean = 0;  ///< of the density in the face
    };

    Grid grid(std::uint32_t face) const { return grids_.empty() ? Grid{3 * std::size_t{face}} : grids_[face]; }

    std::vector<double> values_;  ///< at the corners of the faces or pieces; empty if the density is uniform
    std::vector<Grid> grids_;     ///< [faces]; empty if no face is divided
};

}  // namespace ccdt
