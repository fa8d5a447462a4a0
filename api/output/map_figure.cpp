// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/map_figure.h"

#include <algorithm>
#include <tuple>

namespace ccdt::api {

std::vector<MixedDot> mixed_dots(const PointSet& points) {
    struct Placed {
        MixedDot dot;
        double share;  // of the layer's dots in the group that come before
    };
    std::vector<Placed> placed;
    placed.reserve(points.size());
    for (std::uint32_t layer = 0; layer < points.layers.size(); ++layer) {
        points.for_groups(points.layers[layer], [&](std::uint32_t feature, std::size_t first, std::size_t count) {
            for (std::size_t i = 0; i < count; ++i)
                placed.push_back(
                    {{feature, layer, first + i}, (static_cast<double>(i) + 0.5) / static_cast<double>(count)});
        });
    }
    std::ranges::sort(placed, {},
                      [](const Placed& each) { return std::tuple(each.dot.feature, each.share, each.dot.layer); });
    std::vector<MixedDot> dots;
    dots.reserve(placed.size());
    for (const Placed& each : placed) dots.push_back(each.dot);
    return dots;
}

}  // namespace ccdt::api
