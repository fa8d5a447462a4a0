// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/relax/capacity_integral.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "core/base/lanes.h"
#include "core/density/grid_walk.h"
#include "core/density/pieces_walk.h"
#include "core/mesh/edge_list.h"

namespace ccdt {

CapacityIntegral::CapacityIntegral(const Domain& domain, const Density& density, bool by_four)
    : density_(density), by_four_(by_four) {
    constexpr double kRounding = 1e-12;  // rounding of the sums along the border, relative to the density's total
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

/// Number of periodic copies of a torus' grid on each side of the box. Positions outside the box, and shifted
/// positions, lie within these copies.
constexpr int kRepeats = 8;

constexpr std::size_t kAreas = 32768;  ///< triangles per task

bool is_in(Point p, Point sides) {
    return p.x >= 0 && p.y >= 0 && p.x <= sides.x && p.y <= sides.y;
}

/// Whether the edge or an adjacent triangle extends beyond a torus' box.
bool leaves_box(const Triangulation& mesh, std::uint32_t edge) {
    return mesh.crosses_seam(Triangulation::triangle_of(edge)) ||
           mesh.crosses_seam(Triangulation::triangle_of(mesh.twin(edge))) ||
           !is_in(mesh.point(mesh.origin(edge)), mesh.period()) || !is_in(mesh.point(mesh.target(edge)), mesh.period());
}

/// Fills the lanes with number(0), number(1) and so on, two values per lane.
template <class Lanes, class Number>
CCDT_INLINE inline typename Lanes::Pairs each(Number&& number) {
    std::array<Pair, Lanes::kCount> pairs;
    for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) pairs[lane] = Pair{number(2 * lane), number(2 * lane + 1)};
    return Lanes::join(pairs);
}

}  // namespace

/// Returns the capacity of a torus between the ordinates 0 and y.
double CapacityIntegral::rows_below(double y) const {
    const double position = y * to_grid_.y;
    const int rows = density_.height();
    const double copy = std::floor(position / rows);
    const double inside = position - copy * rows;
    const auto row = static_cast<std::size_t>(std::min(static_cast<int>(inside), rows - 1));
    const double part = rows_below_[row + 1] - rows_below_[row];
    return copy * rows_below_.back() + rows_below_[row] + (inside - static_cast<double>(row)) * part;
}

/// Integrates along all segments. Each lane processes two segments at a time. The last segment is repeated to fill the
/// lanes.
template <bool kRepeated, class Lanes>
CCDT_INLINE inline void CapacityIntegral::sweep_by(std::span<const Segment> segments, std::span<Sweep> sweeps) const {
    using Pairs = typename Lanes::Pairs;
    constexpr std::size_t kCount = Segments<Lanes>::kCount;
    constexpr int kCopies = kRepeated ? 2 * kRepeats : 1;
    const int columns = density_.width(), rows = density_.height();
    const double width = columns, height = rows, stride = width + 1;
    const Point offset{kRepeated ? kRepeats * width : 0, kRepeated ? kRepeats * height : 0};
    const double* const all_sums = density_.row_sums(0).data();
    const double scale = to_grid_.x * to_grid_.y;
    for (std::size_t first = 0; first < segments.size(); first += kCount) {
        const auto segment = [&](std::size_t k) -> const Segment& {
            return segments[std::min(first + k, segments.size() - 1)];
        };
        const Segments<Lanes> few{
            each<Lanes>([&](std::size_t k) CCDT_INLINE { return segment(k).a.x * to_grid_.x + offset.x; }),
            each<Lanes>([&](std::size_t k) CCDT_INLINE { return segment(k).a.y * to_grid_.y + offset.y; }),
            each<Lanes>([&](std::size_t k) CCDT_INLINE { return segment(k).b.x * to_grid_.x + offset.x; }),
            each<Lanes>([&](std::size_t k) CCDT_INLINE { return segment(k).b.y * to_grid_.y + offset.y; })};
        const Pairs along_x = few.bx - few.ax;
        Pairs flow{}, near{}, far{};
        const auto add = [&](Pairs column, Pairs row, Pairs from, Pairs to) CCDT_INLINE {
            Pairs i = column, j = row,
                  copies{};  // number of periodic copies on the left of this one, counted from the offset
            if constexpr (kRepeated) {
                copies = Lanes::whole(column / width);
                i -= copies * width;
                j -= Lanes::whole(row / height) * height;
            }
            const Pairs at = j * stride + i;
            const auto sums = [&](std::size_t k) CCDT_INLINE { return all_sums + static_cast<std::size_t>(at[k]); };
            const Pairs before = each<Lanes>([&](std::size_t k) CCDT_INLINE { return sums(k)[0]; });
            const Pairs after = each<Lanes>([&](std::size_t k) CCDT_INLINE { return sums(k)[1]; });
            const Pairs value = after - before, length = to - from, middle = (from + to) * 0.5;
            const Pairs x = few.ax + middle * along_x;
            Pairs below = before + (x - column) * value;
            if constexpr (kRepeated) {
                const Pairs end = j * stride + width;
                const Pairs row_sum =
                    each<Lanes>([&](std::size_t k) CCDT_INLINE { return all_sums[static_cast<std::size_t>(end[k])]; });
                below += (copies - static_cast<double>(kRepeats)) * row_sum;
            }
            flow += below * length;
            near += value * length;
            far += value * length * middle;
        };
        walk_pieces(few, kCopies * columns, kCopies * rows, add);
        const Pairs flows = flow * (few.by - few.ay), nears = (near - far) * scale, fars = far * scale;
        for (std::size_t k = 0; k < std::min(kCount, segments.size() - first); ++k)
            sweeps[first + k] = {flows[k], nears[k], fars[k]};
    }
}

