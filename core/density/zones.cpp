// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/density/zones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr double kMinChange = 0.1;  ///< least difference at a step, relative to the larger value
constexpr double kSharp = 2.2;      ///< least difference per cell at a step, relative to the slopes beside it
constexpr double kMinSites = 4;     ///< number of sites in a cell that resolve it, and in the smallest zone

/// Whether two values differ enough for a step.
bool differ(double a, double b) {
    return std::abs(b - a) > kMinChange * std::max(a, b);
}

using Cell = std::array<int, 3>;  ///< column, row and layer

/// Finds the zones of a density.
/// @tparam Value  returns the value of the cell with a number, counted along rows, then columns, then layers
template <class Value>
class ZoneSearch {
public:
    /// @param counts  columns, rows and layers
    /// @param sites   sites in a cell with the value 1
    ZoneSearch(const Cell& counts, Value value, bool periodic, double sites)
        : counts_(counts),
          strides_{1, counts[0], counts[0] * counts[1]},
          axes_(counts[2] > 1 ? 3 : 2),
          value_(std::move(value)),
          periodic_(periodic),
          sites_(sites) {}

    std::vector<std::uint32_t> execute();

private:
    /// Properties of a cell.
    enum Flag : std::uint8_t {
        kStepRight = 1,  ///< a step divides the cell from the next cell in its row
        kStepUp = 2,     ///< a step divides the cell from the next cell in its column
        kStepAway = 4,   ///< a step divides the cell from the same cell of the next layer
        kInside = 8,     ///< the cell has an intermediate value inside a step, or is in a zone that is too small
        kListed = 16,    ///< the cell is in the next layer of cells to be added to a zone
    };
    static constexpr std::array<std::uint8_t, 3> kSteps{kStepRight, kStepUp, kStepAway};

    std::uint32_t number(const Cell& c) const {
        return static_cast<std::uint32_t>((c[2] * counts_[1] + c[1]) * counts_[0] + c[0]);
    }
    Cell cell(std::uint32_t number) const {
        const int position = static_cast<int>(number), row = position / counts_[0];
        return {position % counts_[0], row % counts_[1], row / counts_[1]};
    }
    std::uint32_t moved(const Cell& from, std::size_t axis, int by) const;
    double slope(const Cell& from, std::size_t axis, int first, int way) const;
    bool is_step(const Cell& from, std::size_t axis, int length) const;
    bool lies_between(std::uint32_t cell, std::uint32_t from, std::uint32_t to) const;
    bool is_surely_even(const Cell& cell, std::size_t axis) const;
    bool find_steps_from(const Cell& cell);
    bool find_steps();
    template <class Visit>
    void for_neighbours(std::uint32_t number, Visit&& visit) const;
    bool flood(std::uint32_t first, std::uint32_t zone);
    std::uint32_t zone_beside(std::uint32_t cell) const;
    void fill();

    Cell counts_;
    Cell strides_;  ///< differences of the numbers of neighbouring cells along each axis
    std::size_t axes_;
    Value value_;
    bool periodic_;
    double sites_;
    std::vector<std::uint8_t> flags_;
    std::vector<std::uint32_t> zones_;
    std::vector<std::uint32_t> list_;  ///< cells of the current zone or layer
};

/// Returns the number of the cell that is some cells further along an axis; kNone outside the grid.
template <class Value>
std::uint32_t ZoneSearch<Value>::moved(const Cell& from, std::size_t axis, int by) const {
    const int count = counts_[axis];
    int position = from[axis] + by;
    if (position < 0 || position >= count) {
        if (!periodic_) return kNone;
        position = (position % count + count) % count;
    }
    return number(from) + static_cast<std::uint32_t>((position - from[axis]) * strides_[axis]);
}

/// Returns the absolute slope of the density, averaged over up to three cells in one direction.
/// @param first  distance of the first of these cells from `from`
template <class Value>
double ZoneSearch<Value>::slope(const Cell& from, std::size_t axis, int first, int way) const {
    constexpr int kCells = 3;
    for (int cells = kCells; cells > 0; --cells) {
        const std::uint32_t far = moved(from, axis, first + cells * way);
        if (far != kNone) return std::abs(value_(far) - value_(moved(from, axis, first))) / cells;
    }
    return 0;
}

/// Whether there is a step between a cell and the one that is `length` cells further.
template <class Value>
bool ZoneSearch<Value>::is_step(const Cell& from, std::size_t axis, int length) const {
    const double a = value_(number(from)), b = value_(moved(from, axis, length));
    if (!differ(a, b)) return false;
    const bool is_resolved = sites_ * std::max(a, b) >= kMinSites;
    if (is_resolved) return length == 1;
    const double steepest = std::abs(b - a) / (kSharp * length);  // slope beside the step
    return slope(from, axis, 0, -1) < steepest && slope(from, axis, length, 1) < steepest;
}

/// Whether the value of a cell lies clearly between the values of two others.
template <class Value>
bool ZoneSearch<Value>::lies_between(std::uint32_t cell, std::uint32_t from, std::uint32_t to) const {
    const auto [low, high] = std::minmax({value_(from), value_(to)});
    const double margin = kMinChange * high;
    return low + margin < value_(cell) && value_(cell) < high - margin;
}

/// Tests quickly whether the values of a cell and of the next two cells along an axis are about the same. Returns false
/// in uncertain cases.
template <class Value>
bool ZoneSearch<Value>::is_surely_even(const Cell& cell, std::size_t axis) const {
    if (cell[axis] + 2 >= counts_[axis]) return false;
    const auto stride = static_cast<std::uint32_t>(strides_[axis]);
    const std::uint32_t at = number(cell);
    const double here = value_(at);
    return !differ(here, value_(at + stride)) && !differ(here, value_(at + 2 * stride));
}

