// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <numbers>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/surface/surface.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// The inside of a closed surface: all points around which the surface winds, in either direction.
///
/// A surface may consist of several shells: sets of faces that are connected by edges, also by creases. Shells may
/// overlap. Each has the orientation that most of its triangles had in the soup. A cavity is a shell inside another one
/// with the opposite orientation.
class Solid {
public:
    /// Crease angle for Surface::create() with which tetrahedra get edges along creases, in radians.
    static constexpr double kCrease = std::numbers::pi / 4;

    /// Makes a solid. O(faces log faces), and a constant time for measuring the volume.
    /// @param surface  with any creases
    /// @param stop     polled regularly, but not while the tree of the faces is built
    ///
    /// Errors: Unusable if the surface is open (names a border edge) or encloses no volume; Stopped.
    static Result<Solid> create(Surface surface, const std::stop_token& stop = {});

    const Surface& surface() const { return surface_; }

    /// Returns the bounding box, in the coordinates of the soup.
    const Box3& bounds() const { return bounds_; }
    /// Returns the volume, in the coordinates of the soup. It may overflow to infinity, or underflow to 0, if the
    /// coordinates are extremely large or small.
    double volume() const;
    /// Returns the share of the bounding box that is inside, in (0, 1].
    double share() const { return volume_ / (sides_.x * sides_.y * sides_.z); }
    /// Whether a point in the coordinates of the soup is inside. Returns false if a coordinate is not a number.
    bool contains(Point3 p) const { return holds(surface_.from_input(p)); }

    /// Returns the sides of the bounding box in the unit frame of the surface, where it has a corner at the origin.
    Point3 sides() const { return sides_; }
    /// Whether a point in the unit frame is inside. Wrong only for points whose distance from the surface is as small
    /// as rounding errors, even if the line through the point along x meets edges or vertices. Several threads may call
    /// it at once. O(log faces), typically.
    bool holds(Point3 p) const;

    /// Returns a point inside, in the unit frame.
    Point3 interior() const { return interior_; }

    /// The share that is inside, for each cell of a grid over the bounding box.
    struct Coverage {
        std::array<std::size_t, 3> cells{};
        std::vector<double> shares;  ///< [z][y][x] in [0, 1]
        std::vector<bool> crossed;   ///< [z][y][x] whether the surface may cross the cell

        double sum() const;
    };

    /// Computes the coverage of a grid. It is exact up to rounding, except in cells where surfaces cross each other.
    /// @param count  approximate number of cells; the cells are nearly cubes, unless the box is very thin
    /// @param stop   polled regularly; after a stop, the coverage is undefined
    ///
    /// O(cells + faces + cells crossed by each face).
    Coverage coverage(double count, const std::stop_token& stop = {}) const;

private:
    Solid(Surface surface, const std::stop_token& stop);

    template <class Function>
    void for_crossings(Point3 p, Function&& function) const;
    void orient_shells(const std::stop_token& stop);
    bool find_interior();

    Surface surface_;
    Point3 sides_;
    Box3 bounds_;
    double volume_ = 0;  ///< in the unit frame
    Point3 interior_;
    std::vector<bool> inverted_;  ///< [faces] whether most triangles of the face's shell were turned over
};

}  // namespace ccdt
