// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/delaunay.h"
#include "core/geometry/faults.h"
#include "core/geometry/polygon.h"

namespace ccdt {

/// Finds the triangles of an arrangement that a set of rings covers. Each group of chains is one ring. Rings enclose by
/// the even-odd rule. A part is its outer ring minus its holes. The covered area is the union of all parts.
class Cover {
public:
    /// The role of a group: the number of its part, and whether the group is a hole of the part.
    struct Kind {
        std::size_t part = 0;
        bool is_hole = false;
    };

    /// @param kinds       [groups]
    /// @param resolution  faces of about this thickness or less count as empty; in the unit frame
    /// @param stop        polled between steps, each of which visits all triangles; after a stop the object must not be
    ///                    used
    ///
    /// All arguments except `stop` must outlive this object.
    Cover(const Chains& chains, const Arrangement& map, std::span<const Kind> kinds, double resolution,
          const std::stop_token& stop = {});

    /// Returns the faults of the rings. Empty if the rings are valid by OGC Simple Features.
    const Faults& faults() const { return faults_; }

    /// Whether two segments touch anywhere other than at the end point shared by successive segments of a chain.
    bool has_contacts() const { return !map_.meetings.empty() || !shared_.empty(); }

    /// Returns the borders of the covered area, which lies on their left. Where several separate sectors of the area
    /// meet at a vertex, each sector has its own corner there.
    std::vector<Ring> trace() const;

private:
    /// A connected set of triangles that no segment separates.
    struct Face {
        double area = 0;
        double border = 0;  ///< length of the border
        bool is_thin = false;
        bool is_covered = false;
        bool is_known = false;
    };
    struct Part {
        std::uint32_t outer = 0;  ///< number of the group that is the outer ring
        std::size_t holes = 0;    ///< number of holes that contain the current triangle
        /// Number of faces of the part that walk() entered across the part's border. Excludes thin faces, and faces
        /// that other parts cover as well.
        std::size_t faces = 0;
    };
    /// An input point that coincides with other input points.
    struct Shared {
        std::uint32_t vertex, group, point;
        friend auto operator<=>(const Shared&,
                                const Shared&) = default;  // NOLINT(modernize-use-nullptr): in the default
    };

    Point corner(std::uint32_t triangle, std::size_t i) const {
        return map_.points[map_.triangles[triangle].corners[i % 3]];
    }
    double area(std::uint32_t triangle) const;
    bool has_segment(std::uint32_t triangle, std::size_t edge) const;
    bool is_covered(std::uint32_t triangle) const { return faces_[face_of_[triangle]].is_covered; }
    bool is_border(std::uint32_t triangle, std::size_t edge) const;
    bool covers(const Part& part) const { return is_open_[part.outer] && part.holes == 0; }

    void find_shared_points();
    void find_faces();
    void walk();
    void enter(std::uint32_t triangle, std::uint32_t set);
    void cross(std::uint32_t set);
    void toggle(std::uint32_t group);
    void examine(std::uint32_t set, Point position);
    void settle_thin_faces();
    void find_flat_rings();
    void find_meetings();
    void find_cut_parts();
    bool is_at(std::uint32_t vertex, std::uint32_t group) const;
    void add(Fault fault, std::uint32_t ring, std::uint32_t other, std::uint32_t point, Point position);

    const Chains& chains_;
    const Arrangement& map_;
    std::span<const Kind> kinds_;
    double resolution_;
    Faults faults_;
    std::vector<Shared> shared_;           ///< sorted by vertex, group and point
    std::vector<std::uint32_t> first_of_;  ///< [groups] first point; kNone for a ring without corners
    std::vector<std::uint32_t> face_of_;   ///< [triangles] number of the face
    std::vector<Face> faces_;

    // State of the walk through the triangles.
    std::vector<Part> parts_;
    std::vector<bool> is_open_;          ///< [groups] whether the ring contains the current triangle
    std::vector<std::uint32_t> open_;    ///< open groups, the most recently entered last
    std::size_t covering_ = 0;           ///< number of parts that cover the current triangle
    std::size_t passed_ = 0;             ///< number of triangles entered so far, except in thin faces
    std::vector<std::size_t> thick_in_;  ///< [groups] number of triangles counted in passed_ while the ring was open
};

}  // namespace ccdt
