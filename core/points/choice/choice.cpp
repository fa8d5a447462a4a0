// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/choice/choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include "core/base/elementary.h"
#include "core/ccdt/polish/cell_list.h"
#include "core/geometry/axes.h"
#include "core/points/choice/exchange_search.h"
#include "core/points/choice/packing.h"
#include "core/points/order/progressive_order.h"

namespace ccdt {

namespace {

using choice::CandidateCells;
using choice::Extent;
using choice::PairEnergy;

/// Number of candidates in a small cell, half a spacing wide, that take part in the search. More would hardly make the
/// choice more even, and coincident candidates would take quadratic time.
constexpr std::size_t kMaxNear = 16;

/// Least number of candidates per cell on average, so that hardly any cells are empty by chance.
constexpr double kPerCell = 8;

/// Energy that a candidate with the highest priority saves, relative to one with the lowest. PairEnergy has the unit.
constexpr double kPriorityWeight = 0.5;

/// Least spacing, relative to the box. Coincident candidates may want a smaller one.
constexpr double kLeastSpacing = 1e-9;

/// Side of a torus in the plane along z.
constexpr double kFlat = 1e-6;

constexpr std::size_t kRange = 4'096;  ///< candidates per task

/// Returns the pair energy for a ratio of candidates to points. The more candidates there are, the farther apart points
/// can be. Test Choice requires the evenness. A larger core increases the distances, and the power of long
/// waves.
PairEnergy energy_for(double ratio, bool is_solid) {
    const double core = std::clamp(0.775 + 0.0385 * elementary::log2(ratio), 0.79, 0.95) * (is_solid ? 1.045 : 1);
    return {2.7F, 30, static_cast<float>(core)};
}

/// Returns the number of passes: fewer for many points, so that a choice of 100,000 among a million takes seconds.
int passes_for(std::size_t count) {
    return static_cast<int>(std::clamp(2e6 / static_cast<double>(count), 20.0, 200.0));
}

/// Returns the longest move, in spacings. Unless there are too few candidates, about a dozen free ones are in reach.
double move_reach_for(double ratio) {
    return std::clamp(2 / std::sqrt(ratio - 1), 1.2, 4.0);
}

/// Calls function(element) for `count` elements of a list, evenly spaced in it.
template <class Function>
void for_evenly(std::span<const std::uint32_t> list, std::size_t count, Function&& function) {
    for (std::size_t each = 0; each < count; ++each) function(list[(2 * each + 1) * list.size() / (2 * count)]);
}

Point3 torus_of(Point3 sides) {
    return {sides.x, sides.y, sides.z > 0 ? sides.z : kFlat};
}

/// Points that the cells want.
class WantedPoints {
public:
    struct Cell {
        double density;  ///< mean density of the candidates, times the weight of the cell
        double most;     ///< number of candidates
    };

    WantedPoints(std::vector<Cell> cells, double count) : cells_(std::move(cells)), count_(count) {
        scale_ = count / std::accumulate(cells_.begin(), cells_.end(), 0.0,
                                         [](double sum, const Cell& cell) { return sum + cell.density; });
    }

    /// Returns the wanted points that exceed the candidates of a block.
    double shortfall(const CandidateCells::Range& block) const {
        double rest = 0;
        for (std::size_t cell = block.begin; cell < block.end; ++cell)
            rest += scale_ * cells_[cell].density - cells_[cell].most;
        return std::max(0.0, rest);
    }

    /// Distributes the points that full cells lack to the remaining cells.
    void share_out() {
        constexpr int kMaxRounds = 50;
        for (int round = 0; round < kMaxRounds; ++round) {
            double full = 0, rest = 0;
            for (const Cell& cell : cells_) (is_full(cell) ? full : rest) += is_full(cell) ? cell.most : cell.density;
            const double larger = (count_ - full) / rest;
            if (rest == 0 || !(larger > scale_)) return;
            scale_ = larger;
        }
    }

    double in(std::size_t cell) const { return std::min(cells_[cell].most, scale_ * cells_[cell].density); }
    /// Returns the points that a cell with a given density wants.
    double at(double density) const { return scale_ * density; }

private:
    bool is_full(const Cell& cell) const { return scale_ * cell.density >= cell.most; }

