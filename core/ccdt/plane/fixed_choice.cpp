// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/fixed_choice.h"

#include <utility>

#include "core/ccdt/plane/thinned_points.h"
#include "core/mesh/insertion.h"

namespace ccdt {

FixedSites choose_fixed(const Domain& domain, std::span<const Point> points, std::span<const double> weights,
                        double spacing, Triangulation& trial) {
    constexpr double kApart = 0.2, kOthersApart = 0.02, kFromBorder = 0.05;  // relative to the spacing
    FixedSites chosen;
    ThinnedPoints kept(domain, kApart * spacing), others(domain, kOthersApart * spacing);
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        if (const auto near = kept.near(points[i])) {
            chosen.weights[*near] += weights[i];
            if (!others.near(points[i])) others.add(points[i]);
        } else if (insert_site(trial, i, points[i], kFromBorder * spacing)) {
            kept.add(points[i]);
            chosen.weights.push_back(weights[i]);
        } else if (!others.near(points[i])) {
            others.add(points[i]);
        }
    }
    chosen.positions = std::move(kept).take();
    chosen.others = std::move(others).take();
    return chosen;
}

}  // namespace ccdt