/// Integrates along all segments. `kRepeated` tells whether they may extend beyond a torus' box.
template <bool kRepeated>
void CapacityIntegral::sweep(std::span<const Segment> segments, std::span<Sweep> sweeps) const {
    with_lanes([&](auto lanes) CCDT_INLINE { sweep_by<kRepeated, decltype(lanes)>(segments, sweeps); },
               by_four_ && has_two_lanes());
}

/// Adds an edge's flow (Sweep::flow) to the capacity of its triangle, and subtracts the flow from the capacity of the
/// twin's triangle. On a torus, the position of the edge can differ between the two triangles.
/// @param repeated  whether the edge or a triangle may extend beyond a torus' box
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

/// Sums the flows along the edges of each triangle.
/// @param capacity  returns a reference to the sum of a triangle; the sum is initially 0
/// @param take      called with each edge and the integrals along it, in parallel
template <class Capacity, class Take>
void CapacityIntegral::sum_flows(const Triangulation& mesh, const std::stop_token& stop, Capacity&& capacity,
                                 Take&& take) const {
    constexpr std::size_t kRange = 8192;  // triangles per task
    const std::size_t triangles = mesh.triangle_count();
    // Contributions to triangles of other tasks.
    std::vector<std::vector<std::pair<std::uint32_t, double>>> later((triangles + kRange - 1) / kRange);
    for_ranges(mesh.executor(), triangles, kRange, [&](std::size_t begin, std::size_t end) {
        if (stop.stop_requested()) return;
        const auto add = [&](std::uint32_t triangle, double part) {
            if (triangle - begin < end - begin) {
                capacity(triangle) += part;
            } else {
                later[begin / kRange].emplace_back(triangle, part);
            }
        };
        constexpr std::size_t kTrianglesAtOnce = 64;  // number of triangles whose edges are listed at a time
        const auto is_first = [](std::uint32_t h, std::uint32_t twin) { return twin >= h; };
        const auto stays = [&](std::uint32_t h) { return !leaves_box(mesh, h); };
        std::array<std::uint32_t, 3 * kTrianglesAtOnce> edges;
        std::array<Segment, 3 * kTrianglesAtOnce> segments;
        std::array<Sweep, 3 * kTrianglesAtOnce> sweeps;
        for (std::size_t few = begin; few < end; few += kTrianglesAtOnce) {
            const std::size_t count = list_edges(mesh, few, std::min(few + kTrianglesAtOnce, end), edges, is_first);
            const auto last = edges.begin() + static_cast<std::ptrdiff_t>(count);
            const auto middle = mesh.is_torus() ? std::partition(edges.begin(), last, stays) : last;
            const auto inside = static_cast<std::size_t>(middle - edges.begin());
            for (std::size_t i = 0; i < count; ++i) {
                const Point a = mesh.point(mesh.origin(edges[i]));
                segments[i] = {a, i < inside ? mesh.point(mesh.target(edges[i])) : a + mesh.along(edges[i])};
            }
            sweep<false>(std::span(segments).first(inside), sweeps);
            sweep<true>(std::span(segments).first(count).subspan(inside), std::span(sweeps).subspan(inside));
            for (std::size_t i = 0; i < count; ++i) {
                take(edges[i], sweeps[i]);
                add_flow(mesh, edges[i], sweeps[i].flow, i >= inside, add);
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
        return sum_flows(mesh, stop, capacity, [](std::uint32_t, const Sweep&) {});
    }
    capacities.resize(mesh.triangle_count());
    for_ranges(mesh.executor(), capacities.size(), kAreas, [&](std::size_t begin, std::size_t end) {
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
    sum_flows(mesh, stop, capacity, [&](std::uint32_t h, const Sweep& found) {
        swept(h) = found.near;
        if (mesh.twin(h) != Triangulation::kNone) swept(mesh.twin(h)) = found.far;
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
    const auto cell = [](double position, int count) {
        return static_cast<int>(std::clamp(position, 0.0, count - 1.0));
    };
    const int column = cell(g.x, density_.width()), row = cell(g.y, density_.height());
    return density_.value(column, row) * to_grid_.x * to_grid_.y;
}

}  // namespace ccdt
