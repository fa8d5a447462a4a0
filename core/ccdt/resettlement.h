#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/ccdt/triangle_goals.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Takes sites from where there are too many to where there are too few, each within its part of the domain. A tongue
/// that holds one site too many, or none, is mended by no small moves: they would have to pass its neck in line.
///
/// Lists of a mesh's edges, and of what is around its sites, must be made anew afterwards.
class Resettlement {
public:
    /// @param mesh          trimmed, not a torus', all of its sites free
    /// @param goals         [triangles]; of these the weights alone count
    /// @param least_height  that triangles are to have
    /// O(triangles).
    Resettlement(Triangulation& mesh, const TriangleGoals& goals, double least_height = 0);

    /// Takes sites away that are, with their neighbours, more than half a one too many for their capacity, to where as
    /// much is missing.
    /// @returns  how many have been taken. O(sites), and O(n log n) of those that are too many or too few
    std::size_t even_out();

    /// Takes a site away to the neighbour of that one which has most capacity for itself.
    /// @returns  false, and it stays, if this is next to where another one has been taken from or to. O(sites)
    bool take_away(std::uint32_t site);

private:
    struct Candidate {
        double sites;  ///< too many or too few around it
        std::uint32_t site;
    };

    void share_out(const TriangleGoals& goals);
    void sum_around();
    std::vector<Candidate> candidates(double sign) const;
    std::uint32_t room_beside(std::uint32_t site, std::uint32_t other) const;
    bool relocate(std::uint32_t site, std::uint32_t beside);
    void settle(std::uint32_t site);

    Triangulation& mesh_;
    double least_height_;
    std::vector<double> surplus_;          ///< [sites] 1 - the capacity that is a site's own, in sites
    std::vector<double> around_;           ///< [sites] its surplus and its neighbours'
    std::vector<std::uint32_t> roomiest_;  ///< [sites] its largest triangle
    std::vector<bool> settled_;            ///< [sites]: what is told of it is true no more
};

}  // namespace ccdt
