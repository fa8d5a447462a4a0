// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/ccdt/relax/capacity_integral.h"
#include "core/ccdt/relax/triangle_goals.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Sets the target and the weight of every triangle.
///
/// A triangle between three sites has half a site's capacity as target. The first row of sites should lie half a row
/// away from the border, so a strip of half a row in height lies along each border edge. Half of this strip is the
/// target of the triangle on the edge. The other half goes to the triangles that touch the border at one corner.
/// Targets are proportional to the length of the border edge, so that short edges of a coastline take no more than
/// their share. All border edges that one site faces count together as one triangle; otherwise each of them would pull
/// as strongly as a whole triangle. Triangles that touch the border at one corner get a fifth more than half of the
/// strip, because then the number of sites near the border is closest to its expected value: benchmark BorderPattern.
///
/// Edges between fixed sites that are closer together than the spacing count as border edges. However, the first row of
/// free sites is a whole row away from such edges.
///
/// @param capacity    of the mesh's domain, total > 0
/// @param capacities  [triangles]
/// @param goals       out [triangles]
/// @returns           the capacity variation: standard deviation over mean of capacity / target, in which each triangle
///                    is weighted by its target and triangles without a movable site are left out
///
/// Departure from Xu et al. 2011: there, all triangles have the same target, and sites crowd at the border.
double set_goals(const Triangulation& mesh, const CapacityIntegral& capacity, const std::vector<double>& capacities,
                 std::vector<TriangleGoal>& goals);

/// Sets the target and the weight of every triangle, as the first overload does, and returns the capacity variation.
/// @param total    capacity that the sites share
/// @param densest  largest capacity per area of the unit frame
double set_goals(const Triangulation& mesh, double total, double densest, const std::vector<double>& capacities,
                 std::vector<TriangleGoal>& goals);

/// Sets the goals in compact form, and returns the capacity variation; see the first overload. If few triangles have
/// goals of their own, the memory of `capacities` is reused for the weights of the other triangles.
/// @param in_row  [sites] whether a site lies in a row with equal capacities; may be empty. In the variation, triangles
///                all of whose sites lie in rows count as even; see find_border_goals()
double set_goals(const Triangulation& mesh, double total, double densest, std::vector<double> capacities,
                 TriangleGoals& goals, std::span<const std::uint8_t> in_row = {});

/// Sets the goals for a uniform density, and returns the capacity variation; see set_goals(). Capacities are areas, so
/// all triangles between free sites have the same goal.
/// @param total   area of the unit frame that the sites share
/// @param in_row  as for set_goals()
double set_even_goals(const Triangulation& mesh, double total, TriangleGoals& goals,
                      std::span<const std::uint8_t> in_row = {});

}  // namespace ccdt
