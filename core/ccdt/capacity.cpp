#include "core/ccdt/capacity.h"

#include <algorithm>
#include <cmath>

#include "core/density/grid_walk.h"

namespace ccdt {

Capacity::Capacity(const Domain& domain, const Density& density) : density_(density) {
    constexpr double kRounding = 1e-12;  // of the sums along the border, over the density's total
    if (density.is_uniform()) {
        total_ = domain.unit_area();
        return;
    }
    to_grid_ = {density.width() / domain.unit_bounds().width(), density.height() / domain.unit_bounds().height()};
    for (const Ring& ring : domain.rings()) {
        for (std::size_t i = 0; i < ring.size(); ++i) total_ += along(ring[i], ring[(i + 1) % ring.size()]);
    }
    if (total_ < kRounding * density.total()) total_ = 0;
}

double Capacity::along(Point a, Point b) const {
    double sum = 0;
    const double* all_sums = density_.row_sums(0).data();
    const auto stride = static_cast<std::ptrdiff_t>(density_.width()) + 1;
    walk_cells(to_grid(a), to_grid(b), density_.width(), density_.height(),
               [&](int column, int row, double x, double dy) {
                   const double* sums = all_sums + row * stride + column;
                   sum += (sums[0] + (x - column) * (sums[1] - sums[0])) * dy;
               });
    return sum;
}

void Capacity::of_triangles(const Triangulation& mesh, std::vector<double>& capacities) const {
    capacities.assign(mesh.triangle_count(), 0);
    if (is_uniform()) {
        for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) capacities[t] = mesh.doubled_area(t) / 2;
        return;
    }
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Triangulation::edge(t, i), twin = mesh.twin(h);
            if (twin < h) continue;  // kNone is the largest number
            const double flow = along(mesh.point(mesh.origin(h)), mesh.point(mesh.target(h)));
            capacities[t] += flow;
            if (twin != Triangulation::kNone) capacities[Triangulation::triangle_of(twin)] -= flow;
        }
    }
}

int Capacity::cells_along(Point a, Point b) const {
    if (is_uniform()) return 1;
    const Point span = to_grid(b - a);
    return 1 + static_cast<int>(std::abs(span.x) + std::abs(span.y));
}

double Capacity::at(Point p) const {
    if (is_uniform()) return 1;
    const Point g = to_grid(p);
    const int column = std::clamp(static_cast<int>(g.x), 0, density_.width() - 1);
    const int row = std::clamp(static_cast<int>(g.y), 0, density_.height() - 1);
    return density_.value(column, row) * to_grid_.x * to_grid_.y;
}

}  // namespace ccdt