    std::vector<Cell> cells_;
    double count_, scale_ = 1;
};

/// Chooses some of the candidates, which lie in a box from the origin whose longest side is 1.
class Chooser {
public:
    struct Input {
        std::vector<Point3> positions;
        std::vector<double> density, priority;  ///< priorities are in [0, 1]
        std::vector<std::uint8_t> kept;
        Point3 sides;
        Extent extent = Extent::Plane;
        bool is_torus = false;
    };

    Chooser(const Input& input, std::size_t count, Executor& executor)
        : input_(input),
          count_(count),
          executor_(executor),
          cells_(input.positions, input.sides, input.extent,
                 std::max(1.0, std::min(static_cast<double>(count), static_cast<double>(size()) / kPerCell)), executor),
          wanted_(wanted_cells(), static_cast<double>(count)),
          cell_of_(size()),
          is_chosen_(size(), 0) {
        for (const auto& block : cells_.blocks()) {
            const double points = wanted_.shortfall(block);
            if (points > 0) shortfalls_.push_back({cells_.rows()[cells_.cells()[block.begin].begin], points});
        }
        wanted_.share_out();
        for (const double density : input.density) spacings_.push_back(spacing_at(density));
        for (std::uint32_t cell = 0; cell < cells_.cells().size(); ++cell) {
            const auto& range = cells_.cells()[cell];
            for (std::size_t each = range.begin; each < range.end; ++each) cell_of_[cells_.rows()[each]] = cell;
        }
    }

    /// Returns the regions with too few candidates.
    std::span<const Shortfall> shortfalls() const { return shortfalls_; }

    /// Makes a first choice. May be called once.
    void start() {
        select();
        if (selected_.size() > count_) choose_first();
    }

    /// Improves the choice.
    /// @param energy  [n] energy of each candidate besides that of the pairs, or empty
    void improve(std::span<const float> energy, std::uint64_t seed, const std::stop_token& stop) {
        if (selected_.size() > count_ && count_ > 0 && !stop.stop_requested()) search(energy, seed, stop);
    }

    const Input& input() const { return input_; }
    std::size_t count() const { return count_; }
    /// Returns the choice: 1 for chosen candidates.
    const std::vector<std::uint8_t>& is_chosen() const { return is_chosen_; }
    std::size_t selected() const { return selected_.size(); }
    double spacing(std::size_t candidate) const { return static_cast<double>(spacings_[candidate]); }

    /// Calls function(centre, points) for the cells, with the number of points that a cell wants.
    template <class Function>
    void for_wanted(Function&& function) const {
        for (std::size_t cell = 0; cell < cells_.cells().size(); ++cell)
            function(cells_.centre(cells_.cells()[cell]), wanted_.in(cell));
    }

    /// Returns the sides of the torus; 0 if the box is none.
    Point3 torus() const { return input_.is_torus ? torus_of(input_.sides) : Point3{}; }

private:
    std::size_t size() const { return input_.positions.size(); }

    /// Returns the weight of each cell: 1 or, on a surface, which meets more cells where it is oblique to them, a
    /// number that makes the weight of the cells in a neighbourhood the same everywhere. The mean is 1.
    std::vector<double> weights() const {
        std::vector<double> weights(cells_.cells().size(), 1);
        if (input_.extent != Extent::Surface) return weights;
        constexpr double kReach = 3;  // relative to the side of a square with the area of a cell
        const double reach = kReach * std::sqrt(cells_.size());
        const std::vector<Point3> centres = cell_centres();
        const CellList3 near(centres);
        for (std::size_t cell = 0; cell < centres.size(); ++cell) {
            double sum = 0;
            near.for_near(centres[cell], reach, [&](Point3 other, std::uint32_t) {
                const Point3 apart = other - centres[cell];
                sum += PairEnergy::soft(dot(apart, apart) / (reach * reach));
            });
            weights[cell] = 1 / sum;
        }
        const double mean = std::accumulate(weights.begin(), weights.end(), 0.0) / static_cast<double>(weights.size());
        for (double& weight : weights) weight /= mean;
        return weights;
    }

    std::vector<Point3> cell_centres() const {
        std::vector<Point3> centres;
        for (const auto& cell : cells_.cells()) centres.push_back(cells_.centre(cell));
        return centres;
    }

