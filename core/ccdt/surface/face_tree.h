// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/point3.h"

namespace ccdt {

/// Returns the barycentric coordinates of the point of a triangle that is nearest to p.
std::array<double, 3> nearest_weights(Point3 p, const std::array<Point3, 3>& triangle);

/// Finds nearest points of triangles, and triangles on lines, by a tree of boxes. The axes of each box are those of the
/// longest triangle inside, so that boxes of long thin triangles are narrow whatever their direction.
///
/// The boxes of CGAL's AABB_tree are parallel to the axes of the coordinates. In a solid with 40,000 diagonal needles,
/// its queries took 1 ms.
class FaceTree {
public:
    /// A triangle of the tree.
    struct Face {
        std::array<std::uint32_t, 3> corners{};
        std::uint32_t number = 0;
        bool is_flat = false;  ///< nearest() ignores flat faces
    };

    /// The point of a triangle that is nearest to another point.
    struct Nearest {
        std::uint32_t face = 0;
        std::array<double, 3> weights{};  ///< barycentric coordinates
        double squared = 0;               ///< squared distance
    };

    /// @param vertices  multiples of 2^-36 in [0, 1]^3, as in a Surface; must outlive this object
    /// @param faces     triangles whose corners differ, at least one
    ///
    /// O(n log n). For a million triangles: 0.7 s, 54 to 76 bytes per triangle, and 80 bytes during the construction.
    FaceTree(std::span<const Point3> vertices, std::vector<Face> faces);

    /// Returns the nearest point of all triangles, up to rounding; none if its distance is not less than `within`.
    /// Several threads may call it at once. O(log n), typically.
    /// @param p  finite
    std::optional<Nearest> nearest(Point3 p, double within = std::numeric_limits<double>::infinity()) const;

    /// Calls function(face) for all faces that the half-line from p in the direction of x meets, and for some others.
    template <class Function>
    void for_faces_on_ray(Point3 p, Function&& function) const {
        for_faces_on_ray(0, {0, static_cast<std::uint32_t>(faces_.size())}, p, function);
    }

private:
    /// A box around the triangles of a range of faces_. Its first child is the next node.
    struct Node {
        std::array<std::array<float, 3>, 3> axes{};  ///< slightly shorter than 1
        std::array<float, 3> min{}, max{};           ///< along the axes
        std::uint32_t second = 0;                    ///< second child; 0 if there are no children

        Point3 along_axes(Point3 p) const;
        /// Returns a lower bound of the squared distance between p and the triangles.
        double squared_distance(Point3 p) const;
        /// Whether the half-line from p in the direction of x may meet the triangles.
        bool is_on_ray(Point3 p) const;
    };
    /// A triangle while the tree is built.
    struct Item {
        Point3 centre;       ///< twice the centre of the bounding box
        double longest = 0;  ///< square of the longest edge
        Face face;
    };
    struct Range {
        std::uint32_t begin, end;

        std::uint32_t middle() const { return begin + (end - begin) / 2; }
    };

    std::array<Point3, 3> positions(const Face& face) const {
        const auto& [a, b, c] = face.corners;
        return {vertices_[a], vertices_[b], vertices_[c]};
    }
    Node box_around(std::span<const Item> items) const;
    void build(std::span<Item> items);
    void search(std::uint32_t number, Range range, Point3 p, Nearest& found) const;
    template <class Function>
    void for_faces_on_ray(std::uint32_t number, Range range, Point3 p, Function&& function) const {
        const Node& node = nodes_[number];
        if (!node.is_on_ray(p)) return;
        if (node.second == 0) {
            for (std::uint32_t i = range.begin; i < range.end; ++i) function(faces_[i].number);
            return;
        }
        for_faces_on_ray(number + 1, {range.begin, range.middle()}, p, function);
        for_faces_on_ray(node.second, {range.middle(), range.end}, p, function);
    }

    std::span<const Point3> vertices_;
    std::vector<Face> faces_;
    std::vector<Node> nodes_;
};

}  // namespace ccdt
