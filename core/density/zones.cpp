// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/density/zones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr double kLeastChange = 0.1;  ///< least difference at a step, relative to the larger value
constexpr double kSharp = 2.2;        ///< least difference per cell at a step, relative to the slopes beside it
constexpr double kFewestSites = 4;    ///< number of sites in a cell that resolve it, and in the smallest zone

/// Whether two values differ enough for a step.
bool differ(double a, double b) {
    return std::abs(b - a) > kLeastChange * std::max(a, b);
}

/// Finds the zones of a density.
class ZoneSearch {
public:
    ZoneSearch(const Density& density, bool periodic, double sites)
        : density_(density),
          counts_{density.width(), density.height()},
          periodic_(periodic),
          sites_(sites / density.total()) {}

    std::vector<std::uint32_t> execute();

private:
    using Cell = std::array<int, 2>;  ///< column and row

    /// Properties of a cell.
    enum Flag : std::uint8_t {
        kStepRight = 1,  ///< a step divides the cell from the next cell in its row
        kStepUp = 2,     ///< a step divides the cell from the next cell in its column
        kInside = 4,     ///< the cell has an intermediate value inside a step, or is in a zone that is too small
        kListed = 8,     ///< the cell is in the next layer of cells to be added to a zone
    };

    std::uint32_t number(Cell c) const { return static_cast<std::uint32_t>(c[1] * counts_[0] + c[0]); }
    Cell cell(std::uint32_t number) const {
        const int place = static_cast<int>(number);
        return {place % counts_[0], place / counts_[0]};
    }
    double value(Cell c) const { return density_.value(c[0], c[1]); }
    double value(std::uint32_t number) const { return value(cell(number)); }
    std::optional<Cell> moved(Cell from, std::size_t axis, int by) const;
    double slope(Cell from, std::size_t axis, int way) const;
    bool is_step(Cell from, Cell to, std::size_t axis, int length) const;
    bool lies_between(Cell cell, Cell from, Cell to) const;
    bool is_surely_even(Cell cell, std::size_t axis) const;
    bool find_steps();
    template <class Visit>
    void for_neighbours(std::uint32_t number, Visit&& visit) const;
    bool flood(std::uint32_t first, std::uint32_t zone);
    std::uint32_t zone_beside(std::uint32_t cell) const;
    void fill();

    const Density& density_;
    std::array<int, 2> counts_;  ///< columns and rows
    bool periodic_;
    double sites_;  ///< sites in a cell with the value 1
    std::vector<std::uint8_t> flags_;
    std::vector<std::uint32_t> zones_;
    std::vector<std::uint32_t> list_;  ///< cells of the current zone or layer
};

/// Returns the cell that is a number of cells further along an axis; none outside the grid.
std::optional<ZoneSearch::Cell> ZoneSearch::moved(Cell from, std::size_t axis, int by) const {
    const int count = counts_[axis];
    int& place = from[axis];
    place += by;
    if (place >= 0 && place < count) return from;
    if (!periodic_) return std::nullopt;
    place = (place % count + count) % count;
    return from;
}

/// Returns the absolute slope of the density, averaged over up to three cells from a cell in one direction.
double ZoneSearch::slope(Cell from, std::size_t axis, int way) const {
    constexpr int kCells = 3;
    for (int cells = kCells; cells > 0; --cells) {
        if (const auto far = moved(from, axis, cells * way)) return std::abs(value(*far) - value(from)) / cells;
    }
    return 0;
}

/// Whether there is a step between two cells.
/// @param length  distance of the cells along the axis
bool ZoneSearch::is_step(Cell from, Cell to, std::size_t axis, int length) const {
    const double a = value(from), b = value(to);
    if (!differ(a, b)) return false;
    const bool is_resolved = sites_ * std::max(a, b) >= kFewestSites;
    if (length == 1 && is_resolved) return true;
    const double steepest = std::abs(b - a) / (kSharp * length);  // slope beside the step
    return !is_resolved && slope(from, axis, -1) < steepest && slope(to, axis, 1) < steepest;
}

/// Whether the value of a cell lies clearly between the values of two others.
bool ZoneSearch::lies_between(Cell cell, Cell from, Cell to) const {
    const auto [low, high] = std::minmax({value(from), value(to)});
    const double margin = kLeastChange * high;
    return low + margin < value(cell) && value(cell) < high - margin;
}

/// Tests quickly whether the values of a cell and of the next two cells along an axis are about the same. Returns false
/// in uncertain cases.
bool ZoneSearch::is_surely_even(Cell cell, std::size_t axis) const {
    if (cell[axis] + 2 >= counts_[axis]) return false;
    const double here = value(cell);
    ++cell[axis];
    const double next = value(cell);
    ++cell[axis];
    const double second = value(cell);
    return !differ(here, next) && !differ(here, second);
}