    std::vector<WantedPoints::Cell> wanted_cells() const {
        std::vector<WantedPoints::Cell> cells;
        const std::vector<double> weights = this->weights();
        for (const auto& cell : cells_.cells()) {
            double sum = 0;
            for (std::size_t each = cell.begin; each < cell.end; ++each) sum += input_.density[cells_.rows()[each]];
            const auto candidates = static_cast<double>(cell.size());
            cells.push_back({weights[cells.size()] * sum / candidates, candidates});
        }
        return cells;
    }

    float spacing_at(double density) const {
        const double part = cells_.size() / wanted_.at(density);
        const double side = input_.extent == Extent::Solid ? elementary::cbrt(part) : std::sqrt(part);
        return static_cast<float>(std::clamp(side, kLeastSpacing, 1.0));
    }

    bool is_better(std::uint32_t i, std::uint32_t j) const {
        if (input_.kept[i] != input_.kept[j]) return input_.kept[i] > input_.kept[j];
        return input_.priority[i] > input_.priority[j];
    }

    /// Selects the candidates that take part in the search. If they are too few, chooses all of them and some others.
    void select() {
        std::vector<std::uint32_t> others, near;
        for (std::size_t begin = 0; begin < size();) {
            const double side = static_cast<double>(spacings_[cells_.rows()[begin]]) / 2;
            const auto cell = cells_.small_cell(begin, side);
            begin = cell.end;
            const auto rows = cells_.rows().subspan(cell.begin, cell.size());
            near.assign(rows.begin(), rows.end());
            if (near.size() > kMaxNear)
                std::ranges::stable_sort(near, [&](std::uint32_t i, std::uint32_t j) { return is_better(i, j); });
            for (std::size_t each = 0; each < near.size(); ++each)
                (each < kMaxNear || input_.kept[near[each]] != 0 ? selected_ : others).push_back(near[each]);
        }
        if (selected_.size() > count_) return;
        for (const std::uint32_t i : selected_) is_chosen_[i] = 1;
        for_evenly(others, count_ - selected_.size(), [&](std::uint32_t i) { is_chosen_[i] = 1; });
    }

    /// Chooses points along the curve, such that each part of it has the points that it wants, rounded up or down.
    void choose_first() {
        double carried = 0.5;
        std::size_t chosen = 0;
        for (std::size_t begin = 0, end = 0; begin < selected_.size(); begin = end) {
            const std::uint32_t cell = cell_of_[selected_[begin]];
            double kept = 0;
            while (end < selected_.size() && cell_of_[selected_[end]] == cell) kept += input_.kept[selected_[end++]];
            const double share =
                std::max(0.0, wanted_.in(cell)-kept) / std::max(1.0, static_cast<double>(end - begin) - kept);
            for (std::size_t each = begin; each < end; ++each) {
                const std::uint32_t i = selected_[each];
                carried += input_.kept[i] != 0 ? 1 : share;
                if (input_.kept[i] == 0 && carried < 1) continue;
                carried -= 1;
                is_chosen_[i] = 1;
                ++chosen;
            }
        }
        // Rounding, kept candidates, and those that were not selected change the number.
        const bool lacks = chosen < count_;
        std::vector<std::uint32_t> list;
        for (const std::uint32_t i : selected_)
            if (input_.kept[i] == 0 && (is_chosen_[i] == 0) == lacks) list.push_back(i);
        for_evenly(list, lacks ? count_ - chosen : chosen - count_,
                   [&](std::uint32_t i) { is_chosen_[i] = lacks ? 1 : 0; });
    }

    /// Returns the energy that the chosen points around each selected candidate should have, due to the soft part of
    /// the pair energy: the sum over the cells around it.
    std::vector<float> wanted_energies(const PairEnergy& energy) const {
        const std::vector<Point3> centres = cell_centres();
        const CellList3 near = input_.is_torus ? CellList3(torus(), centres) : CellList3(centres);
        std::vector<float> wanted(selected_.size());
        for_ranges(executor_, selected_.size(), kRange, [&](std::size_t begin, std::size_t end) {
            for (std::size_t each = begin; each < end; ++each) {
                const Point3 p = input_.positions[selected_[each]];
                const double reach =
                    static_cast<double>(energy.reach) * static_cast<double>(spacings_[selected_[each]]);
                double sum = 0;
                near.for_near(p, reach, [&](Point3 centre, std::uint32_t cell) {
                    const Point3 apart = p - centre;
                    sum += wanted_.in(cell)*energy.soft(dot(apart, apart) / (reach * reach));
                });
                wanted[each] = static_cast<float>(sum);
            }
        });
        return wanted;
    }

