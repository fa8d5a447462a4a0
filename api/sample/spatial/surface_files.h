// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "api/output/body.h"
#include "api/sample/spatial/point_format3.h"
#include "core/base/result.h"
#include "core/ccdt/surface/distribute.h"
#include "core/ccdt/surface/surface.h"
#include "core/ccdt/surface/triangle_soup.h"
#include "core/geometry/point3.h"

namespace ccdt::api {

/// Points that are placed on the surface of a mesh. They can be written in several formats.
struct PlacedSurface {
    TriangleSoup soup;  ///< triangles of the file
    Surface surface;    ///< surface that was made of the triangles
    std::vector<SurfaceNote> repairs;
    std::vector<SurfaceNote> warnings;
    SurfaceDistribution dots;
    std::uint64_t seed = 0;
    double elapsed = 0;  ///< computing time so far, milliseconds

    std::size_t size() const { return dots.points.size(); }
    bool has_colours() const { return soup.has_colours(); }
    bool has_texture() const { return !soup.texture.empty(); }

    /// Returns the index of the triangle of the file in which point i lies.
    std::uint32_t face(std::size_t i) const { return surface.triangle_of(dots.points[i].face); }

    /// Returns the barycentric coordinates of point i in this triangle.
    std::array<double, 3> weights(std::size_t i) const { return surface.original_weights(dots.points[i]); }

    /// Returns the position of point i in the coordinates of the file.
    Point3 position(std::size_t i) const {
        const auto [u, v, w] = weights(i);
        const auto& [a, b, c] = soup.triangles[face(i)];
        return u * soup.vertices[a] + v * soup.vertices[b] + w * soup.vertices[c];
    }

    /// Returns the unit normal of the surface at point i.
    Point3 normal(std::size_t i) const { return surface.smooth_normal(dots.points[i]); }

    /// Returns the colour at point i in linear light. The file must have colours.
    std::array<float, 3> colour(std::size_t i) const {
        const auto [red, green, blue, alpha] = soup.colour_at(face(i), weights(i));
        return {red, green, blue};
    }

    /// Returns the columns of the table of points, with colours, texture coordinates and ranks if there are any.
    std::vector<Column> columns() const;
    /// Replaces `row` by the values of point i in these columns.
    void read_row(std::size_t i, std::vector<double>& row) const;

    /// Returns the texture coordinates at point i. The file must have them.
    std::array<float, 2> texture(std::size_t i) const { return soup.interpolated(soup.texture, face(i), weights(i)); }
};

// Writers of mesh files. The functions write_*_mesh() write the triangulation of the points,
// SurfaceDistribution::mesh, which must not be empty. All writers have the parameters and errors of
// PointFormat3::Write.

Result<void> write_ply_mesh(const PlacedSurface& placed, Body& body, const std::stop_token& stop);

/// Writes points as a glTF 2.0 primitive of the mode POINTS, with the attributes POSITION, NORMAL, COLOR_0 (linear) and
/// TEXCOORD_0 if the file has colours and texture coordinates, _FACE and _BARYCENTRIC. All are 32-bit floats, so _FACE
/// is exact up to 2^24. If the mesh is far from the origin, positions are relative to the translation of the node.
/// Errors: LimitExceeded if the file would exceed 4 GiB; Unusable for coordinates beyond the range of floats. Source:
/// glTF 2.0 (ISO/IEC 12113).
Result<void> write_glb_points(const PlacedSurface& placed, Body& body, const std::stop_token& stop);
Result<void> write_glb_mesh(const PlacedSurface& placed, Body& body, const std::stop_token& stop);

/// Writes the triangulation as Wavefront OBJ. Numbers have the fewest digits that read back to the same double.
Result<void> write_obj_mesh(const PlacedSurface& placed, Body& body, const std::stop_token& stop);

/// Writes the triangulation as binary STL, whose coordinates are 32-bit floats. Errors: Unusable for coordinates beyond
/// their range.
Result<void> write_stl_mesh(const PlacedSurface& placed, Body& body, const std::stop_token& stop);

}  // namespace ccdt::api
