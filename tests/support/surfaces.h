// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>

#include "core/ccdt/surface/surface.h"
#include "core/ccdt/surface/triangle_soup.h"

namespace ccdt::test {

/// Returns a grid of columns x rows quadrilaterals, each made of two triangles, whose vertices have the positions that
/// a function gives for coordinates in [0, 1] x [0, 1]. Where two sides of the grid have the same positions, they have
/// different vertices, which Surface merges.
TriangleSoup grid_surface(int columns, int rows, const std::function<Point3(double, double)>& position);

/// Returns the unit square with z = 0, oriented upwards.
TriangleSoup square_surface(int cells);

/// Returns an axis-parallel cube, oriented outwards.
TriangleSoup cube_surface(Point3 corner = {}, double side = 1);

/// Returns an icosahedron whose triangles are each divided into four, `levels` times. All vertices are on the unit
/// sphere.
TriangleSoup sphere_surface(int levels);

/// Returns two pyramids over a regular polygon of radius 1 around the z axis, oriented outwards.
TriangleSoup bipyramid_surface(int sides, double height);

/// Returns a regular tetrahedron, oriented outwards.
TriangleSoup tetrahedron_surface();

/// Returns the same surface with each triangle divided into count^2 congruent ones, which follow each other. Vertices
/// that had the same position still do.
TriangleSoup divided(const TriangleSoup& soup, int count);

/// Returns the same triangles with their vertices in reverse order, and the corners of each triangle rotated by
/// `turns`.
TriangleSoup renumbered(TriangleSoup soup, int turns);

/// Returns a torus around the z axis, oriented outwards.
TriangleSoup torus_surface(double major, double minor, int columns, int rows);

/// Returns a prism of radius 0.5 and length 3 around the diagonal of the coordinates, beginning at the origin. All
/// faces are long and thin. The distance of its sides from the diagonal is 0.5 cos(pi / sides).
TriangleSoup needle_prism(int sides);

/// Returns a strip with one half turn around a circle of radius 1.
TriangleSoup moebius_strip(int columns, int rows);

/// Returns the triangles of two soups without colours.
TriangleSoup joined(TriangleSoup a, const TriangleSoup& b);

/// Returns the first fault of a surface; empty if its edges, vertices, normals and components are as documented.
std::string fault_in(const Surface& surface);

/// Whether a point is in a face of a surface.
bool is_on(const SurfacePoint& point, const Surface& surface);

}  // namespace ccdt::test