    /// Returns the logarithm of the number of selected candidates per wanted point, around each selected candidate.
    std::vector<float> crowding() const {
        std::vector<double> numbers(cells_.cells().size(), 0);
        for (const std::uint32_t i : selected_) ++numbers[cell_of_[i]];
        std::vector<float> crowding;
        for (const std::uint32_t i : selected_)
            crowding.push_back(static_cast<float>(elementary::log(numbers[cell_of_[i]] / wanted_.in(cell_of_[i]))));
        return crowding;
    }

    void search(std::span<const float> besides, std::uint64_t seed, const std::stop_token& stop) {
        const double ratio = static_cast<double>(selected_.size()) / static_cast<double>(count_);
        const PairEnergy energy = energy_for(ratio, input_.extent == Extent::Solid);
        std::vector<float> wanted = wanted_energies(energy);
        std::vector<Point3> positions;
        std::vector<float> spacings;
        std::vector<std::uint8_t> fixed, chosen;
        for (std::size_t each = 0; each < selected_.size(); ++each) {
            const std::uint32_t i = selected_[each];
            wanted[each] +=
                static_cast<float>(kPriorityWeight * input_.priority[i]) - (besides.empty() ? 0 : besides[i]);
            positions.push_back(input_.positions[i]);
            spacings.push_back(spacings_[i]);
            fixed.push_back(input_.kept[i]);
            chosen.push_back(is_chosen_[i]);
        }
        choice::exchange({positions, spacings, wanted, crowding(), fixed, torus()},
                         {energy, move_reach_for(ratio), passes_for(count_), seed}, chosen, stop, executor_);
        for (std::size_t each = 0; each < selected_.size(); ++each) is_chosen_[selected_[each]] = chosen[each];
    }

    const Input& input_;
    std::size_t count_;
    Executor& executor_;
    CandidateCells cells_;
    WantedPoints wanted_;
    std::vector<float> spacings_;  ///< spacing of chosen points around each candidate
    std::vector<Shortfall> shortfalls_;
    std::vector<std::uint32_t> cell_of_;   ///< number of the cell of each candidate
    std::vector<std::uint32_t> selected_;  ///< candidates that take part in the search
    std::vector<std::uint8_t> is_chosen_;
};

tl::unexpected<Error> not_finite(const char* list, std::size_t index, const char* rule) {
    const std::string field = list + ("/" + std::to_string(index));
    return failure(ErrorCode::Malformed, field + " must be " + rule, field);
}

Result<void> check(const Candidates& candidates) {
    for (std::size_t i = 0; i < candidates.positions.size(); ++i) {
        const Point3 p = candidates.positions[i];
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            return not_finite("candidates", i, "finite");
    }
    for (std::size_t i = 0; i < candidates.density.size(); ++i) {
        if (!std::isfinite(candidates.density[i]) || candidates.density[i] < 0)
            return not_finite("density", i, "finite and at least 0");
    }
    for (std::size_t i = 0; i < candidates.priority.size(); ++i) {
        if (!std::isfinite(candidates.priority[i])) return not_finite("priority", i, "finite");
    }
    return {};
}

/// Maps candidates into a box from the origin, whose longest side is 1. Halves avoid overflow.
struct Frame {
    Point3 origin;     ///< half of it
    double scale = 1;  ///< half of the longest side
    Point3 sides;

