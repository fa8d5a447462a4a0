#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/point.h"
#include "core/halftone/ground.h"
#include "core/halftone/reduction.h"
#include "core/parallel/team.h"

namespace ccdt {

/// Side of the tonal scale that a dot is drawn on.
enum class Side : std::uint8_t {
    Ink,    ///< ink on white ground
    Paper,  ///< bare paper on black ground
};

/// Options of a halftone with dots on both sides of the tonal scale.
struct TwoSidedOptions {
    std::optional<std::size_t> sites;  ///< number of dots, >= 1
    std::optional<double> radius;      ///< of the largest dots, in cells, > 0; one of the two at least
    double detail = 0;                 ///< in [0, 1]; how far edges are emphasised
    double least_radius = 0;           ///< radius in cells below which no dot is planned, as far as that is possible
};

/// Plan of a halftone that draws the minority: ink dots on white ground, paper dots on black ground.
///
/// Ink dots cover 1 - Y of white ground, paper dots cover Y of black ground, where Y is the light of the picture. Both
/// are at most about one half: dots hardly ever overlap, and their number times their area is the tone. All dots are one
/// point set, whose density does not jump where the ground changes near Y = 1/2.
struct TwoSidedPlan {
    CellGrid cells;
    Ground ground;
    std::vector<float> light;    ///< [cells] the picture
    std::vector<float> white;    ///< [cells] share of white ground
    std::vector<float> density;  ///< [cells] relative density of the sites; zero everywhere if the ground says all
    std::vector<float> area;     ///< [cells] area of a dot there, in cells
    double dots = 0;             ///< number of dots of these areas that give the picture its tone
    double radius = 0;           ///< of the largest dots, in cells
};

/// Divides the picture into grounds and plans the dots.
///
/// Areas follow from what an eye sees. A pattern that covers the share c by dots of density rho has, after a blur, a
/// contrast in lightness of c L'(Y) exp(-k rho), L' being the slope of CIE lightness. For a given number of dots the
/// sum of that is least where rho is proportional to log(1 + c L'(Y) / mu). So dots are smaller in shadows, where paper
/// is conspicuous, and in highlights.
///
/// @param light  [cells] in [0, 1], linear light
/// @param stop   asked between steps; a stop ends it early, with nothing of use
/// Same input, same bytes, on any executor. O(cells).
TwoSidedPlan plan_two_sided(std::vector<float> light, const CellGrid& cells, const TwoSidedOptions& options,
                            const std::stop_token& stop = {}, Team& team = alone());

/// Dots as they are drawn.
struct SidedDots {
    std::vector<float> radii;  ///< [dots], in cells
    std::vector<Side> sides;   ///< [dots], the side of the centre
    std::vector<bool> cut;     ///< [dots]; false: the boundary of the ground is not near
};

/// Chooses the radii of dots such that the local mean of what is drawn is that of the picture, also where the boundary
/// of the ground cuts dots: where it does, the part of a dot beyond the boundary has the opposite colour.
///
/// @param sites  in cells, y down the rows
/// @param fit    false: each dot has the area that is planned where it lies
/// Same input, same bytes, on any executor. O(cells + sites).
SidedDots size_dots(const TwoSidedPlan& plan, std::span<const Point> sites, bool fit, const std::stop_token& stop = {},
                    Team& team = alone());

}  // namespace ccdt
