#include "core/ccdt/capacity_integral.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "core/density/grid_walk.h"
#include "core/mesh/edge_list.h"

namespace ccdt {

CapacityIntegral::CapacityIntegral(const Domain& domain, const Density& density) : density_(density) {
    constexpr double kRounding = 1e-12;  // of the sums along the border, over the density's total
    if (density.is_uniform()) {
        total_ = domain.unit_area();
        return;
    }
    to_grid_ = {density.width() / domain.unit_bounds().width(), density.height() / domain.unit_bounds().height()};
    if (domain.is_torus()) {
        total_ = density.total();
        rows_below_.push_back(0);
        for (int row = 0; row < density.height(); ++row) {
            rows_below_.push_back(rows_below_.back() + density.row_sums(row).back());
        }
        return;
    }
    for (const Ring& ring : domain.rings()) {
        for (std::size_t i = 0; i < ring.size(); ++i) total_ += along(ring[i], ring[(i + 1) % ring.size()]);
    }
    if (total_ < kRounding * density.total()) total_ = 0;
}

double CapacityIntegral::along(Point a, Point b) const {
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

namespace {

/// Copies of a torus' grid on each side of it; more than places and shifts come to.
constexpr int kRepeats = 8;

constexpr std::size_t kAreas = 32768;  ///< that a task takes

bool is_in(Point p, Point sides) {
    return p.x >= 0 && p.y >= 0 && p.x <= sides.x && p.y <= sides.y;
}

/// Tells whether the edge or a triangle at it reaches beyond a torus' box.
bool leaves_box(const Triangulation& mesh, std::uint32_t edge) {
    return mesh.crosses_seam(Triangulation::triangle_of(edge)) ||
           mesh.crosses_seam(Triangulation::triangle_of(mesh.twin(edge))) ||
           !is_in(mesh.point(mesh.origin(edge)), mesh.period()) || !is_in(mesh.point(mesh.target(edge)), mesh.period());
}

}  // namespace

/// Integral of the rows' totals up to y.
double CapacityIntegral::rows_below(double y) const {
    const double place = y * to_grid_.y;
    const int rows = density_.height();
    const double copy = std::floor(place / rows);
    const double inside = place - copy * rows;
    const auto row = static_cast<std::size_t>(std::min(static_cast<int>(inside), rows - 1));
    const double part = rows_below_[row + 1] - rows_below_[row];
    return copy * rows_below_.back() + rows_below_[row] + (inside - static_cast<double>(row)) * part;
}

template <bool kRepeated>
CapacityIntegral::Sweep CapacityIntegral::sweep(Point a, Point b) const {
    const int columns = density_.width(), rows = density_.height();
    constexpr int kCopies = kRepeated ? 2 * kRepeats : 1;
    const Point offset{kRepeated ? static_cast<double>(kRepeats) * columns : 0.0,
                       kRepeated ? static_cast<double>(kRepeats) * rows : 0.0};
    const Point from = to_grid(a) + offset, to = to_grid(b) + offset;
    const double* all_sums = density_.row_sums(0).data();
    const auto stride = static_cast<std::ptrdiff_t>(columns) + 1;
    Sweep sum;
    walk_pieces(from, to, kCopies * columns, kCopies * rows, [&](int column, int row, double t0, double t1) {
        const double* sums = all_sums + (kRepeated ? row % rows : row) * stride;
        const int i = kRepeated ? column % columns : column;
        const double value = sums[i + 1] - sums[i];
        const double length = t1 - t0, middle = (t0 + t1) / 2;
        const double x = from.x + middle * (to.x - from.x);
        double below = sums[i] + (x - column) * value;
        if (kRepeated) below += (column / columns - kRepeats) * sums[columns];
        sum.flow += below * length;
        sum.near += value * length;
        sum.far += value * length * middle;
    });
    const double scale = to_grid_.x * to_grid_.y;
    return {sum.flow * (to.y - from.y), (sum.near - sum.far) * scale, sum.far * scale};
}

/// Adds an edge's flow to the capacities of its two triangles, which around a torus may see it in different places.
template <class Add>
void CapacityIntegral::add_flow(const Triangulation& mesh, std::uint32_t edge, double flow, bool repeated,
                                Add&& add) const {
    const std::uint32_t twin = mesh.twin(edge);
    if (!repeated) {
        add(Triangulation::triangle_of(edge), flow);
        if (twin != Triangulation::kNone) add(Triangulation::triangle_of(twin), -flow);
        return;
    }
    const Point a = mesh.point(mesh.origin(edge)), b = a + mesh.along(edge);
    const double rise = rows_below(b.y) - rows_below(a.y);
    add(Triangulation::triangle_of(edge), flow + mesh.lift(edge).x * rise);
    add(Triangulation::triangle_of(twin), -(flow + (mesh.lift(twin) - mesh.shift(edge)).x * rise));
}

/// Sums up the flows along the edges around each triangle.
/// @param capacity  gives the sum of a triangle, which is 0
/// @param flow      called with each edge and whether it leaves a torus' box, several at the same time
template <class Capacity, class Flow>
void CapacityIntegral::sum_flows(const Triangulation& mesh, const std::stop_token& stop, Capacity&& capacity,
                                 Flow&& flow) const {
    constexpr std::size_t kRange = 8192;  // triangles that a task takes
    const std::size_t triangles = mesh.triangle_count();
    // Of those that other tasks have.
    std::vector<std::vector<std::pair<std::uint32_t, double>>> later((triangles + kRange - 1) / kRange);
    for_ranges(mesh.team(), triangles, kRange, [&](std::size_t begin, std::size_t end) {
        if (stop.stop_requested()) return;
        const auto add = [&](std::uint32_t triangle, double part) {
            if (triangle - begin < end - begin) {
                capacity(triangle) += part;
            } else {
                later[begin / kRange].emplace_back(triangle, part);
            }
        };
        constexpr std::size_t kFew = 128;  // triangles whose edges are listed at a time
        const auto is_first = [](std::uint32_t h, std::uint32_t twin) { return twin >= h; };
        std::array<std::uint32_t, 3 * kFew> edges;
        for (std::size_t few = begin; few < end; few += kFew) {
            const std::size_t count = list_edges(mesh, few, std::min(few + kFew, end), edges, is_first);
            for (const std::uint32_t h : std::span(edges).first(count)) {
                const bool repeated = mesh.is_torus() && leaves_box(mesh, h);
                add_flow(mesh, h, flow(h, repeated), repeated, add);
            }
        }
    });
    for (const auto& list : later) {
        for (const auto& [triangle, part] : list) capacity(triangle) += part;
    }
}

void CapacityIntegral::of_triangles(const Triangulation& mesh, std::vector<double>& capacities,
                                    const std::stop_token& stop) const {
    if (!is_uniform()) {
        capacities.assign(mesh.triangle_count(), 0);
        const auto capacity = [&](std::uint32_t triangle) -> double& { return capacities[triangle]; };
        return sum_flows(mesh, stop, capacity, [&](std::uint32_t h, bool repeated) {
            const Point a = mesh.point(mesh.origin(h));
            return repeated ? sweep<true>(a, a + mesh.along(h)).flow : along(a, mesh.point(mesh.target(h)));
        });
    }
    capacities.resize(mesh.triangle_count());
    for_ranges(mesh.team(), capacities.size(), kAreas, [&](std::size_t begin, std::size_t end) {
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) capacities[t] = mesh.doubled_area(t) / 2;
    });
}

void CapacityIntegral::of_edges(const Triangulation& mesh, std::vector<TriangleFlows>& flows,
                                const std::stop_token& stop) const {
    flows.assign(mesh.triangle_count(), {});
    const auto capacity = [&](std::uint32_t triangle) -> double& { return flows[triangle].capacity; };
    const auto swept = [&](std::uint32_t h) -> double& {
        return flows[Triangulation::triangle_of(h)].swept[Triangulation::number_of(h)];
    };
    sum_flows(mesh, stop, capacity, [&](std::uint32_t h, bool repeated) {
        const Point a = mesh.point(mesh.origin(h)), b = a + mesh.along(h);
        const Sweep found = repeated ? sweep<true>(a, b) : sweep<false>(a, b);
        swept(h) = found.near;
        if (mesh.twin(h) != Triangulation::kNone) swept(mesh.twin(h)) = found.far;
        return found.flow;
    });
}

int CapacityIntegral::cells_along(Point a, Point b) const {
    if (is_uniform()) return 1;
    const Point span = to_grid(b - a);
    return 1 + static_cast<int>(std::abs(span.x) + std::abs(span.y));
}

double CapacityIntegral::at(Point p) const {
    if (is_uniform()) return 1;
    Point g = to_grid(p);
    if (!rows_below_.empty()) {
        g = {g.x - std::floor(g.x / density_.width()) * density_.width(),
             g.y - std::floor(g.y / density_.height()) * density_.height()};
    }
    const auto cell = [](double place, int count) { return static_cast<int>(std::clamp(place, 0.0, count - 1.0)); };
    const int column = cell(g.x, density_.width()), row = cell(g.y, density_.height());
    return density_.value(column, row) * to_grid_.x * to_grid_.y;
}

}  // namespace ccdt