    Frame(const Candidates& candidates, std::span<const std::uint32_t> rows) {
        Box3 box{candidates.positions[rows.front()], candidates.positions[rows.front()]};
        for (const std::uint32_t row : rows) {
            const std::array<Point3, 3> corners{box.min, box.max, candidates.positions[row]};
            box = bounds_of(corners);
        }
        if (candidates.torus) box = {{}, *candidates.torus};
        origin = by_axis<Point3>([&](std::size_t axis) { return along(box.min, axis) / 2; });
        const auto half = [&](std::size_t axis) { return along(box.max, axis) / 2 - along(origin, axis); };
        const double longest = std::max({half(0), half(1), half(2)});
        scale = longest > 0 ? longest : 1;
        sides = by_axis<Point3>([&](std::size_t axis) { return half(axis) / scale; });
    }

    Point3 operator()(Point3 p) const {
        return by_axis<Point3>([&](std::size_t axis) {
            return std::clamp((along(p, axis) / 2 - along(origin, axis)) / scale, 0.0, along(sides, axis));
        });
    }
};

/// Candidates of a class that can be chosen.
struct Part {
    std::vector<std::uint32_t> rows;
    std::size_t kept = 0, count = 0;
    Chooser::Input input;
    std::unique_ptr<Chooser> chooser;  ///< null if no point is wanted
};

/// Returns the classes; a single one if candidates have none.
std::vector<Part> parts_of(const Candidates& candidates) {
    std::size_t classes = 1;
    for (const std::uint32_t each : candidates.classes) classes = std::max(classes, std::size_t{each} + 1);
    std::vector<Part> parts(std::max(classes, candidates.counts.size()));
    for (std::uint32_t row = 0; row < candidates.positions.size(); ++row) {
        Part& part = parts[candidates.classes.empty() ? 0 : candidates.classes[row]];
        const bool is_kept = !candidates.kept.empty() && candidates.kept[row] != 0;
        part.kept += is_kept ? 1 : 0;
        if (is_kept || candidates.density.empty() || candidates.density[row] > 0) part.rows.push_back(row);
    }
    return parts;
}

/// Gives each class its count, or a share of `count` in proportion to its candidates.
Result<void> set_counts(const Candidates& candidates, std::size_t count, std::vector<Part>& parts) {
    std::size_t kept = 0, eligible = 0;
    for (const Part& part : parts) kept += part.kept, eligible += part.rows.size();
    if (kept > count)
        return failure(
            ErrorCode::Unusable,
            std::to_string(kept) + " candidates are kept, but there are only " + std::to_string(count) + " sites",
            "keep");
    if (count > eligible)
        return failure(ErrorCode::Unusable,
                       "only " + std::to_string(eligible) +
                           " candidates have a density above 0 or are kept, but there are " + std::to_string(count) +
                           " sites",
                       "sites");
    for (std::size_t number = 0; number < candidates.counts.size(); ++number) {
        Part& part = parts[number];
        part.count = candidates.counts[number];
        if (part.count > part.rows.size() || part.count < part.kept)
            return failure(ErrorCode::Unusable,
                           "of the class with the index " + std::to_string(number) + ", " + std::to_string(part.count) +
                               " sites are wanted, but it has " + std::to_string(part.rows.size()) +
                               " candidates that have a density above 0 or are kept, and " + std::to_string(part.kept) +
                               " of them are kept",
                           "sites");
    }
    if (!candidates.counts.empty()) return {};
    // Kept candidates first, then the rest by the largest remainders.
    const auto free = static_cast<double>(eligible - kept), wanted = static_cast<double>(count - kept);
    std::vector<std::pair<double, std::size_t>> remainders;
    std::size_t rest = count - kept;
    for (std::size_t number = 0; number < parts.size(); ++number) {
        Part& part = parts[number];
        const double share = free > 0 ? wanted * static_cast<double>(part.rows.size() - part.kept) / free : 0;
        part.count = part.kept + static_cast<std::size_t>(share);
        rest -= static_cast<std::size_t>(share);
        remainders.emplace_back(std::floor(share) - share, number);
    }
    std::ranges::sort(remainders);
    for (std::size_t i = 0; rest > 0; i = (i + 1) % parts.size()) {
        Part& part = parts[remainders[i].second];
        if (part.count < part.rows.size()) ++part.count, --rest;
    }
    return {};
}

Chooser::Input input_of(const Candidates& candidates, std::span<const std::uint32_t> rows, const Frame& frame) {
    constexpr double kLeastDensity = 1e-12;  // relative to the highest one
    Chooser::Input input;
    input.extent = candidates.extent;
    input.is_torus = candidates.torus.has_value();
    input.sides = frame.sides;
    const auto [least, most] = candidates.priority.empty() ? std::ranges::minmax_result<double>{0, 0}
                                                           : std::ranges::minmax(candidates.priority);
    const double range = most / 2 - least / 2;
    double highest = 0;
    for (const std::uint32_t row : rows)
        highest = candidates.density.empty() ? 0 : std::max(highest, candidates.density[row]);
    for (const std::uint32_t row : rows) {
        input.positions.push_back(frame(candidates.positions[row]));
        input.density.push_back(highest > 0 ? std::max(kLeastDensity, candidates.density[row] / highest) : 1);
        input.priority.push_back(range > 0 ? (candidates.priority[row] / 2 - least / 2) / range : 0);
        input.kept.push_back(!candidates.kept.empty() && candidates.kept[row] != 0 ? 1 : 0);
    }
    return input;
}

/// Returns the energy of the candidates of a class due to the chosen points of the others. The energy that the others
/// should have is subtracted, so that a class does not avoid regions where others are dense.
std::vector<float> energy_of_others(const std::vector<Part>& parts, const Part& part, Executor& executor) {
    std::vector<Point3> chosen, centres;
    std::vector<double> wanted;
    std::size_t count = 0, selected = 0;
    for (const Part& other : parts) {
        if (!other.chooser) continue;
        count += other.count;
        selected += other.chooser->selected();
        if (&other == &part) continue;
        for (std::size_t i = 0; i < other.rows.size(); ++i)
            if (other.chooser->is_chosen()[i] != 0) chosen.push_back(other.input.positions[i]);
        other.chooser->for_wanted([&](Point3 centre, double points) {
            centres.push_back(centre);
            wanted.push_back(points);
        });
    }
    const bool is_solid = part.input.extent == Extent::Solid;
    const PairEnergy pair = energy_for(static_cast<double>(selected) / static_cast<double>(count), is_solid);
    const double share = static_cast<double>(part.count) / static_cast<double>(count);
    const double closer = is_solid ? elementary::cbrt(share) : std::sqrt(share);
    const Point3 torus = part.chooser->torus();
    const auto cells_of = [&](const std::vector<Point3>& points) {
        return part.input.is_torus ? CellList3(torus, points) : CellList3(points);
    };
    const CellList3 near_points = cells_of(chosen), near_cells = cells_of(centres);
    std::vector<float> energies(part.rows.size());
    for_ranges(executor, energies.size(), kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Point3 p = part.input.positions[i];
            const double spacing = closer * part.chooser->spacing(i);
            const double reach = spacing * static_cast<double>(pair.reach);
            const double core = spacing * static_cast<double>(pair.core_reach);
            double sum = 0;
            near_points.for_near(p, reach, [&](Point3 point, std::uint32_t) {
                const Point3 apart = p - point;
                const double square = dot(apart, apart), rest = std::max(0.0, 1 - square / (core * core));
                sum += PairEnergy::soft(square / (reach * reach)) +
                       static_cast<double>(pair.core) * rest * rest * rest * rest;
            });
            near_cells.for_near(p, reach, [&](Point3 centre, std::uint32_t cell) {
                const Point3 apart = p - centre;
                sum -= wanted[cell] * PairEnergy::soft(dot(apart, apart) / (reach * reach));
            });
            energies[i] = static_cast<float>(sum);
        }
    });
    return energies;
}

