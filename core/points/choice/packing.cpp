// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/choice/packing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

#include "core/ccdt/polish/cell_list.h"

namespace ccdt::choice {

namespace {

/// Least spacing, relative to the box, so that squares do not vanish.
constexpr double kLeastSpacing = 1e-150;

/// Greedy search for a large independent set in the graph of candidates that are too near to each other.
class Packing {
public:
    Packing(std::span<const Point3> positions, Point3 torus, std::span<const double> priorities, double spacing)
        : positions_(positions),
          spacing_(std::max(spacing, kLeastSpacing)),
          cells_(torus.x > 0 ? CellList3(torus, positions) : CellList3(positions)),
          levels_(levels_of(priorities)),
          is_out_(positions.size(), 0) {}

    /// Chooses a candidate, and excludes those that are too near.
    void choose(std::uint32_t candidate) {
        chosen_.push_back(candidate);
        is_out_[candidate] = 1;
        excluded_.clear();
        for_near(candidate, [&](std::uint32_t near) {
            if (std::exchange(is_out_[near], 1) == 0) excluded_.push_back(near);
        });
    }

    /// Chooses among some candidates, of which none is excluded: of those with the highest priority the one that
    /// excludes the fewest others.
    void run(std::span<const std::uint32_t> candidates, const std::stop_token& stop) {
        degrees_.assign(positions_.size(), kAbsent);
        for (const std::uint32_t each : candidates) degrees_[each] = 0;
        for (const std::uint32_t each : candidates) {
            for_near(each, [&](std::uint32_t near) { degrees_[each] += degrees_[near] != kAbsent ? 1 : 0; });
            queue_.push(entry_of(each));
        }
        std::vector<std::uint32_t> changed;
        while (!queue_.empty() && !stop.stop_requested()) {
            const auto [level, degree, candidate] = queue_.top();
            queue_.pop();
            if (is_out_[candidate] != 0 || degree != degrees_[candidate]) continue;
            choose(candidate);
            changed.clear();
            for (const std::uint32_t each : excluded_) {
                if (degrees_[each] == kAbsent) continue;
                for_near(each, [&](std::uint32_t near) {
                    if (is_out_[near] != 0 || degrees_[near] == kAbsent) return;
                    --degrees_[near];
                    changed.push_back(near);
                });
            }
            std::ranges::sort(changed);
            changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
            for (const std::uint32_t each : changed) queue_.push(entry_of(each));
        }
    }

    /// Chooses any candidates that are not excluded, in order of their priority.
    void fill(const std::stop_token& stop) {
        std::vector<std::uint32_t> order(positions_.size());
        std::iota(order.begin(), order.end(), 0U);
        std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return levels_[i]; });
        for (const std::uint32_t each : order) {
            if (stop.stop_requested()) return;
            if (is_out_[each] == 0) choose(each);
        }
    }

    /// Returns candidates that are not excluded: of those in a cell whose side is an eighth of the spacing, or a
    /// quarter in space, the one with the highest priority. This limits the number of neighbours.
    std::vector<std::uint32_t> representatives(bool is_solid) const {
        const double side = spacing_ / (is_solid ? 4 : 8);
        using Cell = std::tuple<double, double, double, std::uint32_t, std::uint32_t>;  // cell, level, number
        std::vector<Cell> cells;
        for (std::uint32_t i = 0; i < positions_.size(); ++i) {
            const Point3 p = positions_[i];
            if (is_out_[i] == 0)
                cells.emplace_back(std::floor(p.x / side), std::floor(p.y / side), std::floor(p.z / side), levels_[i],
                                   i);
        }
        std::ranges::sort(cells);
        std::vector<std::uint32_t> first;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const auto place = [&](std::size_t each) {
                return std::tie(std::get<0>(cells[each]), std::get<1>(cells[each]), std::get<2>(cells[each]));
            };
            if (i == 0 || place(i) != place(i - 1)) first.push_back(std::get<4>(cells[i]));
        }
        std::ranges::sort(first);
        return first;
    }

    std::vector<std::uint32_t> take() { return std::move(chosen_); }

private:
    static constexpr std::uint32_t kAbsent = std::numeric_limits<std::uint32_t>::max();

    /// Smaller entries are chosen first: level, degree, and number of a candidate.
    using Entry = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;

    /// Returns the rank of each priority; 0 for the highest one.
    std::vector<std::uint32_t> levels_of(std::span<const double> priorities) const {
        std::vector<std::uint32_t> levels(positions_.size(), 0);
        std::vector<double> sorted(priorities.begin(), priorities.end());
        std::ranges::sort(sorted, std::greater<>());
        for (std::size_t i = 0; i < priorities.size(); ++i)
            levels[i] = static_cast<std::uint32_t>(std::ranges::lower_bound(sorted, priorities[i], std::greater<>()) -
                                                   sorted.begin());
        return levels;
    }

    Entry entry_of(std::uint32_t candidate) const { return {levels_[candidate], degrees_[candidate], candidate}; }

    /// Calls function(number) for the candidates that are too near to one.
    template <class Function>
    void for_near(std::uint32_t candidate, Function&& function) const {
        constexpr double kDiagonal = 2;  // of the box, at least
        const Point3 p = positions_[candidate];
        cells_.for_near(p, std::min(spacing_, kDiagonal), [&](Point3 other, std::uint32_t number) {
            const Point3 apart = other - p;
            if (number != candidate && dot(apart, apart) < spacing_ * spacing_) function(number);
        });
    }

    std::span<const Point3> positions_;
    double spacing_;
    CellList3 cells_;
    std::vector<std::uint32_t> levels_;
    std::vector<std::uint8_t> is_out_;    ///< 1 for chosen and for excluded candidates
    std::vector<std::uint32_t> degrees_;  ///< number of neighbours that are not excluded; kAbsent: not in the graph
    std::vector<std::uint32_t> excluded_;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
    std::vector<std::uint32_t> chosen_;
};

}  // namespace

std::vector<std::uint32_t> pack(std::span<const Point3> positions, Point3 torus, bool is_solid,
                                std::span<const double> priorities, std::span<const std::uint8_t> kept, double spacing,
                                const std::stop_token& stop) {
    Packing packing(positions, torus, priorities, spacing);
    for (std::uint32_t i = 0; i < positions.size(); ++i)
        if (kept[i] != 0) packing.choose(i);
    packing.run(packing.representatives(is_solid), stop);
    packing.fill(stop);
    return packing.take();
}

}  // namespace ccdt::choice
