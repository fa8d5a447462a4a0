// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/pictures.h"

#include <algorithm>
#include <cmath>

#include "tests/support/meshes.h"

namespace ccdt::test {

Density pear() {
    return grid_of(160, 160, [](int i, int j) {
        const double x = (i + 0.5) / 160 - 0.5, y = (j + 0.5) / 160;
        const double belly = std::hypot(x, y - 0.35) / 0.28, neck = std::hypot(x, y - 0.68) / 0.15;
        if (std::min(belly, neck) >= 1) return 0.0;
        return 0.15 + 0.8 * std::max(0.0, 0.5 + 1.5 * x);
    });
}

Density thin_lines() {
    return grid_of(200, 200, [](int i, int j) { return i % 50 == 20 || j % 66 == 40 || i == j ? 1.0 : 0.0; });
}

Density strokes() {
    return grid_of(240, 120, [](int i, int j) {
        const int x = i % 20, y = j % 30, letter = (i / 20 * 7 + j / 30 * 5) % 8;
        if (y < 6 || y > 24 || x > 14) return 0.0;
        const bool stem = letter % 2 == 0 && x < 3, bar = letter % 3 == 0 && y < 9, roof = letter % 3 == 1 && y > 21;
        const bool slope = letter > 4 && std::abs(14 * (y - 6) - 18 * x) < 30;
        return stem || bar || roof || slope ? 1.0 : 0.0;
    });
}

Density spot_and_corner() {
    return grid_of(48, 64, [](int i, int j) {
        const double x = i / 48.0 - 0.5, y = j / 64.0 - 0.5;
        return 0.02 + std::exp(-20 * (x * x + y * y)) + (i > 30 && j > 40 ? 1.0 : 0.0);
    });
}

std::size_t count_on_white(const Domain& domain, const Density& density, const std::vector<Point>& points) {
    const Box box = domain.bounds();
    return static_cast<std::size_t>(std::count_if(points.begin(), points.end(), [&](Point p) {
        const int column = static_cast<int>((p.x - box.min.x) / box.width() * density.width());
        const int row = static_cast<int>((p.y - box.min.y) / box.height() * density.height());
        return !(density.value(std::min(column, density.width() - 1), std::min(row, density.height() - 1)) > 0);
    }));
}

}  // namespace ccdt::test