bool ZoneSearch::find_steps() {
    flags_.assign(static_cast<std::size_t>(counts_[0]) * static_cast<std::size_t>(counts_[1]), 0);
    bool found = false;
    for (int row = 0; row < counts_[1]; ++row) {
        for (int column = 0; column < counts_[0]; ++column) {
            const Cell cell{column, row};
            for (std::size_t axis = 0; axis < 2; ++axis) {
                if (is_surely_even(cell, axis)) continue;
                const auto next = moved(cell, axis, 1), second = moved(cell, axis, 2);
                if (next && is_step(cell, *next, axis, 1)) {
                    flags_[number(cell)] |= axis == 0 ? kStepRight : kStepUp;
                    found = true;
                }
                if (second && lies_between(*next, cell, *second) && is_step(cell, *second, axis, 2)) {
                    flags_[number(*next)] |= kInside;
                    found = true;
                }
            }
        }
    }
    return found;
}

/// Calls visit(number of a neighbouring cell, whether a step divides the two cells).
template <class Visit>
void ZoneSearch::for_neighbours(std::uint32_t number, Visit&& visit) const {
    const Cell at = cell(number);
    std::uint32_t stride = 1;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const std::uint8_t flag = axis == 0 ? kStepRight : kStepUp;
        const auto count = static_cast<std::uint32_t>(counts_[axis]);
        const bool is_first = at[axis] == 0, is_last = at[axis] + 1 == counts_[axis];
        if (!is_last || periodic_)
            visit(is_last ? number - (count - 1) * stride : number + stride, (flags_[number] & flag) != 0);
        if (!is_first || periodic_) {
            const std::uint32_t before = is_first ? number + (count - 1) * stride : number - stride;
            visit(before, (flags_[before] & flag) != 0);
        }
        stride *= count;
    }
}

/// Makes a zone of all cells that are connected with a cell, and lists them.
/// @returns  whether there is space for a few sites, at the largest density in the zone or across its steps
bool ZoneSearch::flood(std::uint32_t first, std::uint32_t zone) {
    double largest = 0;
    list_.assign(1, first);
    zones_[first] = zone;
    for (std::size_t i = 0; i < list_.size(); ++i) {
        const std::uint32_t cell = list_[i];
        largest = std::max(largest, value(cell));
        for_neighbours(cell, [&](std::uint32_t next, bool divided) {
            if (zones_[next] == zone) return;
            if (divided || (flags_[next] & kInside) != 0) {
                largest = std::max(largest, value(next));
            } else if (zones_[next] == kNone) {
                zones_[next] = zone;
                list_.push_back(next);
            }
        });
    }
    return sites_ * largest * static_cast<double>(list_.size()) >= kFewestSites;
}

/// Returns the zone beside a cell that has the most similar density; kNone if no cell beside it has a zone.
std::uint32_t ZoneSearch::zone_beside(std::uint32_t cell) const {
    double least = std::numeric_limits<double>::infinity();
    std::uint32_t zone = kNone;
    for_neighbours(cell, [&](std::uint32_t next, bool) {
        const double change = std::abs(value(next) - value(cell));
        if (zones_[next] == kNone || change >= least) return;
        least = change;
        zone = zones_[next];
    });
    return zone;
}

/// Adds the cells without a zone to the zones around them, layer by layer.
void ZoneSearch::fill() {
    list_.clear();
    for (std::uint32_t cell = 0; cell < zones_.size(); ++cell) {
        if (zones_[cell] == kNone && zone_beside(cell) != kNone) list_.push_back(cell);
    }
    std::vector<std::uint32_t> layer, zones;
    while (!list_.empty()) {
        layer.swap(list_);
        list_.clear();
        zones.clear();
        for (const std::uint32_t cell : layer) zones.push_back(zone_beside(cell));
        for (std::size_t i = 0; i < layer.size(); ++i) zones_[layer[i]] = zones[i];
        for (const std::uint32_t cell : layer) {
            for_neighbours(cell, [&](std::uint32_t next, bool) {
                if (zones_[next] != kNone || (flags_[next] & kListed) != 0) return;
                flags_[next] |= kListed;
                list_.push_back(next);
            });
        }
    }
}

std::vector<std::uint32_t> ZoneSearch::execute() {
    if (!find_steps()) return {};
    zones_.assign(flags_.size(), kNone);
    std::uint32_t zones = 0;
    for (std::uint32_t cell = 0; cell < zones_.size(); ++cell) {
        if (zones_[cell] != kNone || (flags_[cell] & kInside) != 0) continue;
        if (flood(cell, zones)) {
            ++zones;
            continue;
        }
        for (const std::uint32_t small : list_) {
            zones_[small] = kNone;
            flags_[small] |= kInside;
        }
    }
    if (zones < 2) return {};
    fill();
    return std::move(zones_);
}

}  // namespace

std::vector<std::uint32_t> find_zones(const Density& density, bool periodic, double sites) {
    return ZoneSearch(density, periodic, sites).execute();
}

}  // namespace ccdt
