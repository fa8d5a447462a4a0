// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/cell_list.h"

#include <cassert>

namespace ccdt {

namespace {

/// Number of points above which a cell gets a nested grid.
constexpr std::uint32_t kMaxPerCell = 32;

/// Limit on the depth of nested grids. Points closer than the size of the deepest cells nearly coincide. Rounding can
/// reduce the width of cells to zero even at smaller depths.
constexpr int kMaxDepth = 16;

}  // namespace

template <class P>
void BasicCellList<P>::sort(std::span<const P> positions, P min, P max) {
    assert(!positions.empty());
    sorted_.reserve(positions.size());
    for (const P p : positions) sorted_.push_back({p, static_cast<std::uint32_t>(sorted_.size())});
    divide(min, max, 0, static_cast<std::uint32_t>(sorted_.size()), 0);
}

template <class P>
void BasicCellList<P>::find_near(P p, double reach, std::vector<Run>& runs) const {
    runs.clear();
    const Grid& grid = grids_.front();
    const Range x = around(p.x, reach, grid.x), y = around(p.y, reach, grid.y);
    const Range z = around(height(p), reach, grid.z);
    for (int k = z.first; k <= z.last; ++k) {
        const int layer = wrapped(k, grid.z.cells);
        const double below = height(p) - (k - layer) / grid.z.cells * height(sides_);
        for (int j = y.first; j <= y.last; ++j) {
            const int row = wrapped(j, grid.y.cells);
            const std::size_t cell = grid.cell(0, row, layer);
            const double from = p.y - (j - row) / grid.y.cells * sides_.y;
            // On a torus, cells beyond one end continue at the other end.
            const auto add = [&](int first, int last, int period) {
                const int shift = period * grid.x.cells;
                const Range part{std::max(first, x.first) - shift, std::min(last, x.last) - shift};
                if (part.first > part.last) return;
                add_row(cell, part, vector(p.x - period * sides_.x, from, below), reach, runs);
            };
            add(-grid.x.cells, -1, -1);
            add(0, grid.x.cells - 1, 0);
            add(grid.x.cells, 2 * grid.x.cells - 1, 1);
        }
    }
}

template <class P>
void BasicCellList<P>::add_row(std::size_t row, Range columns, P p, double reach, std::vector<Run>& runs) const {
    const std::size_t last = row + static_cast<std::size_t>(columns.last);
    std::size_t k = row + static_cast<std::size_t>(columns.first);
    while (k <= last) {
        const std::uint32_t begin = cells_[k].begin;
        while (k <= last && cells_[k].grid == 0) ++k;
        if (cells_[k].begin > begin) runs.push_back({begin, cells_[k].begin});
        if (k > last) return;
        const Grid& inner = grids_[cells_[k++].grid];
        const Range x = inner.x.within(p.x, reach), y = inner.y.within(p.y, reach), z = inner.layers(p, reach);
        for (int layer = z.first; layer <= z.last; ++layer) {
            for (int j = y.first; j <= y.last; ++j) add_row(inner.cell(0, j, layer), x, p, reach, runs);
        }
    }
}

template <class P>
std::vector<std::uint32_t> BasicCellList<P>::numbers() const {
    std::vector<std::uint32_t> numbers;
    numbers.reserve(sorted_.size());
    for (const Listed& listed : sorted_) numbers.push_back(listed.number);
    return numbers;
}

template <class P>
void BasicCellList<P>::divide(P min, P max, std::uint32_t begin, std::uint32_t end, int depth) {
    const double count = end - begin;
    const P sides = max - min;
    const double side = cell_side(sides, count);
    const auto axis = [&](double origin, double length) -> Axis {
        if (!(length > 0)) return {};
        const int cells = std::max(1, static_cast<int>(length < count * side ? length / side : count));
        return {origin, cells / length, cells};
    };
    const Grid grid{axis(min.x, sides.x), axis(min.y, sides.y), axis(height(min), height(sides)), cells_.size()};
    const int columns = grid.x.cells, rows = grid.y.cells, layers = grid.z.cells;
    grids_.push_back(grid);
    const std::size_t last = grid.cell(columns - 1, rows - 1, layers - 1);
    cells_.resize(last + 2, {0});

    const std::vector<Listed> unsorted(sorted_.begin() + begin, sorted_.begin() + end);
    for (const Listed& listed : unsorted) ++cells_[grid.cell(listed.position)].begin;
    std::uint32_t upto = begin;
    for (std::size_t k = grid.first; k <= last; ++k) upto = cells_[k].begin += upto;
    cells_[last + 1].begin = end;
    for (std::size_t i = unsorted.size(); i-- > 0;)
        sorted_[--cells_[grid.cell(unsorted[i].position)].begin] = unsorted[i];

    if (depth == kMaxDepth) return;
    const P size = vector(sides.x / columns, sides.y / rows, height(sides) / layers);
    for (int layer = 0; layer < layers; ++layer) {
        for (int row = 0; row < rows; ++row) {
            for (int column = 0; column < columns; ++column) {
                const std::size_t k = grid.cell(column, row, layer);
                const std::uint32_t from = cells_[k].begin, to = cells_[k + 1].begin;
                const P corner = min + vector(column * size.x, row * size.y, layer * height(size));
                const P inner = (corner + size) - corner;
                if (to - from <= kMaxPerCell || !(std::max({inner.x, inner.y, height(inner)}) > 0)) continue;
                cells_[k].grid = static_cast<std::uint32_t>(grids_.size());
                divide(corner, corner + size, from, to, depth + 1);
            }
        }
    }
}

template <>
BasicCellList<Point>::BasicCellList(const Domain& domain, std::span<const Point> positions)
    : torus_(domain.is_torus()), sides_(domain.unit_bounds().max) {
    sort(positions, domain.unit_bounds().min, domain.unit_bounds().max);
}

template <>
BasicCellList<Point3>::BasicCellList(std::span<const Point3> positions) : torus_(false) {
    const Box3 box = bounds_of(positions);
    sort(positions, box.min, box.max);
}

template <>
BasicCellList<Point3>::BasicCellList(Point3 torus, std::span<const Point3> positions) : torus_(true), sides_(torus) {
    sort(positions, {}, torus);
}

template class BasicCellList<Point>;
template class BasicCellList<Point3>;

}  // namespace ccdt
