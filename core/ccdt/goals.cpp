#include "core/ccdt/goals.h"

#include <algorithm>
#include <cmath>

#include "core/ccdt/border.h"

namespace ccdt {

double set_goals(const Triangulation& mesh, const Capacity& capacity, const std::vector<double>& capacities,
                 std::vector<TriangleGoal>& goals) {
    constexpr double kEdgeShare = 0.5, kCornerShare = 0.61;
    constexpr double kLeastTarget = 1e-9;  // less is rounding
    const double unit = 2 * static_cast<double>(mesh.site_count()) / capacity.total();
    const double largest_weight = unit * capacity.densest();
    goals.resize(mesh.triangle_count());
    double targets = 0, sum = 0, squares = 0;
    for (std::uint32_t t = 0; t < goals.size(); ++t) {
        const double reached = unit * std::max(0.0, capacities[t]);
        TriangleGoal& goal = goals[t];
        const double area = mesh.doubled_area(t);
        goal.weight = area > 0 ? std::min(reached / area, largest_weight) : largest_weight;
        int sites = 0;
        double border = 0;
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Triangulation::edge(t, i);
            if (mesh.is_site(mesh.origin(h))) ++sites;
            if (mesh.twin(h) != Triangulation::kNone) continue;
            const Point edge = mesh.point(mesh.target(h)) - mesh.point(mesh.origin(h));
            border += std::sqrt(dot(edge, edge));
        }
        if (sites == 3) {
            goal.target = 1;
        } else if (sites == 0) {
            goal.target = reached;  // nothing there can move it
        } else if (border > 0) {
            goal.target = goal.weight > 0 ? kEdgeShare * border / hexagonal_spacing(goal.weight) : 0;
        } else {
            goal.target = kCornerShare;
        }
        if (goal.target < kLeastTarget || sites == 0) continue;
        targets += goal.target;
        sum += reached;
        squares += reached * reached / goal.target;
    }
    // Mean and variance of reached / target, each triangle weighing as much as its target.
    if (!(sum > 0)) return 0;
    const double mean = sum / targets;
    return std::sqrt(std::max(0.0, squares / targets - mean * mean)) / mean;
}

}  // namespace ccdt