/// Chooses points of each class by themselves, then each class again with regard to the others.
void choose(std::vector<Part>& parts, std::uint64_t seed, const std::stop_token& stop, Executor& executor) {
    constexpr int kRounds = 2;
    constexpr std::uint64_t kStride = 0x9E3779B97F4A7C15;  // of seeds
    std::size_t classes = 0;
    for (Part& part : parts) {
        if (!part.chooser) continue;
        part.chooser->start();
        part.chooser->improve({}, seed + kStride * classes++, stop);
    }
    for (int round = 0; classes > 1 && round < kRounds; ++round) {
        for (Part& part : parts) {
            if (!part.chooser || stop.stop_requested()) continue;
            part.chooser->improve(energy_of_others(parts, part, executor), seed + kStride * classes++, stop);
        }
    }
}

}  // namespace

Result<ChosenCandidates> choose_points(const Candidates& candidates, std::size_t count, std::uint64_t seed,
                                       const std::stop_token& stop, Executor& executor) {
    if (auto checked = check(candidates); !checked) return tl::unexpected(checked.error());
    std::vector<Part> parts = parts_of(candidates);
    if (auto counted = set_counts(candidates, count, parts); !counted) return tl::unexpected(counted.error());
    if (count == 0) return ChosenCandidates{};
    std::vector<std::uint32_t> eligible;
    for (const Part& part : parts) eligible.insert(eligible.end(), part.rows.begin(), part.rows.end());
    const Frame frame(candidates, eligible);
    ChosenCandidates result;
    double shortfall = 0;
    for (Part& part : parts) {
        if (part.count == 0) continue;
        part.input = input_of(candidates, part.rows, frame);
        part.chooser = std::make_unique<Chooser>(part.input, part.count, executor);
        if (part.count == part.rows.size()) continue;
        for (const Shortfall& each : part.chooser->shortfalls()) {
            shortfall += each.points;
            result.shortfalls.push_back({part.rows[each.row], each.points});
        }
    }
    result.shortfall = static_cast<std::size_t>(shortfall);
    std::ranges::stable_sort(result.shortfalls, std::greater<>(), &Shortfall::points);
    choose(parts, seed, stop, executor);
    for (const Part& part : parts) {
        for (std::size_t i = 0; part.chooser && i < part.rows.size(); ++i)
            if (part.chooser->is_chosen()[i] != 0) result.rows.push_back(part.rows[i]);
    }
    std::ranges::sort(result.rows);
    return result;
}