/// Finds the steps between a cell and the next two cells along each axis. Returns whether there are any.
template <class Value>
bool ZoneSearch<Value>::find_steps_from(const Cell& cell) {
    bool found = false;
    for (std::size_t axis = 0; axis < axes_; ++axis) {
        if (is_surely_even(cell, axis)) continue;
        const std::uint32_t next = moved(cell, axis, 1), second = moved(cell, axis, 2);
        if (next != kNone && is_step(cell, axis, 1)) {
            flags_[number(cell)] |= kSteps[axis];
            found = true;
        }
        if (second != kNone && lies_between(next, number(cell), second) && is_step(cell, axis, 2)) {
            flags_[next] |= kInside;
            found = true;
        }
    }
    return found;
}

template <class Value>
bool ZoneSearch<Value>::find_steps() {
    std::size_t cells = 1;
    for (const int count : counts_) cells *= static_cast<std::size_t>(count);
    flags_.assign(cells, 0);
    bool found = false;
    for (std::uint32_t i = 0; i < cells; ++i) found |= find_steps_from(cell(i));
    return found;
}

/// Calls visit(number of a neighbouring cell, whether a step divides the two cells).
template <class Value>
template <class Visit>
void ZoneSearch<Value>::for_neighbours(std::uint32_t number, Visit&& visit) const {
    const Cell at = cell(number);
    for (std::size_t axis = 0; axis < axes_; ++axis) {
        const std::uint8_t flag = kSteps[axis];
        const auto count = static_cast<std::uint32_t>(counts_[axis]),
                   stride = static_cast<std::uint32_t>(strides_[axis]);
        const bool is_first = at[axis] == 0, is_last = at[axis] + 1 == counts_[axis];
        if (!is_last || periodic_)
            visit(is_last ? number - (count - 1) * stride : number + stride, (flags_[number] & flag) != 0);
        if (!is_first || periodic_) {
            const std::uint32_t before = is_first ? number + (count - 1) * stride : number - stride;
            visit(before, (flags_[before] & flag) != 0);
        }
    }
}

/// Makes a zone of all cells that are connected with a cell, and lists them.
/// @returns  whether there is space for a few sites, at the largest density in the zone or across its steps
template <class Value>
bool ZoneSearch<Value>::flood(std::uint32_t first, std::uint32_t zone) {
    double largest = 0;
    list_.assign(1, first);
    zones_[first] = zone;
    for (std::size_t i = 0; i < list_.size(); ++i) {
        const std::uint32_t cell = list_[i];
        largest = std::max(largest, value_(cell));
        for_neighbours(cell, [&](std::uint32_t next, bool divided) {
            if (zones_[next] == zone) return;
            if (divided || (flags_[next] & kInside) != 0) {
                largest = std::max(largest, value_(next));
            } else if (zones_[next] == kNone) {
                zones_[next] = zone;
                list_.push_back(next);
            }
        });
    }
    return sites_ * largest * static_cast<double>(list_.size()) >= kMinSites;
}

/// Returns the zone beside a cell that has the most similar density; kNone if no cell beside it has a zone.
template <class Value>
std::uint32_t ZoneSearch<Value>::zone_beside(std::uint32_t cell) const {
    double least = std::numeric_limits<double>::infinity();
    std::uint32_t zone = kNone;
    for_neighbours(cell, [&](std::uint32_t next, bool) {
        const double change = std::abs(value_(next) - value_(cell));
        if (zones_[next] == kNone || change >= least) return;
        least = change;
        zone = zones_[next];
    });
    return zone;
}

/// Adds the cells without a zone to the zones around them, layer by layer.
template <class Value>
void ZoneSearch<Value>::fill() {
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

template <class Value>
std::vector<std::uint32_t> ZoneSearch<Value>::execute() {
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
    const auto value = [&density, columns = static_cast<std::uint32_t>(density.width())](std::uint32_t cell) {
        return density.value(static_cast<int>(cell % columns), static_cast<int>(cell / columns));
    };
    return ZoneSearch({density.width(), density.height(), 1}, value, periodic, sites / density.total()).execute();
}

std::vector<std::uint32_t> find_zones(const std::array<std::size_t, 3>& voxels, std::span<const float> values,
                                      bool periodic, double sites) {
    const auto value = [values](std::uint32_t cell) -> double { return values[cell]; };
    const double total = std::accumulate(values.begin(), values.end(), 0.0);
    const Cell counts{static_cast<int>(voxels[0]), static_cast<int>(voxels[1]), static_cast<int>(voxels[2])};
    return ZoneSearch(counts, value, periodic, sites / total).execute();
}

std::vector<std::vector<std::uint32_t>> group_into_classes(std::span<const double> densities) {
    constexpr double kSame = 1.2;  // largest ratio of successive densities of one class
    constexpr std::size_t kMaxClasses = 16;
    std::vector<std::uint32_t> order(densities.size());
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t zone) { return densities[zone]; });
    std::vector<std::vector<std::uint32_t>> classes;
    double last = -1;
    for (const std::uint32_t zone : order) {
        if (densities[zone] > kSame * last && classes.size() < kMaxClasses) classes.emplace_back();
        classes.back().push_back(zone);
        last = densities[zone];
    }
    return classes;
}

}  // namespace ccdt
