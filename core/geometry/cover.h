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

/// Says which triangles of an arrangement rings cover. Groups of chains are the rings: of each ring what is inside by
/// the even-odd rule, of each part the outer ring without the holes, and all parts together.
class Cover {
public:
    /// What a group is.
    struct Kind {
        std::size_t part = 0;
        bool is_hole = false;
    };

    /// @param kinds       [groups]
    /// @param resolution  what is no thicker than this, about, is nothing
    /// @param stop        asked between its steps, each of which looks at all triangles once; leaves what is of no use
    /// All but the last must outlive this.
    Cover(const Chains& chains, const Arrangement& map, std::span<const Kind> kinds, double resolution,
          const std::stop_token& stop = {});

    /// What is wrong with the rings. Nothing, if they are valid by OGC Simple Features.
    const Faults& faults() const { return faults_; }

    /// Whether any two segments meet but at the end of one, where the next one of their chain begins.
    bool has_contacts() const { return !map_.meetings.empty() || !shared_.empty(); }

    /// Borders of what is covered, on the right of it. Each goes through one fan of triangles at each corner.
    std::vector<Ring> trace() const;

private:
    /// Triangles that no segment parts from each other.
    struct Face {
        double area = 0;
        double border = 0;  ///< length
        bool is_thin = false;
        bool is_covered = false;
        bool is_known = false;
    };
    struct Part {
        std::uint32_t outer = 0;  ///< group
        std::size_t holes = 0;    ///< that are open where the way is
        std::size_t faces = 0;    ///< covered by it alone, and entered across its own border
    };
    /// A point in one place with others.
    struct Shared {
        std::uint32_t vertex, group, point;
        friend auto operator<=>(const Shared&, const Shared&) = default;
    };

    Point corner(std::uint32_t triangle, std::size_t i) const {
        return map_.points[map_.triangles[triangle].corners[i % 3]];
    }
    double area(std::uint32_t triangle) const;
    bool is_wall(std::uint32_t triangle, std::size_t edge) const;
    bool is_covered(std::uint32_t triangle) const { return faces_[face_of_[triangle]].is_covered; }
    bool is_border(std::uint32_t triangle, std::size_t edge) const;
    bool covers(const Part& part) const { return is_open_[part.outer] && part.holes == 0; }

    void find_shared_points();
    void find_faces();
    void walk();
    void enter(std::uint32_t triangle, std::uint32_t set);
    void cross(std::uint32_t set);
    void turn(std::uint32_t group);
    void examine(std::uint32_t set, Point place);
    void settle_thin_faces();
    void find_flat_rings();
    void find_meetings();
    void find_cut_parts();
    bool is_at(std::uint32_t vertex, std::uint32_t group) const;
    void add(Fault fault, std::uint32_t ring, std::uint32_t other, std::uint32_t point, Point place);

    const Chains& chains_;
    const Arrangement& map_;
    std::span<const Kind> kinds_;
    double resolution_;
    Faults faults_;
    std::vector<Shared> shared_;           ///< in order
    std::vector<std::uint32_t> first_of_;  ///< [groups] first point; kNone of a ring without corners
    std::vector<std::uint32_t> face_of_;   ///< [triangles]
    std::vector<Face> faces_;

    // Where the way through the triangles is.
    std::vector<Part> parts_;
    std::vector<bool> is_open_;          ///< [groups]
    std::vector<std::uint32_t> open_;    ///< groups, those entered last behind
    std::size_t covering_ = 0;           ///< parts
    std::size_t passed_ = 0;             ///< triangles of faces that are not thin, entered so far
    std::vector<std::size_t> thick_in_;  ///< [groups] those entered while it was open
};

}  // namespace ccdt
