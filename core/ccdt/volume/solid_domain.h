// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/ccdt/volume/box_domain3.h"
#include "core/ccdt/volume/solid.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// A solid as a domain of sites, in the unit frame of its surface. Has those members of BoxDomain3 that templates over
/// the domain use. Cheap to copy.
class SolidDomain {
public:
    static constexpr bool periodic = false;

    /// @param solid     must outlive this object
    /// @param coverage  of the solid
    SolidDomain(const Solid& solid, const Solid::Coverage& coverage);

    /// Sets the integral of the density over the solid, relative to the mean density of the bounding box.
    void set_volume(double volume) { volume_ = volume; }

    Point3 sides;  ///< of the bounding box

    BoxDomain3 box() const { return {sides, false}; }
    /// Returns the value given to set_volume(); with uniform density, it is the volume.
    double volume() const { return volume_; }
    bool contains(Point3 p) const;
    Point3 interior() const { return solid_->interior(); }
    /// Returns the nearest point in the bounding box.
    Point3 in_box(Point3 p) const;

    /// Returns the position where a move ends: `to` if it is inside, or else its mirror image at the nearest point of
    /// the surface. If the image is not inside either, which can happen in thin parts, the move is shortened.
    /// @param from  inside
    Point3 moved(Point3 from, Point3 to) const;

    const Surface& surface() const { return solid_->surface(); }
    /// Returns the nearest point of the surface.
    Point3 foot(Point3 p) const { return surface().position(surface().nearest(p)); }
    /// Returns the same point if its distance from p is less than `distance`; otherwise none. Faster.
    std::optional<Point3> foot_within(Point3 p, double distance) const;

    /// Calls function(copy, is_original) for a point and its copy. The copy is the mirror image at the nearest point of
    /// the surface. It is left out if it is inside the solid, which can happen at a narrow gap.
    /// @param p         inside
    /// @param distance  largest distance of the copy from the surface
    template <class Function>
    void for_copies(Point3 p, double distance, Function&& function) const {
        function(p, true);
        const auto near = foot_within(p, distance);
        if (!near) return;
        if (const Point3 image = p + 2 * (*near - p); !contains(image)) function(image, false);
    }

private:
    /// Distances from the surface, in cells of a grid that has a margin of one cell.
    struct Depths {
        std::array<std::size_t, 3> cells{};
        Point3 per_length;
        double cell = 0;                ///< length of the shortest side of a cell
        std::vector<std::int8_t> grid;  ///< [z][y][x] cells to the nearest cell that the surface crosses; < 0 outside

        std::size_t index(Point3 p) const;
    };

    const Solid* solid_;
    double volume_ = 0;
    std::shared_ptr<const Depths> depths_;
};

}  // namespace ccdt
