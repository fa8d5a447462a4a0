// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/polish/cell_list.h"

#include <cassert>

namespace ccdt {

namespace {

/// Number of points above which a cell gets a nested grid.
constexpr std::uint32_t kMaxPerCell = 32;

/// Limit on the depth of nested grids. Points closer than the size of the deepest cells nearly coincide. Rounding can
/// reduce the width of cells to zero even at smaller depths.
constexpr int kMaxDepth = 16;

}  // namespace

CellList::CellList(const Domain& domain, std::span<const Point> places)
    : torus_(domain.is_torus()), sides_(domain.unit_bounds().max) {
    assert(!places.empty());
    sorted_.reserve(places.size());
    for (const Point p : places) sorted_.push_back({p, static_cast<std::uint32_t>(sorted_.size())});
    divide(domain.unit_bounds(), 0, static_cast<std::uint32_t>(sorted_.size()), 0);
}

void CellList::find_near(Point p, double reach, std::vector<Run>& runs) const {
    runs.clear();
    const Grid& grid = grids_.front();
    const Range x = around(p.x, reach, grid.x), y = around(p.y, reach, grid.y);
    for (int j = y.first; j <= y.last; ++j) {
        const int row = wrapped(j, grid.y.cells);
        const Point from{p.x, p.y - (j - row) / grid.y.cells * sides_.y};
        // On a torus, cells beyond one end continue at the other end.
        const auto add = [&](int first, int last, int period) {
            const int shift = period * grid.x.cells;
            const Range part{std::max(first, x.first) - shift, std::min(last, x.last) - shift};
            if (part.first <= part.last) add_row(grid, row, part, {p.x - period * sides_.x, from.y}, reach, runs);
        };
        add(-grid.x.cells, -1, -1);
        add(0, grid.x.cells - 1, 0);
        add(grid.x.cells, 2 * grid.x.cells - 1, 1);
    }
}

void CellList::add_row(const Grid& grid, int row, Range columns, Point p, double reach, std::vector<Run>& runs) const {
    const std::size_t last = grid.cell(columns.last, row);
    std::size_t k = grid.cell(columns.first, row);
    while (k <= last) {
        const std::uint32_t begin = cells_[k].begin;
        while (k <= last && cells_[k].grid == 0) ++k;
        if (cells_[k].begin > begin) runs.push_back({begin, cells_[k].begin});
        if (k > last) return;
        const Grid& inner = grids_[cells_[k++].grid];
        const Range inside{inner.x.cell(p.x - reach), inner.x.cell(p.x + reach)};
        for (int j = inner.y.cell(p.y - reach); j <= inner.y.cell(p.y + reach); ++j)
            add_row(inner, j, inside, p, reach, runs);
    }
}

std::vector<std::uint32_t> CellList::numbers() const {
    std::vector<std::uint32_t> numbers;
    numbers.reserve(sorted_.size());
    for (const Listed& listed : sorted_) numbers.push_back(listed.number);
    return numbers;
}

/// Sorts points into the cells of a grid over the box, and recurses into crowded cells.
void CellList::divide(const Box& box, std::uint32_t begin, std::uint32_t end, int depth) {
    const double count = end - begin;
    const double side = std::sqrt(box.width() * box.height() / count);
    const auto cells = [&](double length) { return std::max(1, static_cast<int>(std::min(length / side, count))); };
    const int columns = cells(box.width()), rows = cells(box.height());
    const Grid grid{{box.min.x, columns / box.width(), columns}, {box.min.y, rows / box.height(), rows}, cells_.size()};
    grids_.push_back(grid);
    const std::size_t last = grid.cell(columns - 1, rows - 1);
    cells_.resize(last + 2, {0});

    const std::vector<Listed> unsorted(sorted_.begin() + begin, sorted_.begin() + end);
    for (const Listed& listed : unsorted) ++cells_[grid.cell(listed.place)].begin;
    std::uint32_t upto = begin;
    for (std::size_t k = grid.first; k <= last; ++k) upto = cells_[k].begin += upto;
    cells_[last + 1].begin = end;
    for (std::size_t i = unsorted.size(); i-- > 0;) sorted_[--cells_[grid.cell(unsorted[i].place)].begin] = unsorted[i];

    if (depth == kMaxDepth) return;
    const double width = box.width() / columns, height = box.height() / rows;
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            const std::size_t k = grid.cell(column, row);
            const std::uint32_t from = cells_[k].begin, to = cells_[k + 1].begin;
            const Point corner = box.min + Point{column * width, row * height};
            const Box inner{corner, corner + Point{width, height}};
            if (to - from <= kMaxPerCell || !(inner.width() > 0 && inner.height() > 0)) continue;
            cells_[k].grid = static_cast<std::uint32_t>(grids_.size());
            divide(inner, from, to, depth + 1);
        }
    }
}

}  // namespace ccdt
