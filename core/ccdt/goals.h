#pragma once

#include <vector>

#include "core/ccdt/capacity_integral.h"
#include "core/ccdt/triangle_goals.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Sets the target of every triangle, and the weight of its area.
///
/// A triangle between three sites aims at the capacity of half a site. Along the border the first row of sites
/// belongs half a row away from it, and so a triangle on an edge of the border aims at what the strip of half a row's
/// height over that edge leaves it: half the strip, the other half going to the triangles that touch the border
/// with one corner. The edge counts with its length, so that short edges of a coastline claim no more than their
/// share, and the many edges that one site may face there count as one triangle together: each by itself would pull
/// as hard as a whole one. A fifth more than half for those that touch with a corner keeps the number of sites near the
/// border closest to their share: benchmark BorderPattern.
///
/// Fixed sites that are closer together than sites are count as a border of that kind, but the first row of free ones
/// is a whole row away from them.
///
/// @param capacity    of the mesh's domain, its total > 0
/// @param capacities  [triangles]
/// @param goals       out [triangles]
/// @returns  the capacity variation: standard deviation over mean of capacity / target, each triangle weighing as much
///           as its target; triangles between vertices of the border alone, which no site can move, left out
/// Departs from Xu et al. 2011, where all triangles aim at the same and sites crowd onto the border.
double set_goals(const Triangulation& mesh, const CapacityIntegral& capacity, const std::vector<double>& capacities,
                 std::vector<TriangleGoal>& goals);

/// The same where capacities come from elsewhere.
/// @param total    that the sites are to share
/// @param densest  largest capacity per area of the unit frame
double set_goals(const Triangulation& mesh, double total, double densest, const std::vector<double>& capacities,
                 std::vector<TriangleGoal>& goals);

/// The same for all triangles together, whose weights take the capacities' room where most have no goal of their own.
double set_goals(const Triangulation& mesh, double total, double densest, std::vector<double> capacities,
                 TriangleGoals& goals);

/// The same where capacities are areas: all triangles between free sites have one goal.
/// @param total  area of the unit frame that the sites are to share
double set_even_goals(const Triangulation& mesh, double total, TriangleGoals& goals);

}  // namespace ccdt
