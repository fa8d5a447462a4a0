// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/ccdt/surface/surface.h"
#include "core/ccdt/surface/surface_density.h"
#include "core/ccdt/surface/surface_triangulation.h"

namespace ccdt {

/// Assigns the mass of a surface, the integral of the density, to the vertices of a triangulation. The surface is
/// divided into small pieces. The mass of each piece is divided among the corners of the triangle above it, by
/// barycentric coordinates. So for a function that is linear in the triangles, the sum over the vertices, weighted by
/// their masses, equals the integral over the surface. A vertex on a border or crease passes its shares to the sites of
/// the same triangle, if there are any. The areas of the triangles are no substitute, because triangles cut off bends.
class SiteMasses {
public:
    /// @param capacity  mass that belongs to each site; the pieces of a face have at most a third of it on average, and
    ///                  are hardly longer than the spacing unless their mass is small
    /// O(faces + sites).
    SiteMasses(const Surface& surface, const SurfaceDensity& density, double capacity);

    /// Returns the number of pieces, about three per site.
    std::size_t piece_count() const { return pieces_.size(); }

    /// Returns the mass of each vertex [vertices], in units of `capacity`. Remembers the triangle above each piece,
    /// where the next search begins. So successive meshes must have the same triangles, apart from flips and small
    /// moves.
    /// O(faces + sites).
    std::vector<double> measure(const SurfaceTriangulation& mesh);

    /// Forgets the triangles above the pieces. Must be called after sites were relocated.
    void forget() { is_located_ = false; }

private:
    struct Piece {
        SurfacePoint at;
        double mass = 0;
        std::uint32_t triangle = SurfaceTriangulation::kNone;  ///< kNone in a component without sites
    };

    struct Part;

    /// A triangle as seen from a piece: its corners beyond sharp edges are unfolded.
    struct View {
        std::array<double, 3> shares{-1, -1, -1};  ///< barycentric coordinates of the piece, up to a factor
        double squared_distance = std::numeric_limits<double>::infinity();  ///< of the nearest corner, in space
        bool is_lost = true;  ///< whether the triangle may be a wrong one: the piece is outside, or the normals differ

        double least() const { return std::min({shares[0], shares[1], shares[2]}); }
    };

    void divide(const Surface& surface, const SurfaceDensity& density, double capacity, const Part& part);
    static std::vector<std::uint32_t> first_triangles(const SurfaceTriangulation& mesh);
    static std::uint32_t start_of(const SurfaceTriangulation& mesh, const Piece& piece, std::uint32_t close);
    static View view(const SurfaceTriangulation& mesh, const SurfacePoint& at, Point3 position, std::uint32_t triangle);
    static View locate(const SurfaceTriangulation& mesh, Piece& piece);

    std::vector<Piece> pieces_;
    std::vector<std::uint32_t> first_;  ///< [faces] first_triangles() before the pieces were located
    bool is_located_ = false;
};

}  // namespace ccdt