Result<ChosenCandidates> choose_apart(const Candidates& candidates, double spacing, const std::stop_token& stop) {
    if (auto checked = check(candidates); !checked) return tl::unexpected(checked.error());
    const std::vector<Part> parts = parts_of(candidates);
    const std::vector<std::uint32_t>& rows = parts.front().rows;
    if (rows.empty()) return ChosenCandidates{};
    const Frame frame(candidates, rows);
    std::vector<Point3> positions;
    std::vector<double> priorities;
    std::vector<std::uint8_t> kept;
    for (const std::uint32_t row : rows) {
        positions.push_back(frame(candidates.positions[row]));
        if (!candidates.priority.empty()) priorities.push_back(candidates.priority[row]);
        kept.push_back(!candidates.kept.empty() && candidates.kept[row] != 0 ? 1 : 0);
    }
    const Point3 torus = candidates.torus ? torus_of(frame.sides) : Point3{};
    ChosenCandidates result;
    for (const std::uint32_t each : choice::pack(positions, torus, candidates.extent == Extent::Solid, priorities, kept,
                                                 spacing / 2 / frame.scale, stop))
        result.rows.push_back(rows[each]);
    std::ranges::sort(result.rows);
    return result;
}

std::vector<std::uint32_t> order_choice(const Candidates& candidates, const std::vector<std::uint32_t>& rows,
                                        const std::stop_token& stop, Executor& executor) {
    if (rows.size() < 2) return rows;
    constexpr double kLeastSide = 1e-6;  // of a box around points that lie in a plane
    const Frame frame(candidates, rows);
    std::vector<Point3> positions;
    for (const std::uint32_t row : rows) positions.push_back(frame(candidates.positions[row]));
    const Point3 sides =
        by_axis<Point3>([&](std::size_t axis) { return std::max(kLeastSide, along(frame.sides, axis)); });
    std::vector<std::uint32_t> order;
    if (candidates.extent == Extent::Solid) {
        order = progressive_order_in_space({{}, sides}, false, positions, 1, false, stop, executor);
    } else {
        // Nothing is known about the sides of a surface.
        const std::vector<Point3> normals(rows.size(), {0, 0, 1});
        const double area = std::max({sides.x * sides.y, sides.y * sides.z, sides.z * sides.x});
        order = progressive_order_on_surface(positions, normals, area, false, false, stop, executor);
    }
    for (std::uint32_t& each : order) each = rows[each];
    return order;
}

}  // namespace ccdt
