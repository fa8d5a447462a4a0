// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/bisection.h"

namespace ccdt {

std::vector<Part> Bisection::parts_of(const Domain& domain, const Triangulation& mesh) const {
    std::vector<Part> parts;
    const auto add = [&](const std::array<Point, 3>& corners) {
        const auto& [a, b, c] = corners;
        parts.push_back({corners, {flow(a, b), flow(b, c), flow(c, a)}});
    };
    if (domain.is_box()) {
        const Point end = domain.unit_bounds().max;
        add({{{0, 0}, {end.x, 0}, end}});
        add({{{0, 0}, end, {0, end.y}}});
        return parts;
    }
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) add(mesh.positions(t));
    return parts;
}

std::array<Part, 2> Bisection::halves(const Part& part) const {
    const auto squared_length = [&](std::size_t i) {
        const Point edge = part.corners[(i + 1) % 3] - part.corners[i];
        return dot(edge, edge);
    };
    const std::size_t first = squared_length(1) > squared_length(0) ? 1 : 0;
    const std::size_t longest = squared_length(2) > squared_length(first) ? 2 : first;
    const std::size_t next = (longest + 1) % 3, last = (longest + 2) % 3;
    const Point a = part.corners[longest], b = part.corners[next], c = part.corners[last];
    const Point middle = 0.5 * (a + b);
    const double half = flow(a, middle), across = flow(middle, c);
    return {Part{{a, middle, c}, {half, across, part.flows[last]}},
            Part{{middle, b, c}, {part.flows[longest] - half, part.flows[next], -across}}};
}

double Bisection::flow(Point a, Point b) const {
    return capacity_.is_uniform() ? 0.5 * cross(a, b) : capacity_.along(a, b);
}

}  // namespace ccdt
