#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/ccdt/triangle_goals.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Takes sites from where there are too many to where there are too few, each within its part of the domain. A tongue
/// that holds one site too many, or none, is mended by no small moves: they would have to pass its neck in line.
///
/// Lists of a mesh's edges, and of what is around its sites, must be made anew afterwards.
class Resettlement {
public:
    /// @param mesh          trimmed, not a torus', all of its sites free
    /// @param goals         [triangles]; of these the weights alone count; must outlive this
    /// @param least_height  that triangles are to have
    /// O(triangles).
    Resettlement(Triangulation& mesh, const TriangleGoals& goals, double least_height = 0);

    /// Takes sites away that are, with their neighbours, more than half a one too many for their capacity, to where as
    /// much is missing.
    /// @returns  how many have been taken. O(sites), and O(n log n) of those that are too many or too few
    std::size_t even_out();

    /// Relocates a site next to one of the sites of its part that have most capacity for themselves: the first of these
    /// beside which it has `enough` distance to all other sites, else the one where it has most.
    /// @param least  distance that it must have
    /// @returns      false, and it stays, if there is no such place, or if it is next to where another site has been
    ///               taken from or to. O(sites)
    bool take_away(std::uint32_t site, double least = 0, double enough = 0);

    /// Relocates one of two sites that are too near to each other, the second one of them perhaps in another part. In
    /// a part of few sites it moves to the place farthest from all other sites, those across water included; in a
    /// larger part, as by take_away().
    /// @returns  false, and both stay, if no place is farther from other sites than they are from each other. O(sites),
    ///           and O(triangles) once; in a small part O(its triangles) times the sites nearby
    bool separate(std::array<std::uint32_t, 2> pair);

private:
    struct Candidate {
        double sites;  ///< too many or too few around it
        std::uint32_t site;
    };
    /// A place for a site in a small part.
    struct Place {
        double squared = 0;  ///< distance to the nearest other site, squared
        std::uint32_t triangle = 0;
        Point point;
    };
    /// Triangles and sites of the small parts.
    struct SmallParts {
        std::vector<std::size_t> sites;                     ///< [parts], of the large ones too
        std::vector<std::vector<std::uint32_t>> triangles;  ///< [parts], none of the large ones
    };

    void share_out();
    void sum_around();
    std::vector<Candidate> candidates(double sign) const;
    std::uint32_t room_beside(std::uint32_t site, std::uint32_t other) const;
    double clearance_beside(std::uint32_t to, std::uint32_t site) const;
    bool relocate(std::uint32_t site, std::uint32_t beside);
    void settle(std::uint32_t site);
    const SmallParts& small_parts();
    bool is_in_small_part(std::uint32_t site);
    Place farthest_place(std::uint32_t site);
    double enough_squared(std::uint32_t site) const;
    std::vector<Point> sites_near(std::span<const std::uint32_t> triangles, std::uint32_t but, double reach) const;
    bool has_room(std::uint32_t triangle, double share) const;

    Triangulation& mesh_;
    const TriangleGoals& goals_;
    double least_height_;
    std::optional<SmallParts> small_parts_;  ///< once they are asked for
    std::vector<double> surplus_;            ///< [sites] 1 - the capacity that is a site's own, in sites
    std::vector<double> around_;             ///< [sites] its surplus and its neighbours'
    std::vector<std::uint32_t> roomiest_;    ///< [sites] its largest triangle
    std::vector<bool> settled_;              ///< [sites]: what is told of it is true no more
};

}  // namespace ccdt
